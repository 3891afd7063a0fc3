"""What FMUs of FMI 1.0 and 3.0 say, take and answer."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from support.python_executor import use_python
from support.small_systems import Fmus, observed, system, watched

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Simulation,
    System,
    prepare,
    run,
    start,
)
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import read_description

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


ABILITY = 'canHandleVariableCommunicationStepSize="true"'


@pytest.mark.parametrize("other", [ABILITY.replace("true", "false"), ""])
def test_an_fmu_of_fmi_1_that_makes_steps_of_one_size_only(
    c_fmu: Fmus, tmp_path: Path, other: str
) -> None:
    """Where it is not declared, FMI 1.0 takes it for false."""
    assert not read_description(c_fmu("1:mass")).constant_step
    fmu = reworded(c_fmu("1:mass"), tmp_path / "x.fmu", ABILITY, other)
    assert read_description(fmu).constant_step


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


@pytest.mark.parametrize(
    ("fmu", "old", "new", "match"),
    [
        ("1:mass", "CoSimulation_StandAlone>", "CoSimulation_Tool>", r"CoSimulation_Tool.*start"),
        (
            "3:mass",
            "</ModelVariables>",
            '<Clock name="tick" valueReference="77" causality="input" '
            'intervalVariability="fixed"/></ModelVariables>',
            "needs a master with clocks: 'tick'",
        ),
        ("3:gallery", 'Dimension start="2"', 'Dimension start="2000000"', "elements together"),
    ],
)
def test_what_cannot_be_run_is_refused(
    c_fmu: Fmus, tmp_path: Path, fmu: str, old: str, new: str, match: str
) -> None:
    with pytest.raises(InputError, match=match):
        read_description(reworded(c_fmu(fmu), tmp_path / "x.fmu", old, new))


def test_start_values_of_all_types(c_fmu: Fmus) -> None:
    numbers = {
        "int8": -5, "uint8": 200, "int16": -300, "uint16": 40000, "int32": -70000,
        "uint32": 3_000_000_000, "int64": -(2**40), "uint64": 2**41, "boolean": True,
    }  # fmt: skip
    others: dict[str, int | str] = {"word": "four", "mode": "fast"}
    with start(alone(c_fmu("3:gallery"), {**numbers, **others})) as stepped:
        # the length of the word, the number of the item
        assert stepped["a.sum"] == sum(numbers.values()) + 4 + 2


def test_a_binary_is_not_set(c_fmu: Fmus) -> None:
    with pytest.raises(InputError, match="values of type Binary are not set"):
        prepare(alone(c_fmu("3:gallery"), {"bytes": "0a10"}))


def test_some_elements_of_an_array_are_set(c_fmu: Fmus) -> None:
    values = {"u[2]": 7.0, "gain": 2.0, "u32[1]": 0.1}
    with start(alone(c_fmu("3:gallery"), values)) as stepped:
        assert [stepped[f"a.y[{k}]"] for k in (1, 2, 3)] == [1.0, 14.0, 1.0]
        assert stepped["a.y32[1]"] == float(np.float32(2) * np.float32(0.1))
        stepped["a.u[3]"] = -1.0
        assert [stepped[f"a.y[{k}]"] for k in (1, 2, 3)] == [1.0, 14.0, -2.0]


def test_a_structural_parameter_gives_arrays_their_size(c_fmu: Fmus) -> None:
    with start(alone(c_fmu("3:gallery"), {"size": 5, "u[5]": 3.0})) as stepped:
        assert [stepped[f"a.y[{k}]"] for k in range(1, 6)] == [0.5, 0.5, 0.5, 0.5, 3.0]


@pytest.mark.parametrize("by_python", [False, True])
def test_single_elements_and_single_precision_are_connected(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, by_python: bool
) -> None:
    if by_python:
        use_python(monkeypatch)
    stage = Component("stage", FmuFile(c_fmu("stage")), {"gain": 0.0})  # y is the time
    gallery = Component("g", FmuFile(c_fmu("3:gallery")), {"gain": 3.0, "u[1]": 9.0})
    connections = tuple(
        f"{a}, units ignored" for a in ("stage.y -> g.u[2]", "stage.y * 2 -> g.u32[2]")
    )
    system = System("s", (stage, gallery), connections, Simulation(0.5, 0.25, "jacobi"))
    found = observed(system, "g.y[1]", "g.y[2]", "g.y[3]", "g.y32[2]")[0]
    assert found == [[t, 27.0, 3 * t, 1.5, 6 * t] for t in (0.0, 0.25, 0.5)]


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
    """1 kg on 1 N/m, in metres and in millimetres; the stiffnesses are the same number in N."""

    def last(body: str, **start: float) -> float:
        links = ("a.body.m.x -> b.end.x", "b.end.force_x -> a.body.m.force_x")
        names = {"a": f"{version}{body}", "b": "spring"}
        settings = Simulation(1.0, 0.01, "gauss_seidel")
        given = system(c_fmu, names, *links, start={"a": start}, simulation=settings)
        return watched(given, "b.end.x")[-1][0]

    metres = last("mass", **{"body.m.x": 1.0})
    millimetres = last("mm_mass", **{"mass": 1e-3, "body.m.x": 1000.0})
    assert metres == pytest.approx(np.cos(1.0), abs=1e-3)
    assert millimetres == pytest.approx(metres, rel=1e-9)


def test_fmi_1_takes_all_values_before_it_is_initialised(c_fmu: Fmus) -> None:
    """The FMU refuses values that are asked before, and parameters that are set after."""
    names = {**dict.fromkeys("abc", "1:stage"), "d": "stage"}
    chain = ("d.y -> c.u", "c.y -> b.u", "b.y -> a.u")
    start = {**{name: {"gain": 2.0} for name in "abc"}, "d": {"u": 5.0}}
    assert watched(system(c_fmu, names, *chain, start=start), "a.y")[0] == [40.0]
