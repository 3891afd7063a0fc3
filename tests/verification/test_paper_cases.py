"""The paper's systems against another formulation, and against SymPy's own equations.

The reference holds all bodies together by Lagrange multipliers (support/maximal_coordinates.py),
with a tolerance of 1e-13. Errors are the paper's, Eqs. (9) to (11). The double pendulum released
from -4 rad is left out: it is chaotic.
"""

from __future__ import annotations

import importlib.util
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import paper_listings
from support.kane import KaneSystem
from support.maximal_coordinates import trajectories
from support.paper_metric import body_errors
from support.periods import FAST_HEAVE, SLOW_HEAVE, SWAY, pendulum_periods
from support.programs import Evaluated

from m4e_fmi.model import Model, load_model, model_from_lists
from m4e_fmi.multibody import model_program
from m4e_fmi.runtime.engine import Control, Engine, Integrator
from m4e_fmi.simulate import simulate

EXAMPLES = Path(__file__).parents[2] / "examples" / "paper_cases"
STOP = {  # s, as in the paper; the flexible pendulum's 80 s are for its periods
    "small_double_pendulum": 30.0,
    "cart": 100.0,
    "spiderfloat": 10.0,
    "flexible_pendulum": 20.0,
    "double_pendulum": 10.0,
    "foswec": 10.0,
    "flap": 10.0,
}
ROWS = 201


def lists(name: str) -> dict[str, Any]:
    return getattr(paper_listings, name)()


def model(name: str) -> Model:
    return model_from_lists(lists(name), name=name)


