"""Each action gives the bits of the same system with a component that does it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.saboteur import saboteur
from support.small_systems import Fmus

from m4e_fmi.cosim import Action, Component, FmuFile, Network, Simulation, System, run
from m4e_fmi.cosim.scenario.effects import Delay, Given

SIGNAL = "spring.end.vx"
WATCHED = ("body.body.m.x", "body.body.m.vx", "spring.end.force_x")
LINKS = (
    "body.body.m.x -> spring.end.x",
    "body.body.m.vx -> spring.end.vx",
    "spring.end.force_x -> body.body.m.force_x",
)


def system(
    fmus: Fmus,
    scenario: Mapping[str, Action] | None = None,
    *,
    algorithm: str = "jacobi",
    options: str = "+state+inputs",
    stop: float = 2.0,
) -> System:
    """A mass on a spring with a damper, released at x = 1 m."""
    body = Component("body", FmuFile(fmus(f"mass{options}")), {"body.m.x": 1.0})
    spring = Component("spring", FmuFile(fmus(f"spring{options}")), {"damping": 0.3})
    simulation = Simulation(stop, 0.02, algorithm=algorithm)
    return System("s", (body, spring), LINKS, simulation, scenario=scenario or {})


def rows(given: System) -> np.ndarray:
    """Times [s] and watched values (n, 4) at all points of a run."""
    found: list[tuple[float, ...]] = []

    def observe(time: float, network: Network) -> None:
        found.append((time, *(network.read(name) for name in WATCHED)))

    run(given, observers=[observe])
    return np.array(found)


ACTIONS = {
    "freeze": (Action(freeze=(SIGNAL,), at=0.507, duration=0.8), {}),
    "offset": (Action(offset={SIGNAL: "2 cm/s"}, at=0.507, duration=0.8), {"amount": 0.02}),
    "replace": (Action(replace={SIGNAL: 0.25}, at=0.507, duration=0.8), {"amount": 0.25}),
    "noise": (
        Action(noise={SIGNAL: "5 mm/s"}, seed=7, every=0.03, at=0.507, duration=0.8),
        {"amount": 0.005, "seed": 7, "every": 0.03},
    ),
    "delay": (Action(delay={SIGNAL: 0.113}, at=0.507, duration=0.8), {"amount": 0.113}),
    "dropout": (
        Action(dropout=(SIGNAL,), share=0.6, seed=3, every=0.03, at=0.507, duration=0.8),
        {"amount": 0.6, "seed": 3, "every": 0.03},
    ),
}


@pytest.mark.parametrize("kind", ACTIONS)
def test_an_action_on_a_signal_is_a_component_between(
    c_fmu: Fmus, tmp_path: Path, kind: str
) -> None:
    action, given = ACTIONS[kind]
    fmu = saboteur(tmp_path, kind, begin=0.507, end=1.307, signal=SIGNAL, **given)
    plain = system(c_fmu)
    between = replace(
        plain,
        components=(*plain.components, Component("between", FmuFile(fmu))),
        connections=(LINKS[0], "body.body.m.vx -> between.u", f"between.y -> {SIGNAL}", LINKS[2]),
    )
    acted = rows(system(c_fmu, {"acted": action}))
    assert np.array_equal(acted, rows(between))
    assert not np.array_equal(acted[-1], rows(plain)[-1])


@pytest.mark.parametrize("kind", ["ramp", "replace"])
def test_a_parameter_is_driven_as_by_a_component(c_fmu: Fmus, tmp_path: Path, kind: str) -> None:
    fmu = saboteur(tmp_path, kind, begin=0.507, end=1.307, amount=2.0, every=0.3, unit="N.s/m")
    plain = system(c_fmu)
    driven = replace(
        plain,
        components=(*plain.components, Component("driver", FmuFile(fmu), {"u": 0.3})),
        connections=(*LINKS, "driver.y -> spring.damping"),
    )
    action = {
        "ramp": Action(ramp={"spring.damping": "2 N.s/m"}, within=0.3, at=0.507, duration=0.8),
        "replace": Action(set={"spring.damping": 2.0}, at=0.507, duration=0.8),
    }[kind]
    assert np.array_equal(rows(system(c_fmu, {"acted": action})), rows(driven))


def test_an_output_is_changed_for_all_its_takers_and_an_input_for_one(c_fmu: Fmus) -> None:
    plain = system(c_fmu)
    second = replace(plain.components[1], name="second")
    links = (*LINKS, "body.body.m.x -> second.end.x", "body.body.m.vx -> second.end.vx")
    two = replace(plain, components=(*plain.components, second), connections=links)
    forces: dict[str, tuple[float, float]] = {}
    for signal in ("body.body.m.x", "spring.end.x"):

        def observe(_: float, network: Network, signal: str = signal) -> None:
            read = network.read("spring.end.force_x"), network.read("second.end.force_x")
            forces[signal] = read

        run(
            replace(two, scenario={"drift": Action(at=1, offset={signal: "10 cm"})}),
            observers=[observe],
        )
    both, one = forces.values()
    assert both[0] == both[1]
    assert one[1] - one[0] == pytest.approx(0.1, rel=1e-9)  # the stiffness is 1 N/m


def test_units_of_an_output_are_converted_for_its_taker(c_fmu: Fmus) -> None:
    plain = system(c_fmu)
    body = replace(
        plain.components[0],
        source=FmuFile(c_fmu("mm_mass+state")),
        start={"body.m.x": 1000.0, "mass": 0.001},
    )
    fine = replace(plain, components=(body, plain.components[1]))
    drift = {"drift": Action(at=0, offset={"body.body.m.x": 20.0})}  # mm, as the output
    taker = {"drift": Action(at=0, offset={"spring.end.x": 0.02})}
    expected = rows(replace(fine, scenario=taker))
    assert rows(replace(fine, scenario=drift)) == pytest.approx(expected, rel=1e-12)
    assert expected[0, 3] == pytest.approx(-1.02)


def test_actions_on_one_signal_act_in_the_order_of_the_file(c_fmu: Fmus) -> None:
    shift = Action(at=1, offset={"spring.end.x": 0.5})
    stuck = Action(at=0, replace={"spring.end.x": 1.0})
    first = rows(system(c_fmu, {"shift": shift, "stuck": stuck}))
    last = rows(system(c_fmu, {"stuck": stuck, "shift": shift}))
    at_end = -0.3 * first[-1, 2]  # the damper
    assert first[-1, 3] == pytest.approx(-1.0 + at_end)
    assert last[-1, 3] == pytest.approx(-1.5 - 0.3 * last[-1, 2])


def test_a_lost_signal_gives_zero_where_asked(c_fmu: Fmus) -> None:
    found = rows(system(c_fmu, {"lost": Action(at=1, dropout=("spring.end.x",), gives="zero")}))
    assert found[-1, 3] == pytest.approx(-0.3 * found[-1, 2])


@pytest.mark.parametrize(
    ("signal", "value", "velocity"),
    [
        (SIGNAL, "other.body.m.vx", 3.0),
        # through its connection: factor and offset are those of the connection, as for a number
        ("body.body.m.vx", "other.body.m.vx", -2 * 3.0 + 0.1),
        ("body.body.m.vx", "3 m/s", -2 * 3.0 + 0.1),
    ],
)
def test_a_signal_is_replaced_by_another_output(
    c_fmu: Fmus, signal: str, value: str, velocity: float
) -> None:
    other = Component("other", FmuFile(c_fmu("mass+state")), {"body.m.vx": 3.0})
    links = (LINKS[0], f"body.body.m.vx * -2 + 0.1 -> {SIGNAL}", LINKS[2])
    plain = system(c_fmu, {"instead": Action(at=1, replace={signal: value})})
    two = replace(plain, components=(*plain.components, other), connections=links)
    _, x, _, force = rows(two)[-1]
    assert force == pytest.approx(-x - 0.3 * velocity, rel=1e-12)


def test_noise_through_a_negative_factor(c_fmu: Fmus) -> None:
    """A standard deviation has no sign; the amounts are those of the factor's size."""
    plain, found = system(c_fmu), []
    for factor in (2.0, -2.0):
        links = (LINKS[0], f"body.body.m.vx * {factor} -> {SIGNAL}", LINKS[2])
        still = Component("body", FmuFile(c_fmu("mass+state")))
        noise = {"n": Action(at=0, noise={"body.body.m.vx": 0.01}, seed=1, every=0.02)}
        parts = (still, plain.components[1])
        given = replace(plain, components=parts, connections=links, scenario=noise)
        found.append(rows(replace(given, simulation=Simulation(0.02, 0.02)))[0, 3])
    assert found[0] == found[1] != 0.0


