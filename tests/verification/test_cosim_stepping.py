"""A controller in Python, one step at a time; saved states restored bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from support.small_systems import Fmus, watched
from support.two_masses import orders

from m4e_fmi.cosim import Component, Execution, FmuFile, Simulation, System, run, start

STATES = ("a.body.m.x", "a.body.m.vx", "b.body.m.x", "b.body.m.vx")
FORCE = "b.body.m.force_x"
D, STOP = 0.1, 4.0
GAIN, RATE = 0.7, 0.4
"""Of the controller: force = -GAIN x - RATE v."""
MATRIX = np.array([[0, 1, 0, 0, 0], [-2, -D, 1, D, 0], [0, 0, 0, 1, 0], [1, D, -2, -D, 1], [0] * 5])
"""Two masses of 1 kg, springs of 1 N/m, a damper between them; last, a force on the second."""
ORDERS = {"jacobi": 1, "gauss_seidel": 2, "implicit": 2, "corrector": 3}


def masses(
    fmus: Fmus, settings: Simulation, *more: Component, connections: tuple[str, ...] = ()
) -> System:
    a = Component("a", FmuFile(fmus("mass+state")), {"stiffness": 1.0, "body.m.x": 1.0})
    b = Component("b", FmuFile(fmus("middle+state")), {"damping": D})
    return System("s", (a, b, *more), ("a.m <-> b.end", *connections), settings)


def controlled(execution: Execution) -> list[list[float]]:
    """States at all further points of a run whose controller is in Python."""
    found = []
    for point in execution:
        found.append([point[name] for name in STATES])
        execution[FORCE] = -GAIN * point["b.body.m.x"] - RATE * point["b.body.m.vx"]
    return found


def sampled(step: float) -> np.ndarray:
    """The exact states at all points, the force held from each to the next."""
    over, state = expm(step * MATRIX), np.array([1.0, 0, 0, 0, 0])
    found = [state[:4]]
    for _ in range(round(STOP / step)):
        state[4] = -GAIN * state[2] - RATE * state[3]
        state = over @ state
        found.append(state[:4])
    return np.array(found)


@pytest.mark.verifies(
    "a controller in Python, as an FMU of the same law held for a step",
    analytic="the same sums in C",
    tolerance="identical",
)
def test_a_controller_in_python_is_one_in_an_fmu(c_fmu: Fmus) -> None:
    settings = Simulation(STOP, 0.05, "jacobi")
    law = {"stiffness": GAIN, "damping": RATE}
    controller = Component("c", FmuFile(c_fmu("spring+state")), law)
    coupled = masses(c_fmu, settings, controller, connections=("b.m <-> c.end",))
    expected = watched(coupled, *STATES)
    with start(masses(c_fmu, settings)) as execution:
        found = controlled(execution)
    assert execution.outcome.steps == len(found) - 1 == 80
    assert found == expected


@pytest.mark.verifies(
    "order of each algorithm, with two masses under a controller that samples",
    analytic="matrix exponential with the force held",
    tolerance="0.2",
)
@pytest.mark.parametrize("algorithm", ORDERS)
def test_order_under_a_controller(c_fmu: Fmus, algorithm: str) -> None:
    errors = []
    for step in (0.1, 0.05, 0.025):
        with start(masses(c_fmu, Simulation(STOP, step, algorithm))) as execution:
            found = controlled(execution)
        errors.append(np.abs(np.array(found) - sampled(step)).max())
    # a fifth below it: what is left of higher powers at these steps
    assert orders(np.array(errors))[-1] > ORDERS[algorithm] - 0.2


ADAPTIVE = [(name, tolerance) for name in ORDERS for tolerance in (None, 1e-4)]


@pytest.mark.parametrize(("algorithm", "tolerance"), ADAPTIVE)
def test_a_branch_repeats_bit_for_bit(c_fmu: Fmus, algorithm: str, tolerance: float | None) -> None:
    settings = Simulation(STOP, 0.1, algorithm, coupling_tolerance=tolerance)
    system = masses(c_fmu, settings)

    def course(execution: Execution) -> list[tuple[float, ...]]:
        return [(point.time, *(point[name] for name in STATES)) for point in execution]

    with start(system) as straight:
        whole = course(straight)
    with start(system) as execution:
        early = execution.save()
        while execution.time < 1.0:
            execution.step()
        state = execution.save()
        first = course(execution)
        execution.restore(state)
        execution["b.damping"] = 5 * D
        other = course(execution)
        execution.restore(early)
        again = course(execution)
        execution.restore(state)
        assert course(execution) == first
    assert whole[-len(first) :] == first
    assert again == whole
    assert other[0] == first[0]
    assert np.abs(np.array(other[-1]) - first[-1]).max() > 0.01
    assert execution.outcome.energy == straight.outcome.energy
    assert execution.outcome.steps == straight.outcome.steps == len(whole) - 1
    assert execution.outcome.rejected == straight.outcome.rejected


def test_without_interventions_it_is_a_run(c_fmu: Fmus, tmp_path: Path) -> None:
    for algorithm in ORDERS:
        system = masses(c_fmu, Simulation(STOP, 0.1, algorithm, output_interval=0.2))
        expected = run(system, results=tmp_path / "run.nc")
        with start(system, results=tmp_path / "stepped.nc") as execution:
            for _ in execution:
                pass
        outcome = execution.outcome
        assert (outcome.steps, outcome.energy) == (expected.steps, expected.energy)
        assert outcome.certificate == expected.certificate
        first, second = expected.results(), outcome.results()
        assert (first.time == second.time).all()
        for name in STATES:
            assert (first[name].values == second[name].values).all()


def test_an_algebraic_loop_repeats_bit_for_bit(c_fmu: Fmus) -> None:
    # what the solution of a loop starts from is part of the state
    a = Component("a", FmuFile(c_fmu("mass+state")), {"body.m.x": 1.0})
    b = Component("b", FmuFile(c_fmu("added_mass+state")), {"added": 0.5})
    system = System("s", (a, b), ("a.m <-> b.end",), Simulation(STOP, 0.1, "implicit"))
    with start(system) as execution:
        for _ in range(10):
            execution.step()
        state = execution.save()
        first = [point["a.body.m.ax"] for point in execution]
        execution.restore(state)
        assert [point["a.body.m.ax"] for point in execution] == first
