"""All problems of a system and of its files are told in one round, before anything is built."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.moordyn import MooringConfig
from m4e_fmi.cli import main
from m4e_fmi.cosim import prepare
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu, read_description
from m4e_fmi.fmu.export.expected import expected_description
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmus import hydrodynamics, mooring

SOUND_MODEL = """\
name: buoy
parameters: {m: {value: 143.2, unit: t}}
bodies: {float: {mass: m, inertia: 0.92e6, added_mass: true}}
joints: {sea: {type: floating, child: float}}
points: {bow: {body: float, at: [-4, 0]}, stern: {body: float, at: [4, 0]}}
"""
LINES = """\
    water: {depth: 50}
    line_types:
      chain: {diameter: 0.09, mass_per_length: 50, axial_stiffness: 2.0e+8,
              axial_damping_ratio: 1, drag_coefficient: 1.3, added_mass_coefficient: 1}
    anchors: {west: [-180, -50]}
    fairleads: [bow]
    lines: {l: {type: chain, from: west, to: bow, unstretched_length: 188, segments: 20}}
"""
WATER = """\
    bodies: {float: {shape: {cylinder: {radius: 4, draft: 3}}, center_of_gravity: [0, -1]}}
    waves: {spectrum: jonswap, significant_height: 2, peak_period: 7.5}
"""
SOUND = f"""\
name: sound
components:
  buoy: {{model: buoy.model.yaml}}
  hydro:
    kind: hydrodynamics
{WATER}  lines:
    kind: mooring
{LINES}connections:
  - buoy.float <-> hydro.float
  - hydro.added_mass -> buoy.added_mass
  - buoy.bow <-> lines.bow
