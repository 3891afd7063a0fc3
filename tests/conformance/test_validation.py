"""The checks find each fault planted into an FMU without any, and nothing in the FMUs we build.

`tests/fuzz/validate_all.py` validates the FMUs of all examples, in both kinds.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from support import defects
from support.c_fmus.build import build, trouble_file
from support.chains import hanging_chain
from support.defects import DEFECTS, planted
from support.faults.build import build_faulty

from m4e_fmi.cli import main
from m4e_fmi.fmu import Report, build_fmu, validate_fmu
from m4e_fmi.fmu.validation import GROUPS
from m4e_fmi.fmu.validation import run as validation_run
from m4e_fmi.fmu.validation.run import MODULES, PACKAGE
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program

HANGS = 2.0  # s after which a call is said to hang; the FMU's own calls take milliseconds
GROUP_OF = {
    **dict.fromkeys(("library", "variables"), "description"),
    "capabilities": "start",
}
"""First part of a finding's id → the group that finds it, where that is another word."""
EXAMPLES = Path(__file__).parents[2] / "examples"


def troubles(report: Report) -> set[str]:
    return {finding.id for finding in report.of_severity("error", "warning")}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return defects.build(tmp_path_factory.mktemp("sound"))


def test_nothing_is_found_where_nothing_is_wrong(sound: Path):
    report = validate_fmu(sound)
    assert troubles(report) == set()
    assert [group.name for group in report.groups] == list(GROUPS)
    assert all(group.passed for group in report.groups)


def test_a_step_that_was_assumed_is_no_error_of_the_fmu(c_fmu: Callable[[str], Path]) -> None:
    """It makes steps of 0.02 s only, and does not say so."""
    report = validate_fmu(c_fmu("lag+fiftieth+constant"))
    (found,) = [f for f in report.findings if f.id.startswith("start.")]
    assert (found.id, found.severity) == ("start.step_unknown", "warning")
    assert "h=0.01) answered Error, but that step of 0.01 s was assumed" in found.message
    assert "stepSize in DefaultExperiment" in found.basis
    assert any("I make steps of 0.02" in words for words in found.words)
    variable = validate_fmu(c_fmu("lag+fiftieth"), only=("start",))
    assert {f.id for f in variable.of_severity("error")} == {"start.refused"}


@pytest.mark.parametrize("name", DEFECTS)
def test_a_planted_fault_is_found(name: str, tmp_path: Path):
    """By its group: the others would take most of the time."""
    defect = DEFECTS[name]
    path = defects.build(tmp_path, defect)
    only = {GROUP_OF.get(group := one.partition(".")[0], group) for one in defect.expected}
    only = {"description"} if defect.text_only else only or {"dependencies"}
    report = validate_fmu(path, only=only, call_limit=HANGS)
    assert troubles(report) == defect.expected
    assert report.ok == ("error" not in {f.severity for f in report.findings})


@pytest.mark.parametrize(
    ("call", "named"),
    [
        ("instantiate", "instantiation"),
        ("initialise", "fmi2ExitInitializationMode"),
        ("step", "fmi2DoStep"),
        ("free", "fmi2FreeInstance"),
    ],
)
@pytest.mark.parametrize("fault", ["exit", "_exit"])
def test_an_fmu_that_ends_its_process_is_no_good_one(
    tmp_path: Path, call: str, named: str, fault: str
) -> None:
    """With exit code 0, as if all had been checked."""
    path = build("mass+state+armed", tmp_path)
    trouble_file(path).write_text(f"{call} {fault} 0")
    report = validate_fmu(path, only=("start",))
    assert not report.ok
    (found,) = report.of_severity("error")
    assert found.id == "start.ended"
    assert f"the process ended with code 0 after {named}" in found.message


