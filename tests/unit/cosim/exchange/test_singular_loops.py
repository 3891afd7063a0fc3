"""Algebraic loops: through scaled connections, and without a single solution, which zeros solve."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.cosim.exchange.newton import TOLERANCE
from m4e_fmi.errors import RunError


@pytest.mark.parametrize("options", ["+state", "+state+jacobian"])
def test_an_algebraic_loop_through_scaled_connections_is_solved(
    c_fmu: Callable[[str], Path], options: str
) -> None:
    """a.y = a.u + t, b.y = b.u + t with a.u = b.y/2 + 1 and b.u = a.y/2: a.y = 4/3 + 2 t."""
    parts = tuple(Component(name, FmuFile(c_fmu(f"stage{options}"))) for name in "ab")
    loop = ("b.y * 0.5 + 1 -> a.u", "a.y * 0.5 -> b.u")
    seen: list[tuple[float, float, float]] = []
    run(
        System("loop", parts, loop, Simulation(0.4, 0.1, "implicit")),
        observers=[lambda t, network: seen.append((t, network.read("a.y"), network.read("a.u")))],
    )
    for time, output, given in seen:
        assert output == pytest.approx(4 / 3 + 2 * time, abs=10 * TOLERANCE)
        assert given == pytest.approx(output - time, abs=1e-12)


@pytest.mark.parametrize("model", ["stage", "stage+jacobian"])
@pytest.mark.parametrize(
    ("a", "b", "singular"),
    [(1.0, 1.0, True), (3.0, 1.0 / 3.0, True), (1e6, 1e-6, True), (-1.0, 1.0, False),
     (1.001, 1.0, False), (1e6, -1e-6, False)],
)  # fmt: skip
def test_a_loop_with_the_gain_1_is_refused(
    c_fmu: Callable[[str], Path], model: str, a: float, b: float, singular: bool
) -> None:
    parts = tuple(
        Component(name, FmuFile(c_fmu(model)), {"gain": gain})
        for name, gain in (("a", a), ("b", b))
    )
    loop = System("two", parts, ("a.y -> b.u", "b.y -> a.u"), Simulation(0.3, 0.1))
    if singular:
        with pytest.raises(RunError, match=r"the algebraic loop of [ab]\.u.* is singular at t = 0"):
            run(loop)
    else:
        run(loop)
