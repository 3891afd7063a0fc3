"""The corrector on systems with exact solutions: order, error, and loss of order.

Two-mass oscillator of support/two_masses.py; third order promises an error of 3e-4 at H = 0.1 s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system, watched
from support.two_masses import EXACT, errors, orders, two_integrators, two_masses, two_places

from m4e_fmi.cosim import CouplingErrorReport, Simulation, System, run

Case = tuple[System, dict[str, float]]
"""A system, and its variables after 10 s."""

TIME = 10.0
STEPS = (0.1, 0.05, 0.025, 0.0125)
BOTH = ("+state", "+state")
LIMITS = ("", "+single", "+single+first", "+none", "+ignored")
"""FMUs that take all time derivatives of inputs; one in a call; none of order 2; none at all; and
that warn of those of order 2, and ignore them."""


def force_displacement(fmus: Fmus, first: str, second: str) -> Case:
    return two_masses(fmus, f"mass{first}", f"partner{second}"), EXACT


def displacements(fmus: Fmus, first: str, second: str) -> Case:
    return two_places(fmus, f"partner{first}", f"partner{second}")


def integrators(fmus: Fmus, first: str, second: str) -> Case:
    return two_integrators(fmus, f"integrator{first}", f"integrator{second}")


CASES = (force_displacement, displacements, integrators)


@pytest.mark.verifies(
    "two-mass oscillator by the corrector at H = 0.1 s, third order",
    analytic="exact solution",
    tolerance="3e-4",
)
@pytest.mark.parametrize("make", CASES)
@pytest.mark.parametrize("options", ["+state", *(f"+state+inputs{o}" for o in LIMITS)])
def test_order_and_error(c_fmu: Fmus, make: Callable[[Fmus, str, str], Case], options: str) -> None:
    case = make(c_fmu, options, options)
    found = errors(*case, STEPS)
    assert found[0] < 3e-4
    # the terms of the next order change it by 0.1 at these steps
    assert orders(found).min() > 2.9


@pytest.mark.parametrize("process", ["here", "own"])
@pytest.mark.parametrize("algorithm", ["corrector", "implicit"])
@pytest.mark.parametrize("limit", LIMITS)
def test_derivatives_that_are_refused_are_told_once_and_cost_nothing(
    c_fmu: Fmus, request: pytest.FixtureRequest, limit: str, algorithm: str, process: str
) -> None:
    ring, exact = integrators(c_fmu, *2 * [f"+state+inputs{limit}"])
    parts = tuple(replace(one, process=process) for one in ring.components)
    ring = replace(ring, components=parts).changed(algorithm=algorithm)
    found: list[list[float]] = []
    for by_python in (False, True):
        if by_python:
            request.getfixturevalue("python_loop")
        rows, outcome = observed(ring, *exact)
        found.append(rows[-1])
        notes = [note for note in outcome.notes if "time derivatives of inputs" in note]
        assert [note.partition(":")[0] for note in notes] == (
            ["a, b"] if limit in LIMITS[2:] else []
        )
        last = dict(zip(exact, rows[-1][1:], strict=True))
        assert isinstance(outcome.certificate, CouplingErrorReport)
        for error in outcome.certificate.errors:
            name = str(error.source)
            assert abs(last[name] - exact[name]) <= 3 * error.error
    assert found[0] == found[1]


def test_fmus_that_cannot_be_tried_hold_their_inputs(c_fmu: Fmus) -> None:
    """Those of which a process may have one instance only, in this process."""
    ring, _ = integrators(c_fmu, "+state+inputs+alone+none", "+state+inputs")
    alone, other = ring.components
    ring = replace(ring, components=(replace(alone, process="here"), other))
    outcome = run(ring.changed(stop_time=1.0))
    (note,) = (note for note in outcome.notes if "time derivatives of inputs" in note)
    assert note.startswith("a: ")
    assert "one instance per process" in note


def energy(case: Case, step: float, steps: int) -> np.ndarray:
    """Energy of the undamped pair at every step, over that at the start."""
    given, names = case
    course = watched(given.changed(stop_time=steps * step, step_size=step), *names)
    x1, v1, x2, v2 = np.array(course).T
    found = v1**2 + v2**2 + x1**2 + x2**2 + (x1 - x2) ** 2
    return found / found[0]


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
    parts = {"c": "integrator", "b": "integrator", "a": "integrator"}
    links = ("a.y -> b.u", "b.y -> c.u")
    chain = system(c_fmu, parts, *links, start={"a": {"u": 1.0}}, simulation=Simulation(TIME, 0.1))
    # parabolas are exact: rounding of 100 steps is left
    assert errors(chain, {"b.y": TIME**2 / 2, "c.y": TIME**3 / 6}, [0.1])[0] < 1e-10
    outcome = run(chain.changed(stop_time=1.0))
    assert not outcome.notes
    assert outcome.order == 3


def test_listing_order_does_not_matter(c_fmu: Fmus) -> None:
    pair, exact = force_displacement(c_fmu, *BOTH)
    again = errors(replace(pair, components=pair.components[::-1]), exact, [0.1])
    assert again == pytest.approx(errors(pair, exact, [0.1]), rel=1e-9)


@pytest.mark.parametrize("options", [("", "+state"), ("+state", "")])
@pytest.mark.parametrize("make", CASES)
def test_one_fmu_that_cannot_go_back(
    c_fmu: Fmus, make: Callable[[Fmus, str, str], Case], options: tuple[str, str]
) -> None:
    case = make(c_fmu, *options)
    assert orders(errors(*case, STEPS)).min() > 1.9
    (note,) = run(case[0].changed(stop_time=1.0, algorithm="corrector")).notes
    name = "a" if options[0] == "" else "b"
    assert note.startswith(f"{name} cannot roll back (canGetAndSetFMUstate)")
    assert "second order instead of third" in note


def test_where_nothing_goes_back_it_is_gauss_seidel_and_says_so(c_fmu: Fmus) -> None:
    pair, exact = force_displacement(c_fmu, "", "")
    assert errors(pair, exact, [0.1]) == errors(pair, exact, [0.1], "gauss_seidel")
    pair = pair.changed(stop_time=1.0, algorithm="corrector")
    assert "ran as gauss_seidel, second order instead of third" in run(pair).notes[0]
    assert not run(pair.changed(algorithm="gauss_seidel")).notes


def test_an_input_that_moves_along_another_is_told(c_fmu: Fmus) -> None:
    pair = two_masses(c_fmu, "mass+state", "moving_partner+state")
    (note,) = run(pair.changed(stop_time=1.0, algorithm="corrector")).notes
    assert note.startswith("b moves end.x along end.vx")


def test_several_that_do_without_are_told_in_one_line(c_fmu: Fmus) -> None:
    parts = {f"m{name}": "mass+state" for name in "bcde"}
    parts |= {**dict.fromkeys("bcd", "moving_partner+state"), "e": "spring"}
    start = {f"m{name}": {"stiffness": 1.0} for name in "bcd"}
    ways = [f"m{name}.m <-> {name}.end" for name in "bcde"]
    settings = Simulation(1, 0.1, "corrector")
    (note,) = run(system(c_fmu, parts, *ways, start=start, simulation=settings)).notes
    assert note == (
        "e cannot roll back (canGetAndSetFMUstate): it steps once, on inputs of the first pass; b, "
        "c and d move b.end.x along b.end.vx (and 2 more) and follow no higher derivatives "
        "(canInterpolateInputs): second order instead of third: half the step leaves a quarter of "
        "the error, not an eighth"
    )


def test_a_last_step_that_is_shorter_costs_no_order(c_fmu: Fmus) -> None:
    # 10 s are 153 steps of 0.065 s and one of 0.055 s, or 307 of 0.0325 s and one of 0.0225 s
    coarse, fine = errors(*force_displacement(c_fmu, *BOTH), [0.065, 0.0325])
    assert coarse / fine > 2**2.9
