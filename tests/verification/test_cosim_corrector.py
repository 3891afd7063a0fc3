"""The corrector on systems with exact solutions: order, error, and loss of order.

Two-mass oscillator as in `test_cosim_order`. The best of other masters there has an error of 5.8e-3
at H = 0.1 and second order; third order promises 3e-4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Network,
    Port,
    Simulation,
    System,
    run,
)

Fmus = Callable[[str], Path]
Case = tuple[tuple[Component, ...], tuple[str, ...], dict[Port, float]]

TIME = 10.0
STEPS = (0.1, 0.05, 0.025, 0.0125)
FAST = np.sqrt(3.0)
EXACT = (
    (np.cos(TIME) + np.cos(FAST * TIME)) / 2,
    -(np.sin(TIME) + FAST * np.sin(FAST * TIME)) / 2,
    (np.cos(TIME) - np.cos(FAST * TIME)) / 2,
    -(np.sin(TIME) - FAST * np.sin(FAST * TIME)) / 2,
)
BOTH = ("+state", "+state")
LIMITS = ("", "+single", "+single+first", "+none", "+ignored")
"""FMUs that take all time derivatives of inputs; one in a call; none of order 2; none at all; and
that warn of those of order 2, and ignore them."""


def part(fmus: Fmus, model: str, name: str, **start: float) -> Component:
    return Component(
        name, FmuFile(fmus(model)), {k.replace("__", "."): v for k, v in start.items()}
    )


def force_displacement(fmus: Fmus, first: str, second: str) -> Case:
    components = (
        part(fmus, f"mass{first}", "a", stiffness=1.0, body__m__x=1.0),
        part(fmus, f"partner{second}", "b"),
    )
    ports = (Port("a", "body.m.x"), Port("a", "body.m.vx"), Port("b", "x"), Port("b", "vx"))
    return components, ("a.m <-> b.end",), dict(zip(ports, EXACT, strict=True))


def displacement_displacement(fmus: Fmus, first: str, second: str) -> Case:
    components = (
        part(fmus, f"partner{first}", "a", x=1.0),
        part(fmus, f"partner{second}", "b"),
    )
    ports = (Port("a", "x"), Port("a", "vx"), Port("b", "x"), Port("b", "vx"))
    links = ("a.x -> b.end.x", "b.x -> a.end.x")
    return components, links, dict(zip(ports, EXACT, strict=True))


def integrators(fmus: Fmus, first: str, second: str) -> Case:
    # y1' = y2, y2' = -y1: nothing can be predicted but from the past
    components = (
        part(fmus, f"integrator{first}", "a", y=1.0),
        part(fmus, f"integrator{second}", "b", gain=-1.0),
    )
    exact = {Port("a", "y"): float(np.cos(TIME)), Port("b", "y"): -float(np.sin(TIME))}
    return components, ("a.y -> b.u", "b.y -> a.u"), exact


def error(case: Case, step: float, algorithm: str = "corrector") -> float:
    """Largest error at the end, of a run with this step."""
    components, connections, exact = case
    found = np.zeros(len(exact))

    def observe(t: float, network: Network) -> None:
        if t == TIME:
            found[:] = [network.read(str(port)) for port in exact]

    settings = Simulation(TIME, step, algorithm)
    run(System("s", components, connections, settings), observers=[observe])
    return float(np.abs(found - list(exact.values())).max())


def orders(case: Case) -> np.ndarray:
    found = np.array([error(case, step) for step in STEPS])
    return np.log2(found[:-1] / found[1:])


CASES = (force_displacement, displacement_displacement, integrators)


@pytest.mark.verifies(
    "two-mass oscillator by the corrector at H = 0.1 s, third order",
    analytic="exact solution",
    tolerance="3e-4",
)
@pytest.mark.parametrize("make", CASES)
@pytest.mark.parametrize("options", ["+state", *(f"+state+inputs{o}" for o in LIMITS)])
def test_order_and_error(c_fmu: Fmus, make: Callable[[Fmus, str, str], Case], options: str) -> None:
    case = make(c_fmu, options, options)
    assert error(case, 0.1) < 3e-4
    # the terms of the next order change it by 0.1 at these steps
    assert orders(case).min() > 2.9


@pytest.mark.parametrize("process", ["here", "own"])
@pytest.mark.parametrize("algorithm", ["corrector", "implicit"])
@pytest.mark.parametrize("limit", LIMITS)
def test_derivatives_that_are_refused_are_told_once_and_cost_nothing(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, limit: str, algorithm: str, process: str
) -> None:
    components, links, exact = integrators(c_fmu, *2 * [f"+state+inputs{limit}"])
    components = tuple(replace(one, process=process) for one in components)
    system = System("s", components, links, Simulation(TIME, 0.1, algorithm))
    found: list[dict[str, float]] = []
    for by_python in (False, True):
        if by_python:
            monkeypatch.setattr("m4e_fmi.cosim.exchange.step_loop.library", lambda: None)
        last: dict[str, float] = {}
        outcome = run(
            system,
            observers=[lambda _, n, end=last: end.update({str(p): n.read(str(p)) for p in exact})],
        )
        found.append(last)
        notes = [note for note in outcome.notes if "time derivatives of inputs" in note]
        assert [note.partition(":")[0] for note in notes] == (
            ["a, b"] if limit in LIMITS[2:] else []
        )
        assert isinstance(outcome.certificate, CouplingErrorReport)
        for error in outcome.certificate.errors:
            off = abs(last[str(error.source)] - exact[Port.named(str(error.source))])
            assert off <= 3 * error.error
    assert found[0] == found[1]


def test_fmus_that_cannot_be_tried_hold_their_inputs(c_fmu: Fmus) -> None:
    """Those of which a process may have one instance only, in this process."""
    components, links, _ = integrators(c_fmu, "+state+inputs+alone+none", "+state+inputs")
    components = replace(components[0], process="here"), components[1]
    outcome = run(System("s", components, links, Simulation(1.0, 0.1, "corrector")))
    (note,) = (note for note in outcome.notes if "time derivatives of inputs" in note)
    assert note.startswith("a: ")
    assert "one instance per process" in note


def energy(case: Case, step: float, steps: int) -> np.ndarray:
    """Energy of the undamped pair at every step, over that at the start."""
    components, connections, exact = case
    found: list[float] = []

    def observe(_: float, network: Network) -> None:
        x1, v1, x2, v2 = (network.read(str(port)) for port in exact)
        found.append(v1**2 + v2**2 + x1**2 + x2**2 + (x1 - x2) ** 2)

    settings = Simulation(steps * step, step)
    run(System("s", components, connections, settings), observers=[observe])
    return np.array(found) / found[0]


@pytest.mark.verifies(
    "energy of the undamped pair by default, 3,000 steps of H = 0.1 s",
    analytic="it stays",
    tolerance="1e-5",
)
@pytest.mark.parametrize("make", CASES[:2])
@pytest.mark.parametrize("options", ["+state", "+state+inputs"])
def test_energy_stays(c_fmu: Fmus, make: Callable[[Fmus, str, str], Case], options: str) -> None:
    # one held value, right in the mean only, for each half step would gain 4e-3
    found = energy(make(c_fmu, options, options), 0.1, 3000)
    assert np.abs(found - 1).max() < 1e-5


def test_without_a_cycle_one_pass_does(c_fmu: Fmus) -> None:
    # y1' = 1, y2' = y1, y3' = y2: no FMU can go back, and none needs to
    components = (
        part(c_fmu, "integrator", "c"),
        part(c_fmu, "integrator", "b"),
        part(c_fmu, "integrator", "a", u=1.0),
    )
    exact = {Port("b", "y"): TIME**2 / 2, Port("c", "y"): TIME**3 / 6}
    case = components, ("a.y -> b.u", "b.y -> c.u"), exact
    # parabolas are exact: rounding of 100 steps is left
    assert error(case, 0.1) < 1e-10
    outcome = run(System("s", components, case[1], Simulation(1, 0.1)))
    assert not outcome.notes
    assert outcome.order == 3


def test_listing_order_does_not_matter(c_fmu: Fmus) -> None:
    components, links, exact = force_displacement(c_fmu, *BOTH)
    again = error((components[::-1], links, exact), 0.1)
    assert again == pytest.approx(error((components, links, exact), 0.1), rel=1e-9)


@pytest.mark.parametrize("options", [("", "+state"), ("+state", "")])
@pytest.mark.parametrize("make", CASES)
def test_one_fmu_that_cannot_go_back(
    c_fmu: Fmus, make: Callable[[Fmus, str, str], Case], options: tuple[str, str]
) -> None:
    case = make(c_fmu, *options)
    assert orders(case).min() > 1.9
    components, connections, _ = case
    outcome = run(System("s", components, connections, Simulation(1, 0.1, "corrector")))
    (note,) = outcome.notes
    name = "a" if options[0] == "" else "b"
    assert note.startswith(f"{name} cannot roll back (canGetAndSetFMUstate)")
    assert "second order instead of third" in note


def test_where_nothing_goes_back_it_is_gauss_seidel_and_says_so(c_fmu: Fmus) -> None:
    case = force_displacement(c_fmu, "", "")
    assert error(case, 0.1) == error(case, 0.1, "gauss_seidel")
    components, connections, _ = case
    outcome = run(System("s", components, connections, Simulation(1, 0.1, "corrector")))
    assert "ran as gauss_seidel, second order instead of third" in outcome.notes[0]
    sweep = Simulation(1, 0.1, "gauss_seidel")
    assert not run(System("s", components, connections, sweep)).notes


def test_an_input_that_moves_along_another_is_told(c_fmu: Fmus) -> None:
    components = (
        part(c_fmu, "mass+state", "a", stiffness=1.0, body__m__x=1.0),
        part(c_fmu, "moving_partner+state", "b"),
    )
    outcome = run(System("s", components, ("a.m <-> b.end",), Simulation(1, 0.1, "corrector")))
    (note,) = outcome.notes
    assert note.startswith("b moves end.x along end.vx")


def test_several_that_do_without_are_told_in_one_line(c_fmu: Fmus) -> None:
    names = "bcd"
    parts = [part(c_fmu, "mass+state", f"m{name}", stiffness=1.0) for name in names]
    parts += [part(c_fmu, "moving_partner+state", name) for name in names]
    parts += [part(c_fmu, "mass+state", "me"), part(c_fmu, "spring", "e")]
    ways = [f"m{name}.m <-> {name}.end" for name in (*names, "e")]
    outcome = run(System("s", tuple(parts), tuple(ways), Simulation(1, 0.1, "corrector")))
    (note,) = outcome.notes
    assert note == (
        "e cannot roll back (canGetAndSetFMUstate): it steps once, on inputs of the first pass; b, "
        "c and d move b.end.x along b.end.vx (and 2 more) and follow no higher derivatives "
        "(canInterpolateInputs): second order instead of third: half the step leaves a quarter of "
        "the error, not an eighth"
    )


def test_a_last_step_that_is_shorter_costs_no_order(c_fmu: Fmus) -> None:
    # 10 s are 153 steps of 0.065 s and one of 0.055 s, or 307 of 0.0325 s and one of 0.0225 s
    case = force_displacement(c_fmu, *BOTH)
    assert error(case, 0.065) / error(case, 0.0325) > 2**2.9
