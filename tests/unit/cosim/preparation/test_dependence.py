"""Dependencies that FMUs do not declare: probed, declared in the system file, watched in the run.

Two references. Ring: y₁′ = y₂, y₂′ = −y₁, y₁ = cos t, of integrators without feed-through. Added
mass: a unit mass on a unit spring with added mass that comes back as a force, x = cos(t/√(1 + r)),
an algebraic loop that explicit exchange cannot couple where r > 1.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Outcome,
    Simulation,
    System,
    Timing,
    load_system,
    prepare,
    run,
    save_system,
)
from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.errors import RunError

RING = ("a.y -> b.u", "b.y -> a.u")


def ring(
    fmus: Fmus, model: str, algorithm: str = "gauss_seidel", *, gain: float = -1.0, y: float = 0.0
) -> System:
    start = {"a": {"y": y} if y else {}, "b": {"gain": gain}}
    settings = Simulation(5.0, 0.05, algorithm)
    return system(fmus, {"a": model, "b": model}, *RING, start=start, simulation=settings)


def added_mass(fmus: Fmus, algorithm: str, options: str = "", ratio: float = 2.0) -> System:
    version, _, options = options.rpartition(":")
    version += ":" * bool(version)
    names = {"a": f"{version}blind_mass{options}", "b": f"{version}blind_added_mass{options}"}
    start = {"a": {"body.m.x": 1.0}, "b": {"added": ratio}}
    settings = Simulation(3.0, 0.05, algorithm)
    return system(fmus, names, "a.m <-> b.end", start=start, simulation=settings)


def stated(given: System, **dependencies: Sequence[str]) -> System:
    """The system with dependencies stated of all components."""
    parts = tuple(replace(part, dependencies=dependencies) for part in given.components)
    return replace(given, components=parts)


def compared(given: System, name: str, true: Callable) -> tuple[float, float, Outcome]:
    """The largest error of an output over its range, the largest stated one, and the outcome."""
    rows, outcome = observed(given, name)
    times, values = np.array(rows).T
    assert isinstance(outcome.certificate, CouplingErrorReport)
    found = outcome.certificate.errors[0].error
    return float(np.abs(values - true(times)).max() / np.ptp(true(times))), found, outcome


@pytest.mark.parametrize(
    ("version", "algorithm", "options"),
    [
        ("", "corrector", "+state"),
        ("1:", "gauss_seidel", ""),
        ("3:", "jacobi", ""),
        ("3:", "implicit", "+state"),
    ],
)
def test_a_ring_that_declares_nothing_is_coupled_as_one_that_does(
    c_fmu: Fmus, version: str, algorithm: str, options: str
) -> None:
    blind = ring(c_fmu, f"{version}blind_integrator{options}", algorithm, y=1.0)
    error, told, outcome = compared(blind, "a.y", np.cos)
    assert error / 3 < told < 3 * error
    assert error < (5e-2 if algorithm == "jacobi" else 2e-3)
    assert "a, b: no dependencies are declared; probed, y follows no input" in outcome.notes
    assert not prepare(blind).structure.loops
    known = ring(c_fmu, f"{version}integrator{options}", algorithm, y=1.0)
    assert compared(known, "a.y", np.cos)[:2] == (error, told)


@pytest.mark.parametrize(
    ("algorithm", "options", "ratio"),
    [
        ("jacobi", "", 20.0),
        ("gauss_seidel", "3:", 2.0),
        ("corrector", "", 0.5),
        ("corrector", "1:", 20.0),
        ("corrector", "+state", 2.0),
        ("implicit", "+state", 20.0),
    ],
)
def test_a_true_loop_is_solved(c_fmu: Fmus, algorithm: str, options: str, ratio: float) -> None:
    given = added_mass(c_fmu, algorithm, options, ratio)
    error, told, _ = compared(given, "a.body.m.x", lambda t: np.cos(t / np.sqrt(1 + ratio)))
    assert error / 3 < told < 3 * error
    assert error < (3e-2 if algorithm == "jacobi" else 2e-3)
    finer = given.changed(step_size=0.025)
    half, _, _ = compared(finer, "a.body.m.x", lambda t: np.cos(t / np.sqrt(1 + ratio)))
    order = 1 if algorithm == "jacobi" else 2
    assert np.log2(error / half) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("algorithm", ["corrector", "jacobi"])
def test_what_shows_in_the_next_step_only_is_of_first_order(c_fmu: Fmus, algorithm: str) -> None:
    """A mass and an added mass that are computed in steps; loops of less than 1 do not grow."""
    given = added_mass(c_fmu, algorithm, "+lazy", 0.3)
    rate = 1 / np.sqrt(1.3)
    error, told, outcome = compared(given, "a.body.m.ax", lambda t: -np.cos(rate * t) * rate**2)
    assert outcome.order == 1
    assert "(and 1 more) shows its FMU's inputs only after the next step" in str(outcome.notes)
    assert error / 3 < told < 3 * error
    cases = (given.changed(step_size=step) for step in (0.05, 0.025))
    one, half = (compared(case, "a.body.m.x", lambda t: np.cos(rate * t))[0] for case in cases)
    assert one / half == pytest.approx(2.0, rel=0.1)


def test_an_fmu_that_refuses_a_value_is_assumed_to_depend(c_fmu: Fmus) -> None:
    given = ring(c_fmu, "blind_integrator+picky", y=0.1)
    error, told, outcome = compared(given, "a.y", lambda t: 0.1 * np.cos(t))
    assert error / 3 < told < 3 * error
    notes = "\n".join(outcome.notes)
    assert "y may depend on every input (probing it failed: a (blind_integrator_picky.fmu)" in notes
    assert "fmi2SetReal answered Error" in notes
    assert prepare(given).structure.loops


def test_an_fmu_of_one_instance_is_not_probed(c_fmu: Fmus) -> None:
    given = ring(c_fmu, "blind_integrator+once", y=1.0)
    error, told, outcome = compared(given, "a.y", np.cos)
    assert error / 3 < told < 3 * error
    assert "its FMU allows one instance only" in str(outcome.notes)
    assert "under `dependencies`" in str(outcome.notes)
    again = stated(given, y=())
    assert not prepare(again).structure.loops
    assert compared(again, "a.y", np.cos)[0] == pytest.approx(error, rel=1e-6)


def test_a_dependence_that_comes_later_is_seen(c_fmu: Fmus) -> None:
    """y = u from 0.5 s on, 0 before: all three points of the probe are earlier."""
    names = {"a": "latch", "b": "blind_integrator"}
    start, settings = {"b": {"y": 1.0, "gain": -1.0}}, Simulation(1.0, 0.05, "gauss_seidel")
    given = system(c_fmu, names, *RING, start=start, simulation=settings)
    (warning,) = run(given).warnings
    when = re.search(r"a\.y changed at t = (\S+) s when inputs were set", warning)
    assert when
    assert 0.5 <= float(when[1]) <= 1.0
    assert "under `dependencies` of a" in warning
    assert not run(stated(given, y=["u"])).warnings
    assert run(given.changed(stop_time=0.55)).warnings  # the end is looked at, always
    assert not run(given.changed(stop_time=0.4)).warnings


@pytest.mark.parametrize(
    ("model", "needs", "who"),
    [
        ("late_added_mass", None, "its FMU, late_added_mass.fmu, declares"),
        ("3:late_added_mass+state", None, "its FMU, late_added_mass_state_fmi3.fmu, declares"),
        ("added_mass", {"end.force_x": ["end.ax"]}, "the system file declares"),
        ("blind_added_mass", {"end.force_x": []}, "the system file declares"),
    ],
)
def test_a_dependence_that_is_not_declared_is_seen(
    c_fmu: Fmus, model: str, needs: Mapping | None, who: str
) -> None:
    """Force of an added mass and a spring, which follows the acceleration and the position."""
    a = Component("a", FmuFile(c_fmu("mass")), {"body.m.x": 1.0})
    start = {"added": 0.1, "stiffness": 1.0}
    b = Component("b", FmuFile(c_fmu(model)), start, dependencies=needs or {})
    system = System("s", (a, b), ("a.m <-> b.end",), Simulation(1.0, 0.05))
    (warning,) = run(system).warnings
    assert "b.end.force_x changed at t = 0.05 s when inputs were set" in warning
    assert f"though {who} no such dependence" in warning
    assert "write the inputs under `dependencies` of b in the system file" in warning
    found = {"end.force_x": ["end.x", "end.ax"]}
    mended = Component("b", b.source, start, dependencies=found)
    assert not run(System("s", (a, mended), system.connections, system.simulation)).warnings


SHARED = """\
name: shared
components:
  a: {kind: python, file: integral.py}
  b: {kind: python, file: both.py, dependencies: {y1: [u], y2: [v]}}
  c: {kind: python, file: half.py}
  d: {kind: python, file: half.py}
