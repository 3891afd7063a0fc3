"""Largest stable steps of coupled oscillators; tests/benchmark/stability.py makes the whole table.

`jacobi` is the scheme of masters that exchange fresh values along feed-through: its limits are
known from the spectral radius of the recursion with exactly integrated components.
"""

from __future__ import annotations

import pytest
from support.small_systems import Fmus
from support.stability import ALGORITHMS, OBSERVED, PAIRS, Pair, growth, pair

SOFT, STIFF = "spring 1 N/m, damper 0.1 N·s/m", "spring 10"
STIFFER, HEAVY_B = "spring 100, damper 1", "spring 10, damper 1, masses 1 and 10"
HEAVY_A = "spring 10, damper 1, masses 10 and 1"


def grows(fmus: Fmus, name: str, how: str, algorithm: str, step: float) -> bool:
    make = pair(fmus, PAIRS[name], how, *ALGORITHMS[algorithm])
    return growth(make(round(step, 6)), OBSERVED[how]) > 1


@pytest.mark.verifies(
    "largest stable step of `jacobi`, two masses in nine variants: 0.0134 to 1.36 s",
    analytic="spectral radius of the recursion",
    tolerance="2 %",
)
@pytest.mark.parametrize(
    ("name", "how", "limit"),
    [
        (SOFT, "fd", 0.405),
        (SOFT, "dd", 0.628),
        (STIFF, "fd", 0.01337),
        (STIFF, "dd", 0.0201),
        (STIFFER, "fd", 0.0281),
        (STIFFER, "dd", 0.0424),
        (HEAVY_B, "fd", 0.219),
        (HEAVY_A, "fd", 1.36),
        ("quarter car", "fd", 0.165),
    ],
)
def test_jacobi_is_stable_as_far_as_theory_says(
    c_fmu: Fmus, name: str, how: str, limit: float
) -> None:
    # 2 %: the limits are known to three digits, and an eigenvalue near 1 takes a few more steps
    assert not grows(c_fmu, name, how, "jacobi", 0.98 * limit)
    assert grows(c_fmu, name, how, "jacobi", 1.02 * limit)


@pytest.mark.parametrize("algorithm", ["corrector, held", "corrector, followed"])
@pytest.mark.parametrize(("how", "best"), [("fd", 0.0401), ("dd", 0.0201)])
def test_the_default_is_stable_at_ten_times_the_steps_of_explicit_masters(
    c_fmu: Fmus, how: str, best: float, algorithm: str
) -> None:
    """`best` is the largest stable step of the schemes that hold their inputs."""
    for share in (1, 2, 5, 10):
        assert not grows(c_fmu, STIFF, how, algorithm, share * best)


@pytest.mark.verifies(
    "growth per step of two undamped masses: none by default, 3H²/8 and H²/4 with `jacobi`",
    analytic="spectral radius of the recursion; energy is conserved",
    tolerance="1e-9",
)
@pytest.mark.parametrize(("how", "rate"), [("fd", 3 / 8), ("dd", 1 / 4)])
def test_what_is_not_damped(c_fmu: Fmus, how: str, rate: float) -> None:
    step = 0.1

    def grown(algorithm: str) -> float:
        make = pair(c_fmu, Pair(loss=(0.0, 0.0)), how, *ALGORITHMS[algorithm])
        return growth(make(step), OBSERVED[how]) - 1

    # the next term of the theory's growth is of the order H⁴
    assert grown("jacobi") == pytest.approx(rate * step**2, rel=step**2)
    # a scheme of fourth order leaves terms of (1.7 H)⁶ with small factors, a solved step rounding
    for inputs in ("held", "followed"):
        assert abs(grown(f"corrector, {inputs}")) < 1e-9
        assert abs(grown(f"implicit, {inputs}")) < 1e-11
