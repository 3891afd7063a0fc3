"""Dependencies that FMUs do not declare: probed, declared in the system file, watched in the run.

Two references. Ring: y₁′ = y₂, y₂′ = −y₁, y₁ = cos t, of integrators without feed-through. Added
mass: a unit mass on a unit spring with added mass that comes back as a force, x = cos(t/√(1 + r)),
an algebraic loop that explicit exchange cannot couple where r > 1.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

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
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport
from m4e_fmi.errors import RunError

Fmus = Callable[[str], Path]
RING = ("a.y -> b.u", "b.y -> a.u")


def ring(fmus: Fmus, model: str, algorithm: str = "gauss_seidel", gain: float = -1.0) -> System:
    a = Component("a", FmuFile(fmus(model)))
    b = Component("b", FmuFile(fmus(model)), {"gain": gain})
    return System("ring", (a, b), RING, Simulation(5.0, 0.05, algorithm))


def oscillating(fmus: Fmus, model: str, algorithm: str) -> System:
    return ring(fmus, model, algorithm).changed(start={"a.y": 1.0})


def added_mass(fmus: Fmus, algorithm: str, options: str = "", ratio: float = 2.0) -> System:
    version, _, options = options.rpartition(":")
    version += ":" * bool(version)
    a = Component("a", FmuFile(fmus(f"{version}blind_mass{options}")), {"body.m.x": 1.0})
    b = Component("b", FmuFile(fmus(f"{version}blind_added_mass{options}")), {"added": ratio})
    return System("s", (a, b), ("a.m <-> b.end",), Simulation(3.0, 0.05, algorithm))


def compared(system: System, name: str, true: Callable) -> tuple[float, float, Outcome]:
    """The largest error of an output over its range, the largest stated one, and the outcome."""
    seen: dict[float, float] = {}
    outcome = run(system, observers=[lambda t, network: seen.update({t: network.read(name)})])
    times, values = np.array(list(seen)), np.array(list(seen.values()))
    assert isinstance(outcome.certificate, CouplingErrorReport)
    stated = outcome.certificate.errors[0].error
    return float(np.abs(values - true(times)).max() / np.ptp(true(times))), stated, outcome


@pytest.mark.parametrize(
    ("version", "algorithm"), [("", "corrector"), ("1:", "gauss_seidel"), ("3:", "jacobi")]
)
def test_a_ring_that_declares_nothing_runs(c_fmu: Fmus, version: str, algorithm: str) -> None:
    system = oscillating(c_fmu, f"{version}blind_integrator", algorithm)
    error, stated, outcome = compared(system, "a.y", np.cos)
    assert error / 3 < stated < 3 * error
    assert error < (5e-2 if algorithm == "jacobi" else 2e-3)
    assert "a, b: no dependencies are declared; probed, y follows no input" in outcome.notes
    assert not prepare(system).structure.loops


@pytest.mark.parametrize(("version", "algorithm"), [("", "corrector"), ("3:", "implicit")])
def test_and_is_coupled_as_declared_ones_are(c_fmu: Fmus, version: str, algorithm: str) -> None:
    blind = oscillating(c_fmu, f"{version}blind_integrator+state", algorithm)
    known = oscillating(c_fmu, f"{version}integrator+state", algorithm)
    one, other = (compared(system, "a.y", np.cos)[:2] for system in (blind, known))
    assert one == other


@pytest.mark.parametrize("options", ["", "3:+state", "1:+lazy"])
def test_each_component_is_probed_alone(c_fmu: Fmus, options: str) -> None:
    """Which of its outputs follow which inputs, in `info` and in the summary."""
    told = str(prepare(added_mass(c_fmu, "gauss_seidel", options)))
    late = " before its next step" if "lazy" in options else ""
    of_a, of_b = ("no input", "no input") if late else ("body.m.force_x", "end.ax, end.x")
    probed = "no dependencies are declared; probed"
    of_a = f"body.m.ax follows {of_a}{late}; body.m.x follows no input"
    assert f"a: {probed}, {of_a}\n" in told
    assert f"b: {probed}, end.force_x follows {of_b}{late}\n" in told
    assert ("algebraic loops, solved at every" in told) is not bool(late)


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
    system = added_mass(c_fmu, algorithm, options, ratio)
    error, stated, _ = compared(system, "a.body.m.x", lambda t: np.cos(t / np.sqrt(1 + ratio)))
    assert error / 3 < stated < 3 * error
    assert error < (3e-2 if algorithm == "jacobi" else 2e-3)
    finer = system.changed(step_size=0.025)
    half, _, _ = compared(finer, "a.body.m.x", lambda t: np.cos(t / np.sqrt(1 + ratio)))
    order = 1 if algorithm == "jacobi" else 2
    assert np.log2(error / half) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("algorithm", ["corrector", "jacobi"])
def test_what_shows_in_the_next_step_only_is_of_first_order(c_fmu: Fmus, algorithm: str) -> None:
    """A mass and an added mass that are computed in steps; loops of less than 1 do not grow."""
    system = added_mass(c_fmu, algorithm, "+lazy", 0.3)
    rate = 1 / np.sqrt(1.3)
    error, stated, outcome = compared(system, "a.body.m.ax", lambda t: -np.cos(rate * t) * rate**2)
    assert outcome.order == 1
    assert "(and 1 more) shows its FMU's inputs only after the next step" in str(outcome.notes)
    assert error / 3 < stated < 3 * error
    cases = (system.changed(step_size=step) for step in (0.05, 0.025))
    one, half = (compared(case, "a.body.m.x", lambda t: np.cos(rate * t))[0] for case in cases)
    assert one / half == pytest.approx(2.0, rel=0.1)


def test_an_fmu_that_refuses_a_value_is_assumed_to_depend(c_fmu: Fmus) -> None:
    system = oscillating(c_fmu, "blind_integrator+picky", "gauss_seidel")
    system = system.changed(start={"a.y": 0.1})
    error, stated, outcome = compared(system, "a.y", lambda t: 0.1 * np.cos(t))
    assert error / 3 < stated < 3 * error
    told = next(note for note in outcome.notes if note.startswith("a, b: ") or note[:3] == "a: ")
    assert "y may depend on every input (probing it failed: a (blind_integrator_picky.fmu)" in told
    assert "fmi2SetReal answered Error" in told
    assert prepare(system).structure.loops


def test_an_fmu_of_one_instance_is_not_probed(c_fmu: Fmus) -> None:
    system = oscillating(c_fmu, "blind_integrator+once", "gauss_seidel")
    error, stated, outcome = compared(system, "a.y", np.cos)
    assert error / 3 < stated < 3 * error
    assert "its FMU allows one instance only" in str(outcome.notes)
    assert "under `dependencies`" in str(outcome.notes)
    parts = tuple(replace(part, dependencies={"y": ()}) for part in system.components)
    again = replace(system, components=parts)
    assert not prepare(again).structure.loops
    assert compared(again, "a.y", np.cos)[0] == pytest.approx(error, rel=1e-6)


def test_a_dependence_that_comes_later_is_seen(c_fmu: Fmus) -> None:
    """y = u from 0.5 s on, 0 before: all three points of the probe are earlier."""
    a = Component("a", FmuFile(c_fmu("latch")))
    b = Component("b", FmuFile(c_fmu("blind_integrator")), {"y": 1.0, "gain": -1.0})
    system = System("s", (a, b), RING, Simulation(1.0, 0.05, "gauss_seidel"))
    (warning,) = run(system).warnings
    when = re.search(r"a\.y has changed at t = (\S+) s when u was set", warning)
    assert when
    assert 0.5 <= float(when[1]) <= 1.0
    assert "under `dependencies` of a" in warning
    stated = Component("a", a.source, dependencies={"y": ["u"]})
    settled = run(System("s", (stated, b), RING, system.simulation))
    assert not settled.warnings
    late = run(system.changed(stop_time=0.55))  # the end is looked at, always
    assert late.warnings
    early = run(system.changed(stop_time=0.4))
    assert not early.warnings


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
    missing = "end.x" if needs and needs["end.force_x"] else "end.x, end.ax"
    assert f"b.end.force_x follows {missing} at once, as seen at t = 0.05 s" in warning
    assert f"though {who} no such dependence" in warning
    remedy = re.search(r"`dependencies: (\{.*?\})` under b", warning)
    assert remedy
    found = yaml.safe_load(remedy[1])
    assert found == {"end.force_x": ["end.x", "end.ax"]}
    mended = Component("b", b.source, start, dependencies=found)
    assert not run(System("s", (a, mended), system.connections, system.simulation)).warnings


def test_a_delay_is_of_first_order_and_certified(c_fmu: Fmus) -> None:
    """y₁ = t + 0.5 y₂(t − H), y₂ = t − 0.5 y₁: against the solution without delay, 1.2 t."""
    parts = (
        Component("a", FmuFile(c_fmu("blind_stage")), {"gain": 0.5}),
        Component("b", FmuFile(c_fmu("blind_stage")), {"gain": -0.5}),
    )
    links = ("a.y -> b.u", "b.y -> a.u, delayed")
    for algorithm in ("corrector", "gauss_seidel", "jacobi"):
        system = System("s", parts, links, Simulation(2.0, 0.05, algorithm))
        found = prepare(system)
        assert not found.structure.loops
        (late,) = (k for k, timing in found.timings.items() if timing is Timing.DELAYED)
        assert str(late) == "b.y -> a.u"
        errors = []
        for step in (0.05, 0.025):
            case = compared(system.changed(step_size=step), "a.y", lambda t: 1.2 * t)
            errors.append(case[:2])
            assert case[2].order == 1
            assert "b.y -> a.u has the value of the previous step" in str(case[2].notes)
        (error, stated), (half, _) = errors
        assert error / 3 < stated < 3 * error
        assert error / half == pytest.approx(2.0, rel=0.05)


def test_every_remedy_for_a_loop_without_solution_leads_to_a_run(c_fmu: Fmus) -> None:
    """y₁ = y₂ + t, y₂ = y₁ + t."""
    system = ring(c_fmu, "1:blind_stage", gain=1.0).changed(stop_time=1.0)
    with pytest.raises(RunError) as caught:
        run(system)
    text = str(caught.value)
    assert "algebraic loop of a.u, b.u is singular at t = 0 s" in text
    assert "signs of the connections" in text
    run(ring(c_fmu, "1:blind_stage", gain=-1.0))
    assert "', delayed'" in text
    delayed = System("s", system.components, (RING[0], f"{RING[1]}, delayed"), system.simulation)
    assert run(delayed).order == 1
    assert "`dependencies`" in text
    parts = tuple(replace(part, dependencies={"y": []}) for part in system.components)
    run(replace(system, components=parts))


def test_a_loop_through_a_sampled_component_is_delayed_there(c_fmu: Fmus) -> None:
    parts = (
        Component("a", FmuFile(c_fmu("blind_stage")), {"gain": 0.2}),
        Component("b", FmuFile(c_fmu("blind_stage")), {"gain": 0.3}, step_size=0.2),
    )
    found = prepare(System("s", parts, RING, Simulation(1, 0.1)))
    assert not found.structure.loops
    assert any(
        "leads through b" in note and "a.y -> b.u has the value of the previous step" in note
        for note in found.notes
    )
    outcome = run(found)
    assert outcome.order == 1


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
    first = ring(c_fmu, "blind_stage", gain=-0.5)
    a = Component("a", first.components[0].source, dependencies={"y": ["u"]})
    links = (RING[0], f"{RING[1]}, delayed")
    system = System("s", (a, first.components[1]), links, first.simulation)
    again = load_system(save_system(system, tmp_path / "s.ssp", build_directory=tmp_path))
    assert again.connections == links
    found = {c.name: {k: list(v) for k, v in c.dependencies.items()} for c in again.components}
    assert found == {"a": {"y": ["u"]}, "b": {}}
    assert not prepare(System("s", again.components, links, first.simulation)).structure.loops
    assert [k.delayed for k in prepare(again).wiring.links] == [False, True]
