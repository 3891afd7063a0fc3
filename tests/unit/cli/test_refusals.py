"""Wrong input and usage of the command line: one readable text, exit code 2."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.command_line import BUOY, FLEXIBLE, PENDULUM, copied, refused

from m4e_fmi.cli import main
from m4e_fmi.fmu import read_description

# a cube of five sides, WAMIT's gdf format: its bottom is missing
OPEN_MESH = """open cube
1.0 9.81
0 0
4
 1 -1 -1   1 1 -1    1 1 0    1 -1 0
 1 1 -1   -1 1 -1   -1 1 0    1 1 0
-1 1 -1   -1 -1 -1  -1 -1 0  -1 1 0
-1 -1 -1   1 -1 -1   1 -1 0  -1 -1 0
"""


def test_wrong_key(here, capsys):
    path = copied(here, PENDULUM, ("gravity:", "gravty:"))
    text = refused(capsys, "equations", path)
    assert re.search(r"double_pendulum\.model\.yaml:\d+:1: unknown key 'gravty'", text)
    assert "did you mean 'gravity'?" in text


def test_unknown_body(here, capsys):
    path = copied(here, PENDULUM, ("parent: upper", "parent: uper"))
    text = refused(capsys, "simulate", path)
    assert "unknown body 'uper'" in text
    assert "did you mean 'upper'?" in text


def test_all_problems_at_once(here, capsys):
    path = copied(
        here,
        PENDULUM,
        ("gravity:", "gravty:"),
        ("parent: upper", "parent: uper"),
        ("stiffness: k", "stiffness: kk"),
    )
    assert "3 problems" in refused(capsys, "build", path)


def test_unit_that_does_not_match(here, capsys):
    copied(here, FLEXIBLE / "mass.model.yaml")
    path = copied(
        here,
        FLEXIBLE / "system.yaml",
        ("- body.end <-> line.end", "- line.end.force_x -> body.body.mass.moment_y"),
    )
    text = refused(capsys, "run", path)
    assert re.search(r"system\.yaml:\d+:\d+:", text)
    assert "N.m" in text
    assert "line.end.force_x" in text


@pytest.mark.parametrize(
    "command", ["equations", "simulate", "linearize", "build", "info", "run", "validate"]
)
@pytest.mark.usefixtures("here")
def test_missing_file(capsys, command):
    assert "no such file" in refused(capsys, command, "nothing.yaml")


def test_missing_model_of_a_system(here, capsys):
    path = copied(here, FLEXIBLE / "system.yaml")
    text = refused(capsys, "run", path)
    assert "mass.model.yaml" in text
    assert "no such file" in text


def test_mesh_that_is_not_watertight(here, capsys):
    (here / "hull.gdf").write_text(OPEN_MESH, encoding="ascii")
    copied(here, BUOY.parent / "buoy.model.yaml")
    shape = "{cylinder: {radius: 4, draft: 3}}"
    path = copied(here, BUOY, (shape, "{mesh: hull.gdf}"))
    text = refused(capsys, "build", path)
    assert "hull.gdf" in text
    assert "watertight" in text


@pytest.fixture
def other_files(here: Path) -> Path:
    """Files of other kinds; what they hold does not matter, no command gets as far as that."""
    for name in ("x.fmu", "x.ssp", "x.nc"):
        (here / name).write_bytes(b"\x89 no text")
    copied(here, PENDULUM)
    copied(here, FLEXIBLE / "system.yaml")
    return here


TAKES_MODELS = ("draw", "simulate", "equations", "linearize", "equilibrium")


@pytest.mark.usefixtures("other_files")
@pytest.mark.parametrize(
    ("command", "file", "told", "remedy"),
    [
        ("draw", "system.yaml", "a system, not a model", "`m4e-fmi run` runs"),
        ("run", PENDULUM.name, "a model, not a system", "`m4e-fmi simulate` simulates"),
        ("validate", PENDULUM.name, "a model, not an FMU", "`m4e-fmi build` builds its FMU, which"),
        ("validate", "system.yaml", "a system, not an FMU", "`m4e-fmi build` builds its FMUs"),
        ("validate", "x.ssp", "a package of a system, not an FMU", "`m4e-fmi info` shows"),
        ("validate", "x.nc", "a file of results, not an FMU", "m4e_fmi.load"),
        *(
            (c, "x.fmu", "an FMU, not a YAML file", "`m4e-fmi validate` checks")
            for c in (*TAKES_MODELS, "build", "run")
        ),
        ("draw", "x.ssp", "a package of a system, not a", "`m4e-fmi run` runs"),
        *(
            (c, "x.nc", "a file of results, not a YAML file", "m4e_fmi.load")
            for c in (*TAKES_MODELS, "build", "run", "info")
        ),
    ],
)
def test_a_file_of_another_kind_is_one_error_that_names_the_command(
    capsys, command, file, told, remedy
):
    first, *others = refused(capsys, command, file).splitlines()
    assert first.startswith(f"error: {file}: this is {told}")
    assert len(others) == 1
    assert remedy in others[0]


def test_files_that_are_no_text(here, capsys):
    (here / "p.png").write_bytes(b"\x89PNG")
    assert "p.png: is no YAML file by its name" in refused(capsys, "info", "p.png")
    (here / "p.yaml").write_bytes(b"\x89PNG")
    assert "p.yaml: cannot be read: byte 1 is not valid UTF-8" in refused(capsys, "info", "p.yaml")


def test_a_model_as_a_component_that_is_a_system(here, capsys):
    copied(here, FLEXIBLE / "system.yaml", ("mass.model.yaml", "system.yaml"))
    assert "this is a system, not a model" in refused(capsys, "build", "system.yaml")


def test_corrupt_fmu(here, capsys):
    (here / "broken.fmu").write_bytes(b"PK\x03\x04 and no more")
    (here / "system.yaml").write_text(
        "name: s\ncomponents:\n  a: {fmu: broken.fmu}\n"
        "simulation: {stop_time: 1, step_size: 0.1}\n",
        encoding="utf-8",
    )
    text = refused(capsys, "run", "system.yaml")
    assert "broken.fmu" in text
    assert "not a readable ZIP archive" in text
    assert "broken.fmu" in refused(capsys, "info", "broken.fmu")
    assert "broken.fmu" in refused(capsys, "validate", "broken.fmu")


@pytest.mark.parametrize("command", [("simulate", PENDULUM), ("run", FLEXIBLE / "system.yaml")])
@pytest.mark.parametrize("name", ["keep.png", "r.xlsx", "r.json", "r.txt", "r.cvs", "r"])
def test_results_in_a_form_that_there_is_not(here, capsys, command, name):
    """Nothing runs, nothing is written: a file of that name stays as it is."""
    (here / name).write_text("mine")
    text = refused(capsys, *command, "--output-file", name)
    assert f"error: {name}: results cannot be written as" in text
    assert "use .nc, .csv or .parquet" in text
    assert [path.name for path in here.iterdir()] == [name]
    assert (here / name).read_text() == "mine"


@pytest.mark.parametrize(
    "command", [("draw", PENDULUM), ("info", FLEXIBLE / "system.yaml")], ids=["draw", "info"]
)
def test_picture_in_a_form_that_there_is_not(here, capsys, command):
    text = refused(capsys, *command, "--output-file", "d.bmp")
    assert text == (
        "error: d.bmp: a picture cannot be written as '.bmp'\n      use .png, .svg or .pdf\n"
    )
    assert not list(here.iterdir())


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(("option", "value"), [("--stop-time", "-1"), ("--stop-time", "nan")])
def test_wrong_times_are_told_without_a_bar_of_progress(capsys, option, value):
    text = refused(capsys, "simulate", PENDULUM, option, value)
    remedy = "give a number of seconds above 0"
    assert text == f"error: the stop time must be positive, got {float(value)}\n      {remedy}\n"


@pytest.mark.usefixtures("here")
def test_start_value_that_is_no_number(capsys):
    heavy = ("--start-value", "m", "heavy")
    text = refused(capsys, "simulate", PENDULUM, *heavy, "--start-value", "L", "3 kg")
    assert "start value 'heavy' of m is wrong\n      'heavy' is not a number" in text
    assert "start value '3 kg' of L is wrong\n      it is in m: kg is not m" in text
    text = refused(capsys, "linearize", PENDULUM, "--start-value", "L", "250cm")
    assert "a unit may follow after a space, as in '5 mm'" in text


def test_start_value_given_twice(capsys):
    twice = ("--start-value", "m", "1", "--start-value", "m", "2")
    text = refused(capsys, "simulate", PENDULUM, *twice)
    assert "--start-value m is given 2 times" in text


def test_unknown_start_value(capsys):
    text = refused(capsys, "simulate", PENDULUM, "--start-value", "mm", "1")
    assert "has no parameter, input or state 'mm'" in text
    text = refused(
        capsys, "simulate", PENDULUM, "--start-value", "mm", "1", "--start-value", "x", 1
    )
    assert "2 problems" in text


@pytest.mark.usefixtures("here")
def test_simulated_variables_are_checked_before_the_work(capsys, monkeypatch):
    """A misspelt name is told before the simulation, which takes long, and no file is written."""
    monkeypatch.setattr("m4e_fmi.simulate.simulation._solver", lambda *_: (None, None))
    text = refused(capsys, "simulate", PENDULUM, "--variables", "joint.elbow.qq", "foo")
    assert "there is no variable 'joint.elbow.qq'\n      did you mean 'joint.elbow.q'?" in text
    assert "2 problems" in text
    assert not [path for path in Path().rglob("*") if path.is_file()]


def test_build_with_options(here):
    options = ["--native", "--no-documentation", "--inputs", "point.*", "--outputs", "body.upper.*"]
    options += ["--inputs", "*.elbow.effort", "--outputs", "energy.*"]
    options += ["--rename", "m=mass", "--rename", "body.upper.*=boom.*", "--stop-time", "3"]
    assert main(["build", str(PENDULUM), *options]) == 0
    description = read_description(here / "build" / "double_pendulum.fmu")
    inputs = {v.name for v in description.of_causality("input")}
    outputs = {v.name for v in description.of_causality("output")}
    assert inputs == {"point.tip.force_x", "point.tip.force_z", "joint.elbow.effort"}
    assert {name.split(".")[0] for name in outputs} == {"boom", "energy"}
    assert "mass" in description.variables


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--inputs", "points.*"], "no input matches 'points.*'"),
        (["--outputs", "energy.totl"], "did you mean 'energy.total'?"),
        (["--rename", "m"], "expected OLD=NEW"),
        (["--rename", "m=J"], "two variables would be called 'J'"),
        (["--rename", "m=m2", "--rename", "m=m3"], "--rename gives 'm' two names: 'm2', 'm3'"),
        (["--rename", "m=time"], "'time' is a reserved name"),
        (["--method", "euler"], "there is no method 'euler'"),
        (["--step-size", "0"], "the step size must be positive"),
        (["--step-size", "20"], "the step size 20 s is longer than the default experiment"),
        (["--step-size", "0.1", "--stop-time", "0.001"], "it stops at 0.001 s"),
    ],
)
def test_build_with_options_that_are_wrong(here, capsys, options, message):
    assert message in refused(capsys, "build", PENDULUM, *options)
    assert not (here / "build").exists()


def test_options_of_a_model_with_a_system(capsys):
    text = refused(capsys, "build", BUOY, "--no-documentation")
    assert "--no-documentation is for the FMU of a model" in text


@pytest.mark.parametrize("value", ["-1e7", "-.5", "-1E-3", "-2e+3", "-5 t", "-inf"])
def test_negative_numbers_are_values_and_no_options(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, value: str
) -> None:
    """Those with an exponent, too; every one of them is refused by what it is, as a mass."""
    text = refused(capsys, "simulate", PENDULUM, "--start-value", "m", value)
    assert "m = -" in text
    assert "expected 2 arguments" not in text
    for option in ("--stop-time", "--tolerance"):
        assert "must be positive" in refused(capsys, "simulate", PENDULUM, option, "-1e-7")
    system = tmp_path / "none.yaml"
    assert "no such file" in refused(capsys, "run", system, "--step-size", "-1e-7")
    assert main(["linearize", str(PENDULUM), "--at", "start", "--time", "-1e-7"]) == 0


def test_mistakes_in_options_are_told_together(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["run", "s.yaml", "--stop-tiem", "3", "--step-size", "5 cm", "--stop-time", "x"])
    assert ended.value.code == 2
    text = capsys.readouterr().err
    for part in ("--stop-tiem: did you mean '--stop-time'?", "'5 cm' is not", "'x' is not"):
        assert part in text
    for words, part in (
        (["rnu", "s.yaml"], "did you mean 'run'?"),
        (["run", "s.yaml", "--start-value", "a=3"], "as in --start-value mass 3"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 2
        assert part in capsys.readouterr().err


def test_mistakes_of_a_run_are_told_before_anything_is_built(here, capsys):
    """In the system, and in the options' names of components, variables and files."""
    options = ["--output-file", "x.txt", "--variables", "bdy.*", "--algorithm", "gauss"]
    options += ["--start-value", "bdy.M", "1", "--start-value", "body.N", "1"]
    text = refused(capsys, "run", FLEXIBLE / "system.yaml", *options)
    for part in (
        "x.txt",
        "--variables bdy.*: no component 'bdy'",
        "unknown algorithm 'gauss'",
        "start value 'bdy.M': there is no component 'bdy'",
        "'body' has no variable 'N'",
        "5 problems",
    ):
        assert part in text
    assert not (here / "build").exists()
    (here / "s.yaml").write_text("name: s\ncomponents: {}\n")
    text = refused(capsys, "run", "s.yaml", "--output-file", "x.txt")
    assert "x.txt" in text
    assert "simulation" in text
    assert "s.yaml:2:1: the system has no component" in text
    whole = "name: s\ncomponents: {}\nsimulation: {stop_time: 1, step_size: 0.1}\n"
    (here / "s.yaml").write_text(whole)
    for command in ("run", "info"):
        assert "s.yaml:2:1: the system has no component" in refused(capsys, command, "s.yaml")


def test_a_checkpoint_that_is_not_there_is_told_before_anything_is_built(here, capsys):
    text = refused(capsys, "run", FLEXIBLE / "system.yaml", "--resume", "no.nc.checkpoint")
    assert "no.nc.checkpoint" in text
    assert "no such file" in text
    assert not list(here.rglob("*.fmu"))


def test_a_search_for_an_equilibrium_names_the_other_one(here, capsys):
    (here / "a.model.yaml").write_text(
        "name: a\nbodies: {b: {mass: 1, inertia: 1}}\n"
        "joints: {j: {type: prismatic, child: b, direction: [0, 1]}}\n"
    )
    for options, named in (([], True), (["--at", "nearest"], False)):
        assert main(["linearize", "a.model.yaml", *options]) == 1
        assert ("--at nearest" in capsys.readouterr().err) == named


def test_a_python_file_is_a_component_of_a_system(here, capsys):
    (here / "control.py").write_text("", encoding="utf-8")
    told = refused(capsys, "build", "control.py")
    assert "this is Python code, not a YAML file" in told
    assert "{kind: python, file: NAME}" in told
