"""The implicit algorithm: stiff pairs, added mass, algebraic loops, and failure to converge.

Stiff pair: unit masses on springs of 1 N/m and dampers of 0.1 N·s/m, and 10 N/m between them;
explicit masters are stable below steps of 0.01 to 0.04 s, the best implicit one below 0.74 s. Added
mass that comes back as a force: explicit masters diverge where it exceeds the mass.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system, watched

from m4e_fmi.cosim import Simulation, System, run
from m4e_fmi.errors import RunError

OPTIONS = ("+state", "+state+inputs", "+state+jacobian")


@pytest.mark.parametrize("step", [0.1, 0.7, 0.74, 1.0, 1.3])
@pytest.mark.parametrize("options", OPTIONS[:2])
def test_stiff_pair_is_stable(c_fmu: Fmus, options: str, step: float) -> None:
    start = {
        "a": {"stiffness": 1.0, "damping": 0.1, "body.m.x": 1.0},
        "b": {"coupling": 10.0, "wall_damping": 0.1},
    }
    parts = {"a": f"mass{options}", "b": f"partner{options}"}
    settings = Simulation(200 * step, step, "implicit")
    pair = system(c_fmu, parts, "a.m <-> b.end", start=start, simulation=settings)
    size = np.abs(np.ravel(watched(pair, "a.body.m.x")))
    # the energy decays by exp(-t/20) or more: at steps of half a period, in the mean
    assert size.max() < 1.05
    assert size[-20:].max() < 0.5
    assert size[-20:].max() < size[-120:-100].max()


def added_mass(fmus: Fmus, options: str, ratio: float, step: float) -> float:
    """Error at t = 5 s of a unit mass on a unit spring with added mass exchanged as a force."""
    start, settings = (
        {"a": {"body.m.x": 1.0}, "b": {"added": ratio}},
        Simulation(5.0, step, "implicit"),
    )
    parts = {"a": f"mass{options}", "b": f"added_mass{options}"}
    pair = system(fmus, parts, "a.m <-> b.end", start=start, simulation=settings)
    rows = watched(pair, "a.body.m.x", "a.body.m.ax")
    # consistent from the start: (m + ma) a = -x
    assert rows[0][1] == pytest.approx(-1 / (1 + ratio), rel=1e-8)
    return abs(rows[-1][0] - float(np.cos(5 / np.sqrt(1 + ratio))))


@pytest.mark.verifies(
    "coupled added mass of 0.1 to 20 times the mass by the implicit algorithm",
    analytic="exact solution",
    tolerance="order 2.0 ± 0.15",
)
@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9, 1.1, 2.0, 5.0, 20.0])
def test_added_mass_of_any_ratio_is_second_order(c_fmu: Fmus, options: str, ratio: float) -> None:
    coarse, fine = (added_mass(c_fmu, options, ratio, step) for step in (0.1, 0.05))
    assert coarse < 2e-3
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.15)


def ring(fmus: Fmus, model: str, a: dict[str, float], b: dict[str, float]) -> System:
    """Each of two FMUs has the output of the other as its input."""
    parts, links = {"a": model, "b": model}, ("a.y -> b.u", "b.y -> a.u")
    settings = Simulation(1.0, 0.1, "implicit")
    return system(fmus, parts, *links, start={"a": a, "b": b}, simulation=settings)


@pytest.mark.parametrize("algorithm", ["implicit", "corrector", "gauss_seidel", "jacobi"])
def test_an_algebraic_loop_of_stages(c_fmu: Fmus, algorithm: str) -> None:
    # y1 = 3 y2 + t, y2 = 0.5 y1 + t: y1 = -8 t, whose sweeps would diverge
    loop = ring(c_fmu, "stage+state", {"gain": 3.0}, {"gain": 0.5}).changed(algorithm=algorithm)
    rows, _ = observed(loop, "a.y")
    for t, y in rows:
        assert y == pytest.approx(-8 * t, abs=1e-9)


def test_a_loop_without_a_solution_is_an_error(c_fmu: Fmus) -> None:
    # over half a step, to first order: y1 = 1 + (0 + y2), y2 = 0 + (1 + y1)
    integrators = ring(c_fmu, "integrator+state", {"gain": 40.0, "y": 1.0}, {"gain": 40.0})
    with pytest.raises(RunError, match=r"found in \d+ iterations: [ab]\.u still .*\n.*step_size"):
        run(integrators)
    # y1 = y2 + t, y2 = y1 + t: at t = 0 zeros are one solution of many
    stages = ring(c_fmu, "stage+state", {}, {})
    with pytest.raises(RunError, match=r"loop of [ab]\.u, [ab]\.u is singular at t = 0 s"):
        run(stages)
    named = (
        r"loop of [ab]\.u, [ab]\.u at t = 1 s .* after \d+ iterations: [ab]\.u .*\n.*start values"
    )
    with pytest.raises(RunError, match=named):
        run(stages.changed(start_time=1.0, stop_time=2.0))


def test_an_fmu_that_cannot_go_back_is_named(c_fmu: Fmus) -> None:
    parts, settings = {"a": "mass+state", "b": "partner"}, Simulation(1.0, 0.1, "implicit")
    with pytest.raises(RunError, match=r"which b cannot\n.*corrector"):
        run(system(c_fmu, parts, "a.m <-> b.end", simulation=settings))
