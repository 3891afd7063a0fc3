"""Control and design examples, each compared with another source."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from m4e_fmi.analysis import linearize

EXAMPLES = Path(__file__).parents[2] / "examples"


def example(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(EXAMPLES / name))
    monkeypatch.delitem(sys.modules, name, raising=False)
    return importlib.import_module(name)


@pytest.mark.verifies(
    "path of a cart that balances a pole by feedback, 6 s",
    independent="the textbook's two equations, SciPy's DOP853",
    tolerance="1e-8 m",
)
def test_a_cart_balances_a_pole(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The cart's way, by the textbook's two equations of a cart with a pole.

    (M + m) ẍ + m l (θ̈ cos θ − θ̇² sin θ) = F, (J + m l²) θ̈ + m l ẍ cos θ = m g l sin θ.
    """
    cart_pole = example("cart_pole", monkeypatch)
    linear = cart_pole.upright()
    gain = cart_pole.regulator(linear)
    program = cart_pole.closed_loop(gain)
    run = cart_pole.balanced(program)
    M, m, length, g = 1.0, 0.2, 0.5, 9.81
    inertia = m * (2 * length) ** 2 / 12

    def rates(_: float, state: np.ndarray) -> list[float]:
        _, theta, speed, omega = state
        c, s = np.cos(theta), np.sin(theta)
        left = [[M + m, m * length * c], [m * length * c, inertia + m * length**2]]
        right = [-gain @ state + m * length * omega**2 * s, m * g * length * s]
        return [speed, omega, *np.linalg.solve(left, right)]

    start = [0.0, cart_pole.TILT, 0.0, 0.0]
    solution = solve_ivp(
        rates, (0, 6), start, method="DOP853", rtol=1e-10, atol=1e-10, t_eval=run.time
    )
    assert run["joint.rail.q"] == pytest.approx(solution.y[0], abs=1e-8)
    assert np.ptp(run["joint.rail.q"]) == pytest.approx(1.4710, abs=5e-5)
    assert abs(run["joint.pivot.q"][-1]) < 0.01
    closed = linear.A - linear.B @ gain[None, :]
    assert pytest.approx(closed, abs=1e-12) == linearize(program).A
    cart_pole.picture(run, tmp_path / "picture.png")


@pytest.mark.verifies(
    "optimal tuned mass damper, by exact gradients",
    published="Warburton (1982), table I",
    tolerance="1e-7",
)
def test_tuning_a_mass_damper(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Warburton's closed form of 1982; the gradient by central differences."""
    damper = example("tuned_mass_damper", monkeypatch)
    found, closed = damper.optimum(), damper.warburton()
    for name in damper.DESIGN:
        # the minimum is flat, but its gradient is zero to 1e-10 of the mean square
        assert found[name] == pytest.approx(closed[name], rel=1e-7)
    mean_square = damper.MeanSquare()
    place, step = np.log([2.2e4, 1.1e3]), 1e-5
    _, gradient = mean_square(place)
    for unit, slope in zip(np.eye(2), gradient, strict=True):
        ahead, behind = (mean_square(place + side * step * unit)[0] for side in (1, -1))
        # off by step² times the third derivative, some 1e2, and by rounding
        assert slope == pytest.approx((ahead - behind) / (2 * step), abs=1e-7)
    damper.picture({"a": found, "b": closed}, tmp_path / "picture.png")
