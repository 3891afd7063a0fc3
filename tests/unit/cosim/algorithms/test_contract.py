"""What every coupling algorithm must do, also one that is added in a file of its own.

Its order is measured here on one system; cases from the literature, energy, stability, events and
saved states are in tests/verification/test_cosim_*.py.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.interrupted import check_resumed
from support.python_executor import use_python
from support.small_systems import Fmus, observed, oscillator, system, watched

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Simulation,
    System,
    load,
    run,
)
from m4e_fmi.cosim.network.newton import TOLERANCE
from m4e_fmi.coupling_algorithms import algorithm_descriptor, algorithm_names
from m4e_fmi.errors import RunError

pytestmark = [
    pytest.mark.parametrize("algorithm", [*algorithm_names(), "last_first"]),
    pytest.mark.usefixtures("example"),
]
ROUNDING = 1e-12
"""Of numbers of size 1 after 50 steps, each of which adds some 1e-16."""


def accuracy(algorithm: str) -> float:
    """To which two runs of the same equations agree: `implicit` solves them to a tolerance."""
    return 50 * TOLERANCE if algorithm == "implicit" else ROUNDING


def pair(fmus: Fmus, algorithm: str, options: str = "", **own: Any) -> System:
    """Two unit masses and springs, of which the second may have steps of its own; H = 0.05 s."""
    settings: dict[str, Any] = {"stop_time": 1.0, "step_size": 0.05, "algorithm": algorithm}
    settings |= {key: own.pop(key) for key in list(own) if key != "step"}
    parts = (
        Component("a", FmuFile(fmus("mass+state+inputs")), {"stiffness": 1.0, "body.m.x": 1.0}),
        Component("b", FmuFile(fmus(f"partner+state{options}")), step_size=own.get("step")),
    )
    return System("s", parts, ("a.m <-> b.end",), Simulation(**settings))


def test_its_order_is_what_it_says(c_fmu: Fmus, algorithm: str) -> None:
    errors, order = [], algorithm_descriptor(algorithm).order
    for step in (0.1, 0.05, 0.025):
        given = pair(c_fmu, algorithm, "+inputs", stop_time=4.0, step_size=step)
        rows, outcome = observed(given, "a.body.m.x")
        t, x = np.array(rows).T
        errors.append(np.abs(x - (np.cos(t) + np.cos(np.sqrt(3.0) * t)) / 2).max())
        assert outcome.order == order
    # a fifth below it: terms of the next order
    assert np.log2(errors[1] / errors[2]) > order - 0.2


@pytest.mark.parametrize(("stop", "step"), [(0.3, 0.1), (0.7, 0.1), (2e-4, 1e-4), (0.9, 0.3)])
def test_no_step_goes_beyond_the_stop_time(
    c_fmu: Fmus, algorithm: str, stop: float, step: float
) -> None:
    """0.2 + 0.1 is more than 0.3 in doubles."""
    outcome = run(oscillator(c_fmu, Simulation(stop, step, algorithm), "+state+strict"))
    assert outcome.steps == round(stop / step)


def test_values_that_follow_inputs_at_once_are_of_the_same_point(
    c_fmu: Fmus, algorithm: str
) -> None:
    """y = gain u + t in a row of three that is listed against the flow; the last is a step late."""
    names: dict[str, str] = dict.fromkeys(("late", "third", "second", "first"), "stage+state")
    links = ("first.y -> second.u", "second.y -> third.u", "first.y -> late.u, delayed")
    start = {"first": {"gain": 2.0, "u": 5.0}, "second": {"gain": 3.0}, "third": {"gain": 4.0}}
    given = system(c_fmu, names, *links, start=start, simulation=Simulation(0.5, 0.1, algorithm))
    for t, third, late in observed(given, "third.y", "late.u")[0]:
        assert third == pytest.approx(((10 + t) * 3 + t) * 4 + t, abs=1e-12)
        assert late == pytest.approx(10 + max(0.0, t - 0.1), abs=1e-12)


@pytest.mark.parametrize(
    ("what", "told"), [(2, "Discard"), (3, "Error"), (4, "Fatal"), (8, "inf"), (9, "nan")]
)
def test_a_failing_component_is_named_and_results_are_kept(
    c_fmu: Fmus, tmp_path: Path, what: int, told: str, algorithm: str
) -> None:
    path = tmp_path / "r.nc"
    start = {"pump": {"what": float(what), "when": 0.5}}
    names = {"body": "mass+state", "pump": "rogue+state", "next": "stage+state"}
    names["spring"] = "spring+state"  # one bond for the corrector to correct
    links = ("pump.y -> next.u", "body.m <-> spring.end")
    settings = Simulation(1, 0.1, algorithm)
    with pytest.raises(RunError) as caught:
        run(system(c_fmu, names, *links, start=start, simulation=settings), results=path)
    message, remedy = caught.value.message, caught.value.remedy
    assert "pump" in message
    assert told in message
    assert ("the pump ran dry" in message) == (what < 5)
    assert re.search(r"t = 0\.(4|425|45|475|5) s", message)
    assert ("step_size" in remedy) == (what not in (3, 4))
    assert remedy.startswith("fix the problem stated by the FMU first") == (what < 5)
    results = load(path)
    assert f"results until t = {results.time[-1]:.9g} s are in {path}" in remedy
    # where all can go back, a discarded step is made again up to where the FMU can go
    goes_on = what == 2 and algorithm in ("corrector", "implicit")
    assert ("; pump has discarded every step from there, of 0.1 s down to" in message) is goes_on
    assert results.time[-1] == pytest.approx(0.5 if goes_on else 0.4, abs=1e-6)
    np.testing.assert_allclose(results.time[:5], [0, 0.1, 0.2, 0.3, 0.4], atol=1e-15)
    assert all(np.isfinite(s.values).all() for g in results.components.values() for s in g.values())
    assert results.attributes["ended"] == f"failed: {message}"


@pytest.mark.parametrize("options", ["", "+state", "+state+inputs", "+state+jacobian"])
def test_other_units_and_factors_reach_the_same_place(
    c_fmu: Fmus, algorithm: str, options: str
) -> None:
    if not options and algorithm_descriptor(algorithm).needs_rollback:
        pytest.skip("needs rollback")

    def motion(spring: str, stiffness: float, *links: str) -> tuple[np.ndarray, Any]:
        start = {"body": {"body.m.x": 1.0, "stiffness": 1.0}, "spring": {"stiffness": stiffness}}
        names = {"body": f"mass{options}", "spring": f"{spring}{options}"}
        given = system(c_fmu, names, *links, start=start, simulation=Simulation(5, 0.1, algorithm))
        found, outcome = observed(given, "body.body.m.x", "spring.end.force_x")
        return np.array(found), outcome.energy

    whole, tolerance = "body.m <-> spring.end", accuracy(algorithm)
    plain, (expected,) = motion("spring", 3.0, whole)
    millimetres, (bond,) = motion("mm_spring", 3e-3, whole)
    np.testing.assert_allclose(millimetres, plain, rtol=0, atol=tolerance)
    assert bond.given == pytest.approx(expected.given, abs=tolerance)
    assert bond.received == pytest.approx(expected.received, abs=tolerance)
    # k = 3 against a wall at 0.5 m: force = -1.5 (2 x - 1) by way of the connections
    scaled = (
        "body.body.m.x * 2 - 1 -> spring.end.x",
        "body.body.m.vx * 2 -> spring.end.vx",
        "spring.end.force_x * 0.5 -> body.body.m.force_x",
    )
    at_half = ("body.body.m.x -> spring.end.x", "spring.end.force_x + 1.5 -> body.body.m.force_x")
    _, place, force = motion("spring", 3.0, *scaled)[0].T
    np.testing.assert_allclose(place, motion("spring", 3.0, *at_half)[0][:, 1], atol=tolerance)
    np.testing.assert_allclose(force, -3.0 * (2 * place - 1), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("options", ["", "+inputs"])
def test_an_fmu_of_one_size_of_step_makes_no_other(
    c_fmu: Fmus, algorithm: str, options: str
) -> None:
    """One refuses all but 0.01 s, of which H is no exact multiple; one all but its first."""
    for given in (
        pair(c_fmu, algorithm, f"{options}+hundredth", step="10 ms"),
        pair(c_fmu, algorithm, f"{options}+constant"),
    ):
        assert run(given).certificate.errors  # pyrefly: ignore[missing-attribute]
    first = "fix the problem stated by the FMU first; "
    own = r"if 0\.0\d+ s is not the step that it was made for, give the component that as its own"
    with pytest.raises(RunError, match=r"I make steps of 0.01 s") as caught:
        run(pair(c_fmu, algorithm, f"{options}+hundredth"))
    assert re.match(first + own, caught.value.remedy)
    with pytest.raises(RunError) as caught:
        run(pair(c_fmu, algorithm, f"{options}+hundredth+constant"))
    assert re.match(f"{first}it accepts one step size only: {own}", caught.value.remedy)


KINDS = ("int", "bool", "enum", "text")


def put(number: int, boolean: bool, item: int, text: str, n: int) -> tuple[int, bool, int, str]:
    """Outputs of kinds.c after n periods, for these inputs."""
    return number + n, bool(boolean ^ (n & 1)), (item - 1 + n) % 3 + 1, text + (str(n) if n else "")


def ring(steps: int, periods: Mapping[str, float]) -> list[list[Any]]:
    """Outputs of a ring of components with these periods: each holds what the last point gave."""
    outputs = [put(0, False, 1, "", 0) for _ in periods]
    rows = [[value for one in outputs for value in one]]
    for step in range(1, steps + 1):
        inputs = [outputs[-1], *outputs[:-1]]
        counts = [int(step * 0.1 / p + 1e-6) if p else 0 for p in periods.values()]
        outputs = [put(*one, n) for one, n in zip(inputs, counts, strict=True)]
        rows.append([value for one in outputs for value in one])
    return rows


@pytest.mark.parametrize("python", [False, True])
def test_values_of_all_types_and_versions(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, algorithm: str, python: bool
) -> None:
    """Reals go round as well, so that corrector and solver make each step several times."""
    if python:
        use_python(monkeypatch)
    fmus = {"a": "kinds+state", "b": "3:kinds+state", "c": "1:kinds"}
    if algorithm_descriptor(algorithm).needs_rollback:
        fmus["c"] = "3:kinds+state"
    of = {"a": 0.3, "b": 0.0, "c": 0.45}
    parts = tuple(Component(n, FmuFile(c_fmu(fmu)), {"period": of[n]}) for n, fmu in fmus.items())
    links = tuple(
        f"{a}.y_{k} -> {b}.u_{k}" for a, b in ("ab", "bc", "ca") for k in (*KINDS, "real")
    )
    names = [f"{name}.y_{kind}" for name in of for kind in KINDS]
    found = watched(System("ring", parts, links, Simulation(1.2, 0.1, algorithm)), *names)
    assert found == ring(12, of)


@pytest.mark.parametrize("tolerance", [None, 1e-3])
def test_a_run_that_goes_on_has_the_bits_of_the_undisturbed_run(
    c_fmu: Fmus, tmp_path: Path, algorithm: str, tolerance: float | None
) -> None:
    step = 0.01 if tolerance is None else 0.1
    stop = 22 if algorithm == "gauss_seidel" else 3  # of 2048 steps is the first window
    settings = Simulation(stop, step, algorithm, coupling_tolerance=tolerance)
    whole = oscillator(c_fmu, settings, "+state+bytes")
    told = check_resumed(whole, tmp_path, 0.5, [1.03, stop - 0.2])
    assert all(line.startswith("the run goes on at t = ") for line in told)


LINKS = (
    "body.body.m.x -> spring.end.x",
    "body.body.m.vx -> spring.end.vx",
    "spring.end.force_x -> body.body.m.force_x",
)


@pytest.mark.parametrize("options", ["+state", "+state+inputs", "+state+jacobian"])
def test_forces_of_several_links_are_as_one(c_fmu: Fmus, algorithm: str, options: str) -> None:
    """Springs of 1, 2 and 3 N/m, the last in mm, are as one of 6 N/m; energies add up."""
    springs = {"b": (f"spring{options}", 1.0), "c": (f"spring{options}", 2.0)}
    springs["d"] = (f"mm_spring{options}", 3e-3)
    found = []
    for parts in ({"b": (f"spring{options}", 6.0)}, springs):
        mass = Component("a", FmuFile(c_fmu(f"mass{options}")), {"body.m.x": 1.0})
        own = [Component(n, FmuFile(c_fmu(f)), {"stiffness": k}) for n, (f, k) in parts.items()]
        links = [
            link
            for n in parts
            for link in (
                f"a.body.m.x -> {n}.end.x",
                f"a.body.m.vx -> {n}.end.vx",
                f"{n}.end.force_x -> a.body.m.force_x",
            )
        ]
        settings = Simulation(1.0, 0.02, algorithm)
        found.append(observed(System("s", (mass, *own), tuple(links), settings), "a.body.m.x"))
    (one, alone), (other, split) = found
    assert np.array(other) == pytest.approx(np.array(one), abs=accuracy(algorithm))
    assert (alone.order, len(split.energy)) == (split.order, 3)
    for kind in ("given", "received"):
        total = sum(getattr(bond, kind) for bond in split.energy)
        assert total == pytest.approx(getattr(alone.energy[0], kind), abs=10 * accuracy(algorithm))
