"""Reading `system.yaml`: all that is wrong with it is told at once, in place."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from types import ModuleType

import pytest

from m4e_fmi.cosim import FmuFile, Kind, Simulation, load_system, system_file
from m4e_fmi.cosim.system import component as component_module
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Section
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program, Recorder, Variable

GOOD = """\
name: pair
description: a mass on a spring
components:
  body: {fmu: mass.fmu, start: {body.m.x: 1.0}}
  spring: {kind: coil, stiffness: 4.0, start: {damping: 0.5}}
connections:
  - body.m <-> spring.end
simulation: {stop_time: 10, step_size: 0.1, output_interval: 0.5}
"""


class CoilConfig(Section):
    stiffness: float


def mass() -> Program:
    r = Recorder("mass", "a mass of 1 kg")
    force = r.input(Variable("body.m.force_x", "N", "force"))
    r.state(Variable("body.m.x", "m", "position"))
    v = r.state(Variable("body.m.vx", "m/s", "velocity", derivative_of="body.m.x"))
    r.rate("body.m.x", v)
    r.rate("body.m.vx", force)
    return r.program()


def coil(config: CoilConfig, *, name: str, **_: object) -> Program:
    r = Recorder(name, "a spring")
    x = r.input(Variable("end.x", "m", "position"))
    v = r.input(Variable("end.vx", "m/s", "velocity"))
    damping = r.parameter(Variable("damping", "N.s/m", "damping"))
    r.output(Variable("end.force_x", "N", "force"), -config.stiffness * x - damping * v)
    return r.program()


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_fmu(mass(), tmp_path_factory.mktemp("fmu") / "mass.fmu")


@pytest.fixture
def folder(tmp_path: Path, fmu: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file mass.fmu, and a kind 'coil' that takes a stiffness."""
    shutil.copy(fmu, tmp_path)
    module = ModuleType("coil_kind")
    module.__dict__.update(Config=CoilConfig, make=coil)
    monkeypatch.setitem(sys.modules, "coil_kind", module)

    class Point:
        value = "coil_kind"

    for place in (component_module, system_file):
        monkeypatch.setattr(place, "kinds", lambda: {"coil": Point()})
    return tmp_path


def written(folder: Path, text: str) -> Path:
    path = folder / "system.yaml"
    path.write_text(text)
    return path


