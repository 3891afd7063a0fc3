"""What FMUs of FMI 1.0 and 3.0 say, take and answer."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cli import main
from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Outcome,
    Simulation,
    System,
    prepare,
    run,
    start,
)
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import read_description

Fmus = Callable[[str], Path]
XML = "modelDescription.xml"


def alone(fmu: Path, values: Mapping[str, float | int | bool | str]) -> System:
    return System("s", (Component("a", FmuFile(fmu), values),), (), Simulation(0.3, 0.1))


def reworded(fmu: Path, path: Path, old: str, new: str) -> Path:
    """A copy of an FMU whose description says something else."""
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    assert old.encode() in content[XML]
    content[XML] = content[XML].replace(old.encode(), new.encode())
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return path


def test_an_fmu_of_fmi_1_that_makes_steps_of_one_size_only(c_fmu: Fmus, tmp_path: Path) -> None:
    """Where it is not declared, FMI 1.0 takes it for false."""
    ability = 'canHandleVariableCommunicationStepSize="true"'
    assert not read_description(c_fmu("1:mass")).constant_step
    for k, other in enumerate((ability.replace("true", "false"), "")):
        fmu = reworded(c_fmu("1:mass"), tmp_path / f"{k}.fmu", ability, other)
        assert read_description(fmu).constant_step
        part = (Component("a", FmuFile(fmu)),)
        with pytest.raises(InputError, match="its FMU makes steps of one size only"):
            prepare(System("s", part, (), Simulation(1.0, 0.1, coupling_tolerance=1e-4)))


def test_fmi_1_in_the_words_of_fmi_2(c_fmu: Fmus) -> None:
    mass = read_description(c_fmu("1:mass"))
    assert (mass.version, mass.saves_state, mass.input_order) == ("1.0", False, 0)
    assert read_description(c_fmu("1:partner+inputs")).input_order == 2
    force, x, m = (mass.variables[k] for k in ("body.m.force_x", "body.m.x", "mass"))
    assert (force.causality, force.unit, force.value_reference) == ("input", "N", 3)
    assert force.dimension is not None
    assert force.dimension.si_text == "kg.m/s2"
    assert (x.causality, x.initial) == ("output", "exact")
    assert (m.causality, m.variability, m.initial) == ("parameter", "fixed", "exact")
    assert mass.dependencies["body.m.ax"] == {"body.m.force_x"}
    assert mass.dependencies["body.m.x"] == frozenset()
    assert read_description(c_fmu("1:blind_spring")).undeclared == {"end.force_x"}


def test_negated_aliases_are_left_out(c_fmu: Fmus, tmp_path: Path) -> None:
    old, new = 'name="body.m.vx" ', 'name="body.m.vx" alias="negatedAlias" '
    fmu = reworded(c_fmu("1:mass"), tmp_path / "x.fmu", old, new)
    assert "body.m.vx" not in read_description(fmu).variables


def test_tool_coupling_is_refused(c_fmu: Fmus, tmp_path: Path) -> None:
    fmu = c_fmu("1:mass")
    fmu = reworded(fmu, tmp_path / "half.fmu", "<CoSimulation_StandAlone>", "<CoSimulation_Tool>")
    fmu = reworded(fmu, tmp_path / "x.fmu", "</CoSimulation_StandAlone>", "</CoSimulation_Tool>")
    with pytest.raises(InputError, match=r"CoSimulation_Tool.*cannot start"):
        read_description(fmu)


def test_clocks_to_be_driven_are_refused(c_fmu: Fmus, tmp_path: Path) -> None:
    clock = '<Clock name="tick" valueReference="77" causality="input" intervalVariability="fixed"/>'
    fmu = reworded(
        c_fmu("3:mass"), tmp_path / "x.fmu", "</ModelVariables>", f"{clock}</ModelVariables>"
    )
    with pytest.raises(InputError, match="needs a master with clocks: 'tick'"):
        read_description(fmu)


def test_arrays_too_large_are_refused(c_fmu: Fmus, tmp_path: Path) -> None:
    fmu = reworded(
        c_fmu("3:gallery"), tmp_path / "x.fmu", 'Dimension start="2"', 'Dimension start="2000000"'
    )
    with pytest.raises(InputError, match="elements together"):
        read_description(fmu)


TYPES: dict[str, int | bool | str] = {
    "int8": -5,
    "uint8": 200,
    "int16": -300,
    "uint16": 40000,
    "int32": -70000,
    "uint32": 3_000_000_000,
    "int64": -(2**40),
    "uint64": 2**41,
    "boolean": True,
    "word": "four",
    "bytes": "0a10",
    "mode": "fast",
}
SUM = -5 + 200 - 300 + 40000 - 70000 + 3_000_000_000 - 2**40 + 2**41 + 1 + 4 + 26 + 2


def test_start_values_of_all_types(c_fmu: Fmus) -> None:
    with start(alone(c_fmu("3:gallery"), TYPES)) as stepped:
        assert stepped["a.sum"] == SUM


def test_some_elements_of_an_array_are_set(c_fmu: Fmus) -> None:
    values = {"u[2]": 7.0, "gain": 2.0, "u32[1]": 0.1}
    with start(alone(c_fmu("3:gallery"), values)) as stepped:
        assert [stepped[f"a.y[{k}]"] for k in (1, 2, 3)] == [1.0, 14.0, 1.0]
        assert stepped["a.y32[1]"] == float(np.float32(2) * np.float32(0.1))
        stepped["a.u[3]"] = -1.0
        assert [stepped[f"a.y[{k}]"] for k in (1, 2, 3)] == [1.0, 14.0, -2.0]


def test_a_structural_parameter_gives_arrays_their_size(c_fmu: Fmus) -> None:
    values = {"size": 5, "u[5]": 3.0}
    with start(alone(c_fmu("3:gallery"), values)) as stepped:
        assert [stepped[f"a.y[{k}]"] for k in range(1, 6)] == [0.5, 0.5, 0.5, 0.5, 3.0]
    with pytest.raises(InputError, match=r"no variable 'u\[5\]'"):
        prepare(alone(c_fmu("3:gallery"), {"u[5]": 3.0}))


@pytest.mark.parametrize("by_python", [False, True])
def test_single_elements_and_single_precision_are_connected(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, by_python: bool
) -> None:
    if by_python:
        monkeypatch.setattr("m4e_fmi.cosim.exchange.step_loop.library", lambda: None)
    stage = Component("stage", FmuFile(c_fmu("stage")), {"gain": 0.0})  # y is the time
    gallery = Component("g", FmuFile(c_fmu("3:gallery")), {"gain": 3.0, "u[1]": 9.0})
    connections = tuple(
        f"{a}, units ignored" for a in ("stage.y -> g.u[2]", "stage.y * 2 -> g.u32[2]")
    )
    system = System("s", (stage, gallery), connections, Simulation(0.5, 0.25, "jacobi"))
    names = ("g.y[1]", "g.y[2]", "g.y[3]", "g.y32[2]")
    found: list[list[float]] = []
    run(system, observers=[lambda _, n: found.append([n.read(name) for name in names])])
    assert found == [[27.0, 3 * t, 1.5, 6 * t] for t in (0.0, 0.25, 0.5)]


@pytest.mark.parametrize("version", ["1:", "3:"])
@pytest.mark.parametrize(("what", "message"), [(2.0, "Discard"), (3.0, "Error"), (4.0, "Fatal")])
def test_failures_are_told_in_the_fmus_own_words(
    c_fmu: Fmus, version: str, what: float, message: str
) -> None:
    rogue = Component("a", FmuFile(c_fmu(f"{version}rogue")), {"what": what, "when": 0.15})
    system = System("s", (rogue,), (), Simulation(1.0, 0.1, "jacobi"))
    with pytest.raises(RunError, match=f"DoStep answered {message}.*the pump ran dry"):
        run(system)


@pytest.mark.parametrize("version", ["1:", "3:"])
def test_units_are_converted(c_fmu: Fmus, version: str) -> None:
    def last(fmu: Path, values: Mapping[str, float]) -> float:
        parts = (
            Component("a", FmuFile(fmu), values),
            Component("b", FmuFile(c_fmu("spring"))),
        )
        connections = ("a.body.m.x -> b.end.x", "b.end.force_x -> a.body.m.force_x")
        found: list[float] = []
        system = System("s", parts, connections, Simulation(1.0, 0.01, "gauss_seidel"))
        run(system, observers=[lambda _, n: found.append(n.read("b.end.x"))])
        return found[-1]

    # 1 kg on 1 N/m, in metres and in millimetres; the stiffnesses are the same number in N
    metres = last(c_fmu(f"{version}mass"), {"body.m.x": 1.0})
    millimetres = last(c_fmu(f"{version}mm_mass"), {"mass": 1e-3, "body.m.x": 1000.0})
    assert metres == pytest.approx(np.cos(1.0), abs=1e-3)
    assert millimetres == pytest.approx(metres, rel=1e-9)


def test_fmi_1_takes_all_values_before_it_is_initialised(c_fmu: Fmus) -> None:
    # the FMU refuses values that are asked before, and parameters that are set after
    stages = tuple(Component(n, FmuFile(c_fmu("1:stage")), {"gain": 2.0}) for n in "abc")
    parts = (*stages, Component("d", FmuFile(c_fmu("stage")), {"u": 5.0}))
    chain = ("d.y -> c.u", "c.y -> b.u", "b.y -> a.u")
    found: list[float] = []

    def observe(_: float, network: Network) -> None:
        found.append(network.read("a.y"))

    run(System("s", parts, chain, Simulation(0.1, 0.1)), observers=[observe])
    assert found[0] == 40.0


@pytest.mark.parametrize("jacobian", ["", "+jacobian"])
def test_loops_are_solved_with_the_derivatives_of_fmi_3(c_fmu: Fmus, jacobian: str) -> None:
    parts = (
        Component("a", FmuFile(c_fmu("3:mass+state" + jacobian)), {"body.m.x": 1.0}),
        Component("b", FmuFile(c_fmu("3:added_mass+state" + jacobian)), {"added": 5.0}),
    )
    connections = (
        "a.body.m.x -> b.end.x",
        "a.body.m.ax -> b.end.ax",
        "b.end.force_x -> a.body.m.force_x",
    )
    found: list[float] = []

    def observe(_: float, network: Network) -> None:
        found.append(network.read("a.body.m.x"))

    system = System("s", parts, connections, Simulation(1.0, 0.01, "implicit"))
    outcome: Outcome = run(system, observers=[observe])
    assert outcome.steps == 100
    # second order: x'' (1 + 5) = -x; (H w)^2 t / 24 is below 1e-6
    assert found[-1] == pytest.approx(np.cos(1 / np.sqrt(6)), abs=1e-5)


@pytest.mark.parametrize("name", ["1:mass", "3:ball+events"])
def test_info_and_validate_take_them(
    c_fmu: Fmus, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    fmu = str(c_fmu(name))
    assert main(["info", fmu]) == 0
    assert main(["info", fmu, "--json"]) == 0
    told = capsys.readouterr().out
    assert json.loads(told[told.index("{\n") :])["fmiVersion"] == f"{name[0]}.0"
    if name[0] == "1":
        assert main(["validate", fmu, "--skip", "values"]) == 0
        assert "made for FMI 2.0 and 3.0, this is 1.0" in capsys.readouterr().out