def test_a_number_that_is_no_status_is_an_error(tmp_path: Path) -> None:
    path = build_faulty(2, "mass+state", tmp_path)
    for function in ("step", "get", "set", "exit"):
        (tmp_path / "plan").write_text(f"validation {function} negative 0 1\n")
        with pytest.MonkeyPatch.context() as patched:
            patched.setenv("M4E_TEST_FAULTS", str(tmp_path))
            report = validate_fmu(path, only=("start",))
        (found,) = report.of_severity("error")
        assert "answered no status of FMI" in found.message


def test_units_without_definitions_are_told(sound: Path, tmp_path: Path):
    """Where variables have display units, too, FMPy's validator stops with a KeyError."""
    units = defects.description().partition("<UnitDefinitions>")[2]
    units = "<UnitDefinitions>" + units.partition("</UnitDefinitions>")[0] + "</UnitDefinitions>"
    path = planted(sound, tmp_path / "no_units.fmu", units.encode(), b"")
    path = planted(path, tmp_path / "faulty.fmu", b'unit="kg"', b'unit="kg" displayUnit="t"')
    report = validate_fmu(path, only=("description",))
    told = [error.message for error in report.of_severity("error")]
    assert told[0] == "the unit kg is not defined (line 2)"
    assert len(told) == 10  # units in all


def test_the_unit_of_a_type_is_that_of_its_variables(tmp_path: Path):
    """An alias of x whose unit is that of its type, and der(v), whose unit is, too."""
    types = "<TypeDefinitions>"
    for name, unit in (("Length", "m"), ("Acceleration", "m/s2")):
        types += f'<SimpleType name="{name}"><Real unit="{unit}"/></SimpleType>'
    text = defects.description()
    for old, new in (
        ('<Real unit="m/s2"', '<Real declaredType="Acceleration"'),
        ('name="stretch" valueReference="10"', 'name="stretch" valueReference="5"'),
        ('calculated"><Real unit="m" />', 'calculated"><Real declaredType="Length" />'),
        ("<DefaultExperiment", f"{types}</TypeDefinitions><DefaultExperiment"),
    ):
        assert old in text, old
        text = text.replace(old, new)
    defect = defects.Defect(frozenset(), change=(defects.description(), text))
    report = validate_fmu(defects.build(tmp_path, defect), only=("description",))
    assert troubles(report) == set()


def test_nothing_is_run_of_what_cannot_be_understood(sound: Path, tmp_path: Path):
    """Nor a library loaded from elsewhere; what is said is in tests/corpus/validate.txt."""
    for old, new in (
        (b'start="5.0"', b'start="five"'),
        (b'modelIdentifier="', b'modelIdentifier="/'),
    ):
        report = validate_fmu(planted(sound, tmp_path / "faulty.fmu", old, new))
        assert not report.ok
        assert all(group.skipped for group in report.groups if group.name != "description")
    report = validate_fmu(sound, only=("description", "state"), skip=("description",))
    assert [group.name for group in report.groups] == ["state"]


def test_a_crash_names_the_call_and_spares_the_other_groups(tmp_path: Path):
    path = defects.build(tmp_path, DEFECTS["reset crashes"])
    report = validate_fmu(path, only=("instances", "state"))
    (crash,) = report.of_severity("error")
    assert "SIGSEGV in fmi2Reset()" in crash.message
    assert {group.name: group.passed for group in report.groups} == {
        "state": True,
        "instances": False,
    }


@pytest.mark.parametrize("native", [False, True])
@pytest.mark.parametrize(
    "model",
    [
        lambda: hanging_chain(10),
        lambda: load_model(EXAMPLES / "paper_cases" / "foswec.model.yaml"),
    ],
    ids=["ten links", "foswec"],
)
def test_our_own_fmus_have_no_finding(model: Callable, native: bool, tmp_path: Path):
    path = build_fmu(model_program(model()), tmp_path / "model.fmu", native=native)
    report = validate_fmu(path)
    assert report.of_severity("error", "warning") == ()
    skipped = {group.name for group in report.groups if group.skipped}
    assert skipped == (set() if native else {"directional"})


