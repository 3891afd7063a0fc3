"""Cases from the literature on co-simulation by the default algorithm: error and observed order.

References: exact solutions of linear systems; Roessler's system by DOP853 at a tolerance of 1e-13.
Quarter car: parameters of the OMSimulator and libcosim test cases (400 and 40 kg, 15 and 150 kN/m,
1 kN·s/m, road step 0.1 m). Oscillator with modes of 1 and 3 Hz: preCICE's tutorial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from support.small_systems import Fmus, watched

from m4e_fmi.cosim import Component, FmuFile, Simulation, System


@dataclass(frozen=True)
class Case:
    """Components as (name, model, start values), what they give at `stop`, and how close.

    `accuracy` is the largest error over the range of `exact` allowed at the first of `steps`.
    """

    name: str
    components: tuple[tuple[str, str, dict[str, float]], ...]
    connections: tuple[str, ...]
    stop: float
    exact: dict[str, float]
    steps: tuple[float, float, float]
    accuracy: float


def _halves(step: float) -> tuple[float, float, float]:
    return step, step / 2, step / 4


LOOP = expm(np.array([[-3.0, 3, 2], [-1, 0, 1], [0, 0, 0]]))[:2, 2]
MC, MW, KC, DC, KW = 400.0, 40.0, 15e3, 1e3, 150e3
CAR = expm(
    np.array(
        [
            [0, 1, 0, 0],
            [-KC / MC, -DC / MC, KC / MC, DC / MC],
            [0, 0, 0, 1],
            [KC / MW, DC / MW, -(KC + KW) / MW, -DC / MW],
        ]
    )
) @ [-0.1, 0, -0.1, 0]
RING = expm(np.roll(np.eye(5), 1, axis=0))[:, 0]
ONE = (2 * np.pi) ** 2


def _roessler(stop: float) -> dict[str, float]:
    def rates(_, s):
        x, y, z = s
        return -y - z, x + y / 5, 0.2 + z * (x - 5.7)

    end = solve_ivp(rates, (0, stop), (1, 1, 0), method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return dict(zip(("a.x", "b.y", "b.z"), end.tolist(), strict=True))


_ROESSLER = (("a", "roessler_x", {"x": 1.0}), ("b", "roessler_yz", {"y": 1.0}))
CASES = (
    Case(
        "control loop, PI and plant",
        (("a", "lag", {}), ("b", "pi", {})),
        ("a.y -> b.y", "b.u -> a.u"),
        1.0,
        dict(zip(("a.y", "b.integral"), LOOP.tolist(), strict=True)),
        _halves(0.1),
        1e-4,
    ),
    Case(
        "quarter car on a step",
        (
            ("a", "mass", {"mass": MC, "body.m.x": -0.1}),
            (
                "b",
                "partner",
                {"mass": MW, "stiffness": KW, "coupling": KC, "damping": DC, "x": -0.1},
            ),
        ),
        ("a.m <-> b.end",),
        1.0,
        dict(zip(("a.body.m.x", "a.body.m.vx", "b.x", "b.vx"), CAR.tolist(), strict=True)),
        _halves(0.01),
        1e-3,
    ),
    Case(
        "oscillator of 1 and 3 Hz",
        (
            ("a", "mass", {"stiffness": ONE, "body.m.x": 1.0}),
            ("b", "partner", {"stiffness": ONE, "coupling": 4 * ONE}),
        ),
        ("a.m <-> b.end",),
        1.0,
        {"a.body.m.x": 1.0, "a.body.m.vx": 0.0, "b.x": 0.0, "b.vx": 0.0},
        _halves(0.01),
        2e-3,
    ),
    Case(
        "Roessler's system, 5 s",
        _ROESSLER,
        ("a.x -> b.x", "b.y -> a.y", "b.z -> a.z"),
        5.0,
        _roessler(5.0),
        _halves(0.1),
        1e-3,
    ),
    Case(
        "Roessler's system, 20 s",
        _ROESSLER,
        ("a.x -> b.x", "b.y -> a.y", "b.z -> a.z"),
        20.0,
        _roessler(20.0),
        _halves(0.1),
        1e-3,
    ),
    Case(
        "ring of five integrators",
        tuple((f"c{k}", "integrator", {"y": 1.0 if k == 0 else 0.0}) for k in range(5)),
        tuple(f"c{k}.y -> c{(k + 1) % 5}.u" for k in range(5)),
        1.0,
        {f"c{k}.y": y for k, y in enumerate(RING.tolist())},
        _halves(0.1),
        1e-4,
    ),
)


def error(fmus: Fmus, case: Case, options: str, step: float) -> float:
    """Largest error at the end over the range of the exact values."""
    components = tuple(Component(n, FmuFile(fmus(m + options)), s) for n, m, s in case.components)
    settings = Simulation(case.stop, step)
    found = watched(System("s", components, case.connections, settings), *case.exact)[-1]
    exact = np.array(list(case.exact.values()))
    return float(np.abs(found - exact).max() / np.abs(exact).max())


@pytest.mark.verifies(
    "order by default: control loop, quarter car, oscillator, Roessler, ring",
    analytic="exact solution; DOP853 at 1e-13",
    tolerance="2.9",
)
@pytest.mark.parametrize("options", ["+state", "+state+inputs"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_order_and_error(c_fmu: Fmus, case: Case, options: str) -> None:
    errors = np.array([error(c_fmu, case, options, step) for step in case.steps])
    assert errors[0] < case.accuracy
    # third order is promised; the terms of the next order change it by 0.1 at these steps
    assert np.log2(errors[0] / errors[-1]) / 2 > 2.9


def test_references_are_the_published_ones() -> None:
    assert LOOP.tolist() == pytest.approx([0.9535762, 0.3832808], abs=5e-8)
    assert CAR[[0, 2]] + 0.1 == pytest.approx([0.0652894, 0.0966065], abs=5e-8)
    published = [-4.0477976, 7.1064401, 0.0298896]
    assert list(_roessler(20.0).values()) == pytest.approx(published, abs=1e-6)