def test_a_word_is_no_number(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(
        "name: s\ncomponents: {a: {fmu: a.fmu, step_size: true}}\nconnections: []\n"
        "simulation: {stop_time: true, step_size: 0.1}\n"
    )
    with pytest.raises(InputError) as caught:
        load_system(path)
    told = [str(problem) for problem in caught.value.problems]
    assert any("expected a number, got true" in text for text in told)


def test_a_good_file_is_understood(folder: Path) -> None:
    read = load_system(written(folder, GOOD))
    assert read.name == "pair"
    body, spring = read.components
    assert body.source == FmuFile(folder / "mass.fmu")
    assert dict(body.start) == {"body.m.x": 1.0}
    assert spring.source == Kind("coil", CoilConfig(stiffness=4.0))
    assert dict(spring.start) == {"damping": 0.5}
    assert read.connections == ("body.m <-> spring.end",)
    assert read.simulation == Simulation(10, 0.1, output_interval=0.5)
    assert read.folder == folder


@pytest.mark.parametrize(
    ("old", "new", "place", "message", "remedy"),
    [
        ("fmu: mass.fmu", "fmu: mas.fmu", "4:10", "no such file", "did you mean 'mass.fmu'?"),
        ("fmu: mass.fmu", "fmu: mass.fmu, model: m.yaml", "4:3", "model and fmu", "give one"),
        ("fmu: mass.fmu, ", "", "4:3", "none of 'model', 'kind' and 'fmu'", "give one"),
        ("  body:", "  2nd:", "4:3", "component name '2nd'", "letters"),
        ("kind: coil", "kind: coli", "5:12", "unknown kind 'coli'", "did you mean 'coil'?"),
        (
            "kind: coil",
            "kind: pump",
            "5:12",
            "no installed package brings it (docs/adapters.md)",
            "known kinds: coil",
        ),
        ("stiffness: 4.0", "stiffness: 4, stif: 1", "5:38", "unknown key 'stif'", "'stiffness'?"),
        ("stiffness: 4.0", "stiffness: soft", "5:35", "expected a number", ""),
        ("start: {damping: 0.5}", "start: 3", "5:47", "start", ""),
        ("stop_time: 10", "stop_time: -1", "8:14", "not after the start", "start_time is 0 s"),
        ("step_size: 0.1", "step_size: 0", "8:29", "expected 1e-9 s or more", ""),
        ("step_size: 0.1", "step_size: 20", "8:29", "longer than the run", ""),
        ("output_interval: 0.5", "output_interval: 0.25", "8:45", "not a multiple", "take 0.2 s"),
        (
            "step_size: 0.1, output_interval: 0.5",
            "step_size: 7812.5 ns, output_interval: 1 ms",
            "8:51",
            "steps are whole nanoseconds, so that the step_size of 7.8125e-06 s is one of 7812 ns",
            "take a step_size of 8e-06 s",
        ),
        ("step_size: 0.1", "step_size: 1 mm", "8:29", "'1 mm' is not a valid duration", "'10 ms'"),
        ("stop_time: 10", "stop_time: late", "8:14", "'late' is not a valid duration", "'10 ms'"),
        ("output_interval: 0.5", "algorithm: jakobi", "8:45", "'jakobi'", "did you mean 'jacobi'?"),
        ("output_interval: 0.5", "tolerance: 2", "8:45", "tolerance", "1e-6"),
        ("stop_time: 10, ", "", "8:1", "missing key 'stop_time'", "add"),
    ],
)
def test_one_mistake_one_message_at_its_place(
    folder: Path, old: str, new: str, place: str, message: str, remedy: str
) -> None:
    assert old in GOOD
    with pytest.raises(InputError) as caught:
        load_system(written(folder, GOOD.replace(old, new)))
    first = caught.value.problems[0]
    assert f"system.yaml:{place}: " in str(first)
    assert message in first.message
    assert remedy in first.remedy


def test_times_may_have_units(folder: Path) -> None:
    times = "start_time: -500 ms, stop_time: 1/6 min, step_size: 100 ms, output_interval: 0.5 s"
    text = GOOD.replace("stop_time: 10, step_size: 0.1, output_interval: 0.5", times)
    settings = load_system(written(folder, text)).simulation
    assert settings == Simulation(10.0, 0.1, output_interval=0.5, start_time=-0.5)


def test_all_problems_are_told_at_once(folder: Path) -> None:
    text = GOOD.replace("mass.fmu", "mas.fmu").replace("stiffness: 4.0", "stif: 1")
    text = text.replace("step_size: 0.1", "step_size: 0").replace("connections:", "conections:")
    with pytest.raises(InputError) as caught:
        load_system(written(folder, text))
    messages = [problem.message for problem in caught.value.problems]
    assert any("no such file" in m for m in messages)
    assert any("unknown key 'stif'" in m for m in messages)
    assert any("unknown key 'conections'" in m for m in messages)


def test_a_wrong_start_value_is_one_problem(folder: Path) -> None:
    """Though it may be of four types, of which it is none."""
    with pytest.raises(InputError) as caught:
        load_system(written(folder, GOOD.replace("body.m.x: 1.0", "body.m.x: [1, 2]")))
    (problem,) = caught.value.problems
    expected = "expected true or false, a whole number, a number or text, got a list"
    assert problem.message == f"start.body.m.x: {expected}"


def test_parts_that_do_not_depend_on_one_another_are_told_together(folder: Path) -> None:
    """Wrong keys, a wrong kind, connections that are none, and settings that do not fit."""
    text = GOOD.replace("kind: coil", "kind: coli").replace("body.m <-> spring.end", "body => a.b")
    text = text.replace("stop_time: 10", "stop_tme: 3, stop_time: 10, tolerance: 5")
    text = text.replace("=> a.b", "=> a.b\n  - boddy.m <-> spring.end")
    with pytest.raises(InputError) as caught:
        load_system(written(folder, text))
    messages = [problem.message for problem in caught.value.problems]
    for message in (
        "unknown kind 'coli'",
        "not a connection: 'body => a.b'",
        "unknown component 'boddy'",
        "unknown key 'stop_tme'",
        "tolerance 5: expected",
    ):
        assert any(message in one for one in messages), messages
    assert len(messages) == 5


def test_settings_given_in_python_are_checked_too() -> None:
    with pytest.raises(InputError, match="stop_time"):
        Simulation(stop_time=0, step_size=0.1)
    with pytest.raises(InputError, match="did you mean 'gauss_seidel'"):
        Simulation(stop_time=1, step_size=0.1, algorithm="gauss_sidel")