simulation: {{stop_time: 1, step_size: 0.1}}
"""


def told(folder: Path, system: str, model: str = SOUND_MODEL) -> list[Problem]:
    (folder / "buoy.model.yaml").write_text(model)
    (folder / "s.system.yaml").write_text(system)
    lines: list[str] = []
    with pytest.raises(InputError) as caught:
        prepare(folder / "s.system.yaml", build_directory=folder / "build", tell=lines.append)
    assert not any("building" in line for line in lines)
    assert not (folder / "build").exists()
    return caught.value.problems


def test_mistakes_of_every_kind(tmp_path: Path) -> None:
    """In the system's file, in files that it names and that are not there, in a model, in numbers,
    and in connections."""
    system = SOUND.replace("step_size: 0.1", "step_size: 0.1, algoritm: jacobi")
    system = system.replace("depth: 50", "depth: 50, densty: 1000")
    system = system.replace("    anchors:", "    solver: {time_step: 0.1}\n    anchors:")
    system = system.replace("    waves:", "    frequencies: {maximum: 0.5}\n    waves:")
    mesh = "\n      barge: {shape: {mesh: meshes/a.gdf}, center_of_gravity: [50, 0]}"
    system = system.replace("bodies: {float:", "bodies:\n      float:").replace("-1]}}", "-1]}")
    system = system.replace("-1]}\n", f"-1]}}{mesh}\n")
    system = system.replace(
        "connections:", "  ready: {kind: mooring, file: redy.txt}\nconnections:"
    )
    system = system.replace(
        "buoy.bow <-> lines.bow", "buoy.bau <-> lines.bow\n  - buoy.y -> bouy.x"
    )
    (tmp_path / "ready.txt").touch()
    found = {problem.message: problem for problem in told(tmp_path, system)}
    expected = {
        "unknown key 'densty'": "'density'",
        "unknown key 'algoritm'": "'algorithm'",
        f"no such MoorDyn file: {tmp_path / 'redy.txt'}": "'ready.txt'",
        f"body 'barge': no such folder: {tmp_path / 'meshes'}": "a.gdf",
        "the waves need excitation up to 2.094 rad/s (2.5 peak frequencies), the coefficients end "
        "at 0.5 rad/s": "frequencies.maximum",
        "'buoy' has no connector 'bau'": "",
        "unknown component 'bouy'": "'buoy'",
    }
    unstable = next(message for message in found if "time step 0.1 s is unstable" in message)
    assert set(found) == {*expected, unstable}
    for message, remedy in expected.items():
        assert remedy in found[message].remedy
    lines = system.splitlines()
    for problem in found.values():
        assert problem.file.endswith("s.system.yaml")
        assert problem.column
        assert problem.source == lines[problem.line - 1]
    assert "time_step" in found[unstable].source
    assert "file: redy.txt" in found[f"no such MoorDyn file: {tmp_path / 'redy.txt'}"].source


def test_a_syntax_error_hides_its_own_file_only(tmp_path: Path) -> None:
    system = SOUND.replace("buoy.bow <-> lines.bow", "buoy.bow <-> lines.bau")
    found = told(tmp_path, system.replace("4, draft: 3", "4, draft: 300"), "name: buoy\nbodies: {")
    assert [Path(problem.file).name for problem in found] == ["buoy.model.yaml", "s.system.yaml"]
    assert "not valid YAML" in found[0].message
    assert "has no connector 'bau'" in found[1].message
    shallow = SOUND.replace("    bodies:", "    water: {depth: 2}\n    bodies:")
    found = told(tmp_path, shallow, SOUND_MODEL.replace("unit: t", "unit: tons"))
    assert [problem.line for problem in found] == [2, 7]


def test_a_sound_system_but_for_its_connections(tmp_path: Path) -> None:
    """They are checked against the variables that the FMUs are going to have."""
    system = SOUND.replace("hydro.added_mass ->", "hydro.wave.elevation ->")
    system = system.replace("buoy.float <-> hydro.float", "buoy.body.float.x -> hydro.float.theta")
    system = system.replace("model.yaml}", "model.yaml, start: {body.float.y: 1, m: 1 m}}")
    start = "hydro:\n    start: {wave.peak_period: 20, 'float.radiation_state[1]': 1}"
    messages = [problem.message for problem in told(tmp_path, system.replace("hydro:", start, 1))]
    assert messages == [
        "'buoy' has no variable 'body.float.y'",
        "start value '1 m' of buoy.m is wrong",
        "start value 20 of hydro.wave.peak_period is wrong",
        "buoy.body.float.x is in m, hydro.float.theta expects rad",
        "hydro.wave.elevation and buoy.added_mass differ in size",
    ]


def test_what_may_follow_from_a_problem_is_not_told(tmp_path: Path) -> None:
    """Lines of a type that is wrong, connections with what is wrong, a default in its place."""
    system = SOUND.replace("diameter: 0.09", "diameter: -1")
    system = system.replace(
        "    anchors:", "    solver: {scheme: RK5, time_step: 0.02}\n    anchors:"
    )
    system = system.replace("radius: 4", "radius: big").replace("lines.bow", "lines.keel")
    messages = [problem.message for problem in told(tmp_path, system)]
    assert len(messages) == 3
    assert "radius" in messages[0]
    assert "diameter" in messages[1]
    assert "RK5" in messages[2]


def test_expected_descriptions_are_those_of_the_fmus(tmp_path: Path) -> None:
    (tmp_path / "buoy.model.yaml").write_text(SOUND_MODEL)
    lines = Document.parse(LINES).validate(MooringConfig)
    for source in (
        model_program(load_model(tmp_path / "buoy.model.yaml")),
        mooring.make(lines, name="lines", folder=tmp_path, progress=lambda _: None),
        hydrodynamics.check(Document.parse(WATER).validate(HydrodynamicsConfig), folder=tmp_path),
    ):
        expected = expected_description(source, tmp_path / "a.fmu")
        built = read_description(build_fmu(source, tmp_path / "a.fmu"))
        assert expected.variables == built.variables
        assert expected.input_derivatives == built.input_derivatives


MODEL = """\
name: wrong
gravty: 9.81
parameters:
  m: {value: 2, unit: kgg}
  k: {value: -1, unit: N/m}
  L: {value: 1, unit: m}