@pytest.mark.skipif(not Path("/proc").exists(), reason="processes are listed there")
def test_a_call_that_hangs_ends_with_who_watches_it(tmp_path: Path) -> None:
    """Nobody else would end it, ever."""
    path = defects.build(tmp_path, DEFECTS["reset hangs"])
    command = [sys.executable, "-m", "m4e_fmi", "validate", str(path)]
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    process = subprocess.Popen(command, stderr=subprocess.PIPE, env=environment, text=True)
    began = time.monotonic()
    while not any(b"Reset" in p.read_bytes() for p in tmp_path.rglob("*.journal")):
        assert time.monotonic() < began + 60, "it was not reset"
        time.sleep(0.05)
    (watching,) = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    os.kill(int(watching), signal.SIGKILL)
    said = process.communicate(timeout=60)[1]
    assert (process.returncode, "the checks ended with code -9" in said) == (1, True)
    began = time.monotonic()
    while left := [p for p in Path("/proc").glob("[0-9]*") if str(tmp_path) in command_of(p)]:
        assert time.monotonic() < began + 5, left
        time.sleep(0.05)


def command_of(process: Path) -> str:
    """The command line of a process of /proc; empty if it is gone."""
    try:
        return (process / "cmdline").read_bytes().decode(errors="replace")
    except OSError:
        return ""


def without_libraries(path: Path, changed: Path, **more: str) -> Path:
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(changed, "w") as target:
        target.writestr(defects.XML, source.read(defects.XML))
        for name, text in more.items():
            target.writestr(f"{name}/file.c", text)
    return changed


@pytest.mark.parametrize("folder", ["sources", "binaries/other64"])
def test_an_fmu_that_cannot_run_here_fails(
    folder: str, sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    path = without_libraries(sound, tmp_path / "empty.fmu", **{folder: "int a;"})
    assert main(["validate", str(path)]) == 1
    printed = capsys.readouterr().out
    assert "error library.missing: cannot run here: there is no binaries/" in printed
    assert ("sources are enough for the standard" in printed) == (folder == "sources")


@pytest.mark.parametrize("group", ["description", "start"])
def test_a_defect_of_ours_is_not_laid_at_the_door_of_the_fmu(
    group: str, sound: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    broken = f"import {PACKAGE}.{MODULES.get(group, 'start')} as module; module.check = None; "
    monkeypatch.setattr(validation_run, "_HOST", broken + validation_run._HOST)

    def defective(_: Path) -> None:
        raise TypeError("numpy boolean subtract")

    if group == "description":
        monkeypatch.setattr(validation_run, "description_findings", defective)
    report = validate_fmu(sound, only=(group,))
    assert report.findings == ()
    assert not report.complete
    assert main(["validate", str(sound), "--only", group]) == 1
    printed = capsys.readouterr().out
    assert f"{group}: this check failed to run (internal): " in printed
    assert "a defect of m4e_fmi, not of the FMU" in printed


def test_the_command(sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    faulty = defects.build(tmp_path, DEFECTS["start below min"])
    assert main(["validate", str(sound), "--only", "description"]) == 0
    assert "no errors, no warnings" in capsys.readouterr().out
    assert main(["validate", str(sound), str(faulty), "--only", "description", "--json"]) == 1
    one, other = json.loads(capsys.readouterr().out)
    assert one["ok"]
    assert not other["ok"]
    (error,) = [f for g in other["groups"] for f in g["findings"] if f["severity"] == "error"]
    assert error["id"] == "variables.start"
    assert "stiffness: start 5 is not between 6 and inf" in error["message"]


def test_all_that_an_fmu_says(sound: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["info", str(sound), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["experiment"] == {"startTime": 0.0, "stopTime": 10.0, "stepSize": 0.01}
    assert told["kinds"]["co-simulation"]["maxOutputDerivativeOrder"] == 1
    assert len(told["variables"]) == 13
    (power,) = [u for u in told["structure"]["outputs"] if u["name"] == "power"]
    assert power["dependencies"] == ["force", "v"]
    assert main(["info", str(sound)]) == 0
    assert "FMI 2.0 model exchange and co-simulation, 13 variables" in capsys.readouterr().out