connections: [a.y -> b.u, b.y1 -> c.x, c.y -> b.v, b.y2 -> d.x, d.y -> b.w, b.y1 -> a.x]
simulation: {stop_time: 0.2, step_size: 0.05}
"""
PARTS = {
    "integral": """\
class Integral:
    inputs = {"x": "1"}
    outputs = {"y": "1"}
    states = {"s": (1.0, "1")}
    def rates(self, t, v): return {"s": -v.x}
    def calculate(self, t, v): return {"y": v.s}
""",
    "half": """\
class Half:
    inputs = {"x": "1"}
    outputs = {"y": "1"}
    def calculate(self, t, v): return {"y": v.x / 2}
""",
    "both": """\
class Both:
    inputs = {"u": "1", "v": "1", "w": "1"}
    outputs = {"y1": "1", "y2": "1"}
    def calculate(self, t, v): return {"y1": v.u + v.v / 2, "y2": v.v + v.w / 2}
""",
}


def test_outputs_are_judged_each_by_its_own_inputs(tmp_path: Path) -> None:
    """y1 follows v, which y2 is said to follow; y2 follows w."""
    for name, text in PARTS.items():
        (tmp_path / f"{name}.py").write_text(text)
    (tmp_path / "s.yaml").write_text(SHARED)
    (warning,) = run(tmp_path / "s.yaml", build_directory=tmp_path / "build").warnings
    assert "b.y1 and b.y2 changed at t = 0.05 s when inputs were set" in warning


@pytest.mark.parametrize("algorithm", ["corrector", "gauss_seidel", "jacobi"])
def test_a_delay_is_of_first_order_and_certified(c_fmu: Fmus, algorithm: str) -> None:
    """y₁ = t + 0.5 y₂(t − H), y₂ = t − 0.5 y₁: against the solution without delay, 1.2 t."""
    given = system(
        c_fmu,
        {"a": "blind_stage", "b": "blind_stage"},
        RING[0],
        f"{RING[1]}, delayed",
        start={"a": {"gain": 0.5}, "b": {"gain": -0.5}},
        simulation=Simulation(2.0, 0.05, algorithm),
    )
    found = prepare(given)
    assert not found.structure.loops
    late = [str(k) for k, timing in found.timings.items() if timing is Timing.DELAYED]
    assert late == ["b.y -> a.u"]
    (error, told, outcome), (half, *_) = (
        compared(given.changed(step_size=step), "a.y", lambda t: 1.2 * t) for step in (0.05, 0.025)
    )
    assert outcome.order == 1
    assert "b.y -> a.u has the value of the previous step" in str(outcome.notes)
    assert error / 3 < told < 3 * error
    assert error / half == pytest.approx(2.0, rel=0.05)


def test_every_remedy_for_a_loop_without_solution_leads_to_a_run(c_fmu: Fmus) -> None:
    """y₁ = y₂ + t, y₂ = y₁ + t."""
    given = ring(c_fmu, "1:blind_stage", gain=1.0).changed(stop_time=1.0)
    with pytest.raises(RunError, match=r"loop of a\.u, b\.u is singular at t = 0 s") as caught:
        run(given)
    remedies = ("signs of the connections", "', delayed'", "`dependencies`")
    assert all(text in str(caught.value) for text in remedies)
    run(ring(c_fmu, "1:blind_stage", gain=-1.0))
    assert run(replace(given, connections=(RING[0], f"{RING[1]}, delayed"))).order == 1
    run(stated(given, y=[]))


def test_a_loop_through_a_sampled_component_is_delayed_there(c_fmu: Fmus) -> None:
    a, b = ring(c_fmu, "blind_stage", gain=0.3).components
    parts = (a, replace(b, step_size=0.2))
    found = prepare(System("s", parts, RING, Simulation(1, 0.1)))
    assert not found.structure.loops
    notes = "\n".join(found.notes)
    assert "leads through b" in notes
    assert "a.y -> b.u has the value of the previous step" in notes
    assert run(found).order == 1


def silenced(fmu: Path, folder: Path) -> Path:
    """The FMU without what it declares of dependencies."""
    silent = folder / fmu.name
    declared = rb'(?s) dependencies="[^"]*"|<DirectDependency>.*?</DirectDependency>'
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(silent, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content, count = re.subn(declared, b"", content)
                assert count
            new.writestr(name, content)
    return silent


@pytest.mark.parametrize(
    ("version", "option"), [("", ""), ("", "+through"), ("1:", ""), ("3:", "+through")]
)
def test_values_of_all_types_are_probed(
    c_fmu: Fmus, tmp_path: Path, version: str, option: str
) -> None:
    fmu = FmuFile(silenced(c_fmu(f"{version}kinds{option}"), tmp_path))
    kinds = ("int", "bool", "enum", "text")
    links = tuple(f"{a}.y_{k} -> {b}.u_{k}" for k in kinds for a, b in ("ab", "ba"))
    parts = (Component("a", fmu), Component("b", fmu))
    found = prepare(System("s", parts, links, Simulation(1.0, 0.1, "gauss_seidel")))
    late = "" if option else " before its next step"
    (line,) = (note for note in found.notes if "no dependencies are declared" in note)
    for kind in kinds:
        follows = f"u_{kind}" if option else "none of u_bool, u_enum, u_int, u_text"
        assert f"y_{kind} follows {follows}{late}" in line
    assert any(k.delayed for k in found.wiring.links) is bool(option)
    run(found)


def test_dependencies_and_delays_survive_in_an_ssp_package(c_fmu: Fmus, tmp_path: Path) -> None:
    links = (RING[0], f"{RING[1]}, delayed")
    given = replace(stated(ring(c_fmu, "blind_stage", gain=-0.5), y=["u"]), connections=links)
    again = load_system(save_system(given, tmp_path / "s.ssp", build_directory=tmp_path))
    assert again.connections == links
    assert [{k: [*v] for k, v in c.dependencies.items()} for c in again.components] == [
        {"y": ["u"]}
    ] * 2
    assert [k.delayed for k in prepare(again).wiring.links] == [False, True]
