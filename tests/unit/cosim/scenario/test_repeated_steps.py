"""Actions survive what takes steps back: saved states, correction, adaptive steps, estimates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.small_systems import Fmus, observed

from m4e_fmi.cosim import (
    Action,
    Component,
    CouplingErrorReport,
    Execution,
    FmuFile,
    Simulation,
    System,
    run,
    start,
)

WATCHED = ("body.body.m.x", "body.body.m.vx", "spring.end.force_x", "spring.damping")
EVERYTHING: Mapping[str, Action] = {
    "fading": Action(at=0.3, ramp={"spring.damping": 1.5}, within=1.0),
    "drift": Action(at=0.1, offset={"spring.end.x": "1 cm"}, duration=0.6),
    "stuck": Action(when="body.body.m.x < 0.9 m", freeze=("spring.end.vx",), duration=0.4),
    "drag": Action(when="body.body.m.vx < -0.6", set={"body.damping": 0.4}, duration=0.33),
}
KINDS = ("jacobi", "gauss_seidel", "corrector", "implicit", "adaptive")


def system(fmus: Fmus, kind: str, options: str = "+state+inputs") -> System:
    """A damped oscillator to which nearly everything happens."""
    body = Component("body", FmuFile(fmus(f"mass{options}")), {"body.m.x": 1.0})
    spring = Component("spring", FmuFile(fmus(f"spring{options}")), {"damping": 0.3})
    adaptive = kind == "adaptive"
    simulation = Simulation(
        1.2 if adaptive else 1.6,
        0.02,
        algorithm="corrector" if adaptive else kind,
        coupling_tolerance=1e-3 if adaptive else None,
    )
    links = ("body.m <-> spring.end",)
    return System("s", (body, spring), links, simulation, scenario=EVERYTHING)


def rest(execution: Execution) -> np.ndarray:
    """Times [s] and watched values (n, 5) from the present point to the end."""
    found = [(execution.time, *(execution[name] for name in WATCHED))]
    while not execution.done:
        point = execution.step()
        found.append((point.time, *(point[name] for name in WATCHED)))
    return np.array(found)


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_goes_on_from_a_saved_state_bit_for_bit(c_fmu: Fmus, kind: str) -> None:
    with start(system(c_fmu, kind)) as execution:
        states = [execution.save()]
        while execution.time < 0.8:
            execution.step()
            if round(execution.time, 3) in (0.2, 0.5):
                states.append(execution.save())
        once = rest(execution)
        for state in states:
            execution.restore(state)
            again = rest(execution)
            assert len(again) >= len(once)
            assert np.array_equal(again[-len(once) :], once)


@pytest.mark.parametrize("kind", ["gauss_seidel", "corrector"])
def test_the_error_estimate_changes_no_bit(c_fmu: Fmus, kind: str) -> None:
    """Windows of the run are repeated in other steps; a run that takes single steps has others."""
    given = system(c_fmu, kind)
    seen, outcome = observed(given, *WATCHED)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert "repeated" in str(outcome.certificate.coverage)
    longer = observed(given.changed(stop_time=2.0), *WATCHED)[0]
    assert longer[: len(seen)] == seen


@pytest.mark.parametrize("when", [{"when": "body.body.m.x < 0.5"}, {"at": 1.06}])
def test_the_energy_balance_closes_over_a_jump(c_fmu: Fmus, when: dict[str, Any]) -> None:
    """Force and velocity before the jump belong to the step before it, those after it do not."""
    jump = Action(**when, set={"spring.damping": 3.0})
    outcome = run(replace(system(c_fmu, "corrector"), scenario={"jump": jump}))
    (bond,) = outcome.energy
    assert abs(bond.relative) < 1e-4  # 2 % of the energy are exchanged in the step before it


@pytest.mark.parametrize("options", ["+state+inputs", ""])
def test_the_stated_error_covers_values_that_are_held_in_steps(c_fmu: Fmus, options: str) -> None:
    """A ramp is of first order; the algorithm is of a higher one."""
    ramp = Action(at=0.32, ramp={"spring.damping": 2.0}, within=0.7)
    given = replace(
        system(c_fmu, "corrector" if options else "gauss_seidel", options),
        scenario={"acted": ramp},
    )
    signals, stated = [], []
    for size in (0.04, 0.001):
        values, outcome = observed(given.changed(step_size=size), *WATCHED[:3])
        assert isinstance(outcome.certificate, CouplingErrorReport)
        assert "(acted)" in "\n".join(outcome.notes)
        stated.append(outcome.certificate.errors[0].error)
        found = {round(time, 6): row for time, *row in values}
        signals.append(np.array([found[round(0.04 * k, 6)] for k in range(41)]))
    true = (np.abs(signals[0] - signals[1]).max(axis=0) / np.ptp(signals[1], axis=0)).max()
    assert true <= 1.1 * stated[0]
    assert stated[0] < 20 * true
