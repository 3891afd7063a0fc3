"""Each action gives the bits of the same system with a component that does it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.saboteur import saboteur
from support.small_systems import Fmus, observed, watched

from m4e_fmi.cosim import Action, Component, FmuFile, Simulation, System

SIGNAL = "spring.end.vx"
WATCHED = ("body.body.m.x", "body.body.m.vx", "spring.end.force_x")
LINKS = (
    "body.body.m.x -> spring.end.x",
    "body.body.m.vx -> spring.end.vx",
    "spring.end.force_x -> body.body.m.force_x",
)


def system(fmus: Fmus, **actions: Action) -> System:
    """A mass on a spring with a damper, released at x = 1 m."""
    body = Component("body", FmuFile(fmus("mass+state+inputs")), {"body.m.x": 1.0})
    spring = Component("spring", FmuFile(fmus("spring+state+inputs")), {"damping": 0.3})
    return System("s", (body, spring), LINKS, Simulation(2.0, 0.02, "jacobi"), scenario=actions)


def rows(given: System) -> np.ndarray:
    """Times [s] and watched values (n, 4) at all points of a run."""
    return np.array(observed(given, *WATCHED)[0])


def beside(given: System, fmu: Path, *links: str, **start: float) -> System:
    """The system with one more component, `other`, and these connections."""
    parts = (*given.components, Component("other", FmuFile(fmu), start))
    return replace(given, components=parts, connections=links)


THEN: dict[str, Any] = {"at": 0.507, "duration": 0.8}
ACTIONS: dict[str, tuple[Action, dict[str, Any]]] = {
    "freeze": (Action(freeze=(SIGNAL,), **THEN), {}),
    "offset": (Action(offset={SIGNAL: "2 cm/s"}, **THEN), {"amount": 0.02}),
    "replace": (Action(replace={SIGNAL: 0.25}, **THEN), {"amount": 0.25}),
}
SETTINGS = {
    "ramp": Action(ramp={"spring.damping": "2 N.s/m"}, within=0.3, **THEN),
    "replace": Action(set={"spring.damping": 2.0}, **THEN),
}


@pytest.mark.parametrize("kind", ACTIONS)
def test_an_action_on_a_signal_is_a_component_between(
    c_fmu: Fmus, tmp_path: Path, kind: str
) -> None:
    action, given = ACTIONS[kind]
    fmu = saboteur(tmp_path, kind, begin=0.507, end=1.307, **given)
    plain, acted = system(c_fmu), rows(system(c_fmu, acted=action))
    through = "body.body.m.vx -> other.u", f"other.y -> {SIGNAL}"
    assert np.array_equal(acted, rows(beside(plain, fmu, LINKS[0], *through, LINKS[2])))
    assert not np.array_equal(acted[-1], rows(plain)[-1])


@pytest.mark.parametrize("kind", SETTINGS)
def test_a_parameter_is_driven_as_by_a_component(c_fmu: Fmus, tmp_path: Path, kind: str) -> None:
    fmu = saboteur(tmp_path, kind, begin=0.507, end=1.307, amount=2.0, every=0.3, unit="N.s/m")
    driven = beside(system(c_fmu), fmu, *LINKS, "other.y -> spring.damping", u=0.3)
    assert np.array_equal(rows(system(c_fmu, acted=SETTINGS[kind])), rows(driven))


@pytest.mark.parametrize(("signal", "apart"), [("body.body.m.x", 0.0), ("spring.end.x", 0.1)])
def test_an_output_is_changed_for_all_its_takers_and_an_input_for_one(
    c_fmu: Fmus, signal: str, apart: float
) -> None:
    """By 10 cm; the stiffness is 1 N/m."""
    links = (*LINKS, "body.body.m.x -> other.end.x", "body.body.m.vx -> other.end.vx")
    given = system(c_fmu, drift=Action(at=1, offset={signal: "10 cm"}))
    two = beside(given, c_fmu("spring+state+inputs"), *links, damping=0.3)
    one, other = watched(two, "spring.end.force_x", "other.end.force_x")[-1]
    assert other - one == pytest.approx(apart, rel=1e-9)


def test_units_of_an_output_are_converted_for_its_taker(c_fmu: Fmus) -> None:
    def moved(signal: str, way: float) -> np.ndarray:
        given = system(c_fmu, drift=Action(at=0, offset={signal: way}))
        body, spring = given.components
        start = {"body.m.x": 1000.0, "mass": 0.001}
        body = replace(body, source=FmuFile(c_fmu("mm_mass+state")), start=start)
        return rows(replace(given, components=(body, spring)))

    expected = moved("spring.end.x", 0.02)
    assert moved("body.body.m.x", 20.0) == pytest.approx(expected, rel=1e-12)  # mm, as the output
    assert expected[0, 3] == pytest.approx(-1.02)


def test_actions_on_one_signal_act_in_the_order_of_the_file(c_fmu: Fmus) -> None:
    shift = Action(at=1, offset={"spring.end.x": 0.5})
    stuck = Action(at=0, replace={"spring.end.x": 1.0})
    for actions, x in (((shift, stuck), 1.0), ((stuck, shift), 1.5)):
        found = rows(system(c_fmu, **{f"a{k}": action for k, action in enumerate(actions)}))
        assert found[-1, 3] == pytest.approx(-x - 0.3 * found[-1, 2])


def test_a_value_in_place_of_an_output_goes_through_its_connection(c_fmu: Fmus) -> None:
    links = (LINKS[0], f"body.body.m.vx * -2 + 0.1 -> {SIGNAL}", LINKS[2])
    given = system(c_fmu, instead=Action(at=1, replace={"body.body.m.vx": "3 m/s"}))
    _, x, _, force = rows(replace(given, connections=links))[-1]
    assert force == pytest.approx(-x - 0.3 * (-2 * 3.0 + 0.1), rel=1e-12)


def test_of_settings_of_one_variable_that_overlap_the_last_counts(c_fmu: Fmus) -> None:
    """When all have ended, the variable has the value from before."""
    name = "spring.damping"
    overlapping = {
        "long": Action(at=0.2, duration=1.2, set={name: 2.0}),
        "inner": Action(at=0.7, duration=0.1, set={name: 5.0}),
        "ramp": Action(at=0.4, duration=0.2, ramp={name: 3.0}, within=0.1),
        "over": Action(at=0.5, duration=0.4, set={name: 9.0}),
    }
    values, outcome = observed(system(c_fmu, **overlapping), name)
    found = {round(time, 2): value for time, value in values}
    expected = {0.1: 0.3, 0.3: 2.0, 0.4: 2.0, 0.46: 2.6, 0.52: 9.0, 0.62: 9.0, 0.74: 5.0}
    expected |= {0.84: 9.0, 0.92: 2.0, 1.38: 2.0, 1.42: 0.3, 2.0: 0.3}
    assert {time: found[time] for time in expected} == pytest.approx(expected)
    assert outcome.scenario[2] == (
        "ramp: from t = 0.4 s to 0.6 s: spring.damping = 3 N.s/m within 0.1 s"
    )


@pytest.mark.parametrize("kind", ACTIONS)
def test_an_action_on_an_input_with_several_sources_acts_on_their_sum(
    c_fmu: Fmus, kind: str
) -> None:
    signal, amount = "body.body.m.force_x", "0.1 N"
    given = {"freeze": (signal,), "offset": {signal: amount}, "replace": {signal: amount}}
    own: dict[str, Any] = {kind: given[kind]}
    one = system(c_fmu, disturbed=Action(**own, **THEN))
    spring, others = one.components[1], ("spring", "other")
    halves = [
        Component(name, spring.source, {"damping": 0.15, "stiffness": 0.5}) for name in others
    ]
    links = [link.replace("spring", name) for name in others for link in LINKS]
    two = replace(one, components=(one.components[0], *halves), connections=tuple(links))
    assert rows(two)[:, :3] == pytest.approx(rows(one)[:, :3], abs=1e-12)