@cache
def reference(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Output times and x, z, θ of every body."""
    times = np.linspace(0.0, STOP[name], ROWS)
    return times, trajectories(lists(name), times)


def motion_of(values: Any, bodies: int) -> np.ndarray:
    columns = [values[f"body.body_{k + 1}.{c}"] for k in range(bodies) for c in ("x", "z", "theta")]
    return np.column_stack(columns)


@pytest.mark.verifies(
    "seven systems of the paper at rtol = atol = 1e-10, error by Eq. (10)",
    independent="maximal coordinates with Lagrange multipliers at 1e-13",
    tolerance="1e-7",
)
@pytest.mark.parametrize("name", STOP)
def test_trajectories(name: str) -> None:
    times, expected = reference(name)
    result = simulate(model(name), stop_time=STOP[name], output_interval=times[1], tolerance=1e-10)
    errors = body_errors(motion_of(result, expected.shape[1] // 3), expected)
    assert errors.max() < 1e-7
    # rounding of a motion of a few thousand steps: far below any tolerance asked for
    tight = simulate(model(name), stop_time=STOP[name], output_interval=times[1], tolerance=1e-13)
    assert body_errors(motion_of(tight, expected.shape[1] // 3), expected).max() < 1e-10


@pytest.mark.parametrize("name", [name for name in STOP if name != "double_pendulum"])
def test_the_example_is_the_system_of_the_lists(name: str) -> None:
    """The same rates of the same states, the names apart; another order of operations rounds."""
    ours = Evaluated(model_program(load_model(EXAMPLES / f"{name}.model.yaml")))
    listed = Evaluated(model_program(model(name)))
    rng = np.random.default_rng(9)
    states = [[v.name for v in program.program.states] for program in (ours, listed)]
    for _ in range(3):
        x, t = rng.uniform(-1.5, 1.5, len(states[0])), rng.uniform(0.0, 10.0)
        rates = [
            list(program.rates(dict(zip(names, x, strict=True)), t=t).values())
            for program, names in zip((ours, listed), states, strict=True)
        ]
        assert rates[0] == pytest.approx(rates[1], rel=1e-11, abs=1e-11)


def test_the_listing_as_an_example() -> None:
    """Where the right slider is after ten seconds, by the reference."""
    path = EXAMPLES / "spiderfloat_lists.py"
    spec = importlib.util.spec_from_file_location("spiderfloat_lists", path)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    _, expected = reference("spiderfloat")
    arm, slider = expected[-1, 3:6], expected[-1, 9:12]
    apart = np.hypot(*(slider - arm)[:2])  # 5 m, and what it has slid
    assert script.simulation()["joint.joint_4.q"][-1] == pytest.approx(apart - 5, abs=1e-6)


@pytest.mark.verifies(
    "error over tolerance, those of table 9",
    analytic="proportional under error control by step",
    tolerance="slope 1 ± 0.1",
)
@pytest.mark.parametrize("method", ["rk45", "dop853"])
def test_convergence_over_the_tolerances_of_table_9(method: str) -> None:
    """With error control by step, the global error is proportional to the tolerance: slope 1.

    Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.4: the error of a step is
    kept at the tolerance, h ~ tol^(1/(p+1)) by the lower order p of the pair, and the higher order
    p + 1 goes on: h^(p+1) ~ tol. The paper's figure 11 shows the same.
    """
    times, expected = reference("cart")
    program = model_program(model("cart"))
    engine = Engine(program)
    tolerances, errors = 10.0 ** np.arange(-4, -13, -2), []
    for tolerance in tolerances:
        control = Control(method, rtol=tolerance, atol=1e-3 * tolerance)
        integrator = Integrator(engine, control)
        integrator.start(0.0, [v.start for v in program.states])
        states = integrator.advance(times, bound=times[-1])
        outputs = np.array([engine.outputs(t, x) for t, x in zip(times, states, strict=True)])
        values = dict(zip([v.name for v in program.outputs], outputs.T, strict=True))
        errors.append(body_errors(motion_of(values, 3), expected).max())
    assert all(later < earlier for earlier, later in pairwise(errors))
    slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.1)


@pytest.mark.verifies(
    "periods of the spring pendulum over 80 s",
    published="Sabet and Diaz-Flores Caminero, tables 11 and 12, in truth",
    tolerance="1e-4 s",
)
def test_periods_of_the_flexible_pendulum() -> None:
    """Tables 11 and 12 over 80 s."""
    pendulum = model("flexible_pendulum")
    result = simulate(pendulum, stop_time=80.0, output_interval=1e-3, tolerance=1e-11)
    times, x, z = result.time, result["body.body_1.x"], result["body.body_1.z"]
    found = pendulum_periods(times, x, z)
    assert found == pytest.approx((SWAY, SLOW_HEAVE, FAST_HEAVE), abs=1e-4)


def chain(links: int = 4) -> dict[str, Any]:
    """Rods of 2 m and 10 kg in a row, of table 5."""
    nan = [np.nan, np.nan]
    return {
        "joints": [[k, k + 1] for k in range(links)],
        "types": ["R"] * links,
        "parent_cg_to_joint": [[0, 0], *[[0, -1]] * (links - 1)],
        "joint_to_child_cg": [[0, -1]] * links,
        "prismatic_direction": [nan] * links,
        "m0": [10] * links,
        "J0": [10 / 3] * links,
        "g": 9.81,
    }


@pytest.mark.verifies(
    "accelerations of chains, cart and SpiderFLOAT",
    independent="SymPy's KanesMethod",
    tolerance="1e-10",
)
@pytest.mark.parametrize("name", ["chain", "cart", "spiderfloat"])
def test_accelerations_are_those_of_sympys_kane(name: str) -> None:
    given = chain() if name == "chain" else lists(name)
    program = Evaluated(model_program(model_from_lists(given)))
    kane = KaneSystem(given)
    states = [v.name for v in program.program.states]
    positions = [s for s in states if not s.endswith((".u", ".vx", ".vz", ".omega"))]
    velocities = [s for s in states if s not in positions]
    rng = np.random.default_rng(5)
    for _ in range(5):
        q, u = (rng.uniform(-1.5, 1.5, len(positions)) for _ in range(2))
        t = rng.uniform(0.0, 10.0)
        expected = kane.accelerations(q, u, t)
        values = dict(zip([*positions, *velocities], [*q, *u], strict=True))
        got = program.rates(values, t=t)
        # both solve in double precision a mass matrix with a condition number below 1e4
        bound = 1e-10 * np.abs(expected).max()
        assert [got[name] for name in velocities] == pytest.approx(expected, rel=0, abs=bound)