bodies:
  a: {mass: m * 0, inertia: 1}
  b: {mass: L, inertia: -1}
  c: {mass: mm, inertia: 1}
joints:
  j: {type: revolute, child: a}
  k: {type: revolute, child: b, parent: a}
"""


def test_elements_tree_and_numbers_of_a_model_in_one_round(tmp_path: Path) -> None:
    """A key, a unit, a name; a body without a joint; a number; a dimension. Nothing is said of the
    mass that is made from the parameter whose unit is wrong."""
    (tmp_path / "a.model.yaml").write_text(MODEL)
    with pytest.raises(InputError) as caught:
        load_model(tmp_path / "a.model.yaml")
    problems = [(p.line, p.message.partition(";")[0]) for p in caught.value.problems]
    assert problems == [
        (2, "unknown key 'gravty'"),
        (4, "unit 'kgg': 'kgg' is not a unit known here"),
        (9, "mass: L is in m, expected kg"),
        (9, "must be positive, got -1"),
        (10, "body 'c' has no joint"),
        (10, "'mm' is not declared"),
    ]


def test_a_tree_is_not_judged_where_a_joint_is_wrong(tmp_path: Path) -> None:
    for old, new in (("child: b", "child: bb"), ("type: revolute, child: b", "type: revolut")):
        text = MODEL.replace(old, new)
        (tmp_path / "a.model.yaml").write_text(text)
        with pytest.raises(InputError) as caught:
            load_model(tmp_path / "a.model.yaml")
        assert "has no joint" not in str(caught.value)


def test_a_kind_may_fail_on_what_is_left_of_a_wrong_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its failure does not hide the problems that are known."""

    def fail(*_: object, **__: object) -> None:
        raise AttributeError("'NoneType' object has no attribute 'high'")

    monkeypatch.setattr(mooring, "make", fail)
    found = told(tmp_path, SOUND.replace("depth: 50", "depth: 50, densty: 1000"))
    assert [problem.message for problem in found] == ["unknown key 'densty'"]


@pytest.mark.parametrize("key", ["step_size: 0.1", "step_size: 0.1, output_interval: 0.1"])
def test_times_too_long_to_be_counted(key: str, tmp_path: Path) -> None:
    wrong = key.removesuffix("0.1") + "1.0e+300"
    (problem,) = told(tmp_path, SOUND.replace("step_size: 0.1", wrong))
    assert "1e+300 s" in problem.message
    assert problem.remedy


def test_true_is_no_number(tmp_path: Path) -> None:
    """Wherever a number stands: in a kind's keys, in lists, in a table of names."""
    system = SOUND.replace("depth: 50", "depth: true").replace("[-180, -50]", "[-180, true]")
    system = system.replace("draft: 3", "draft: true").replace("segments: 20", "segments: true")
    found = told(tmp_path, system)
    assert all(problem.message.endswith(" number, got true") for problem in found)
    assert len({(problem.line, problem.column) for problem in found}) == 4