def test_a_delay_of_a_value_that_changes_at_its_point_has_the_last_one() -> None:
    delay = Delay(100)
    for time, value in ((0, 1.0), (10, 2.0), (10, 5.0)):
        delay.watch(time, Given(1.0, 0.0, value), active=True)
    assert delay.act(105, 0, Given(1.0, 0.0, 7.0)).value == 3.0


def test_of_settings_of_one_variable_that_overlap_the_last_counts(c_fmu: Fmus) -> None:
    """When all have ended, the variable has the value from before."""
    name = "spring.damping"
    overlapping = {
        "long": Action(at=0.2, duration=1.2, set={name: 2.0}),
        "inner": Action(at=0.7, duration=0.1, set={name: 5.0}),
        "ramp": Action(at=0.4, duration=0.2, ramp={name: 3.0}, within=0.1),
        "over": Action(at=0.5, duration=0.4, set={name: 9.0}),
    }
    found: dict[float, float] = {}

    def observe(time: float, network: Network) -> None:
        found[round(time, 2)] = network.read(name)

    outcome = run(system(c_fmu, overlapping), observers=[observe])
    expected = {0.1: 0.3, 0.3: 2.0, 0.4: 2.0, 0.46: 2.6, 0.52: 9.0, 0.62: 9.0, 0.74: 5.0}
    expected |= {0.84: 9.0, 0.92: 2.0, 1.38: 2.0, 1.42: 0.3, 2.0: 0.3}
    assert {time: found[time] for time in expected} == pytest.approx(expected)
    assert outcome.scenario[2] == (
        "ramp: from t = 0.4 s to 0.6 s: spring.damping = 3 N.s/m within 0.1 s"
    )