@pytest.mark.parametrize("offers_check", [False, True])
def test_nothing_is_made_twice(
    offers_check: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By `info`, which asks first what takes long; and `check` is for kinds that take long."""
    calls = []
    make = mooring.make

    def counted(*given: Any, **named: Any) -> Any:
        calls.append("make")
        return make(*given, **named)

    monkeypatch.setattr(mooring, "make", counted)
    if offers_check:
        monkeypatch.setattr(mooring, "check", lambda *_, **__: calls.append("check"), raising=False)
    system = f"name: s\ncomponents:\n  lines:\n    kind: mooring\n{LINES}"
    system += "simulation: {stop_time: 1, step_size: 0.1}\n"
    (tmp_path / "s.yaml").write_text(system)
    monkeypatch.chdir(tmp_path)
    assert main(["info", "s.yaml", "--output-file", "s.svg"]) == 0
    assert calls == ["make"]


def test_references_and_settings_beside_other_mistakes_of_their_section(tmp_path: Path) -> None:
    """Lines to unknown types and points where types, anchors or lines are wrong; a simulation."""
    system = SOUND.replace("diameter: 0.09", "diameter: -1").replace("-180, -50", "-180, -60")
    lines = ("type: chian, from: east, to: baw", "type: chain, from: west, to: bow")
    for k, ends in enumerate(lines):
        line = f"      l{k}: {{{ends}, unstretched_length: 188, segments: 0}}\n"
        system = system.replace("connections:", f"{line}connections:")
    system = system.replace("lines: {l: {", "lines:\n      l: {").replace("20}}", "20}")
    system = system.replace(
        "stop_time: 1, step_size: 0.1", "stop_time: one, step_size: 0, algorithm: gauss"
    )
    system = system.replace("float <-> hydro.float", "float <-> hydro.float <-> buoy.bow")
    messages = [problem.message for problem in told(tmp_path, system)]
    for part in (
        "diameter",
        "below the seabed",
        "l0: there is no line type 'chian'",
        "l0: there is no anchor or fairlead 'east'",
        "l0: there is no fairlead 'baw'",
        "more than one arrow",
        "'one' is not a valid duration",
        "step_size 0 s",
        "unknown algorithm 'gauss'",
    ):
        assert [part in message for message in messages].count(True) == 1, (part, messages)
    assert len(messages) == 11  # and the segments of two lines


def test_one_of_two_that_exclude_each_other_is_to_be_dropped(tmp_path: Path) -> None:
    system = SOUND.replace("axial_damping_ratio: 1", "axial_damping_ratio: 1, axial_damping: 1")
    pto = "  p: {kind: linear_pto, point: a, anchor: [0, 0], damping: 1, rest_length: 1, "
    system = system.replace("connections:", f"{pto}point_at: [0, 1]}}\nconnections:")
    assert [p.remedy.split()[0] for p in told(tmp_path, system)] == ["drop", "drop"]


@pytest.mark.parametrize(
    ("old", "new", "remedy"),
    [
        ("depth: 50", "depth: 0.05 km", "write 50: numbers here are in SI units"),
        ("depth: 50", "depth: 45 deg", "write a number without unit: angles and frequencies"),
        ("depth: 50", "depth: 1e999 km", "the number is too large: write one below 1.8e308"),
        ("depth: 50", "depth: -50", "write a number above 0"),
        ("segments: 20", "segments: 2000", "write a number not above 1000"),
        ("[0, -1]", "[0]", "write [x, z]"),
        ("[0, -1]", "[0, -1,5]", "write [x, z]; numbers have a decimal point"),
        ("buoy.model.yaml", "buoy.model.yml", "did you mean 'buoy.model.yaml'?"),
        ("step_size: 0.1", "step_size: 50ms", "a blank before the unit"),
    ],
)
def test_remedies(old: str, new: str, remedy: str, tmp_path: Path) -> None:
    (problem,) = told(tmp_path, SOUND.replace(old, new))
    assert problem.remedy.startswith(remedy) or remedy in problem.remedy


@pytest.mark.parametrize(
    ("value", "unit", "remedy"),
    [
        ("143200 kg", "t", "write 143.2: the number is in t, as 'unit' beside it says"),
        ("1 g", "m/s2", "write 9.80665: the number is in m/s2"),
        ("1 g", "t", "write 1e-06: the number is in t"),
        ("1 N", "t", "write a number without unit: the number is in t"),
    ],
)
def test_numbers_are_in_the_unit_beside_them(
    value: str, unit: str, remedy: str, tmp_path: Path
) -> None:
    model = SOUND_MODEL.replace("value: 143.2, unit: t", f"value: {value}, unit: {unit}")
    assert told(tmp_path, SOUND, model)[0].remedy.startswith(remedy)


def test_a_misspelt_neutral_mass(tmp_path: Path) -> None:
    problems = told(tmp_path, SOUND, SOUND_MODEL.replace("mass: m", "mass: neutrall"))
    assert "did you mean 'neutral'" in problems[0].remedy
