"""Models and names that mean harm, or look like it: one message, at once, and nothing done.

Archives: tests/unit/files/test_archives.py; tests/property/test_damaged_files.py damages files at
random.
"""

from __future__ import annotations

import re
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
from support.fuzz.cases import DEFECT

from m4e_fmi.cli import main
from m4e_fmi.errors import InputError
from m4e_fmi.files import document
from m4e_fmi.files.document import Document
from m4e_fmi.files.file_names import LONGEST, file_stem, file_stems
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.multibody import model_program
from m4e_fmi.results.results_file import load
from m4e_fmi.units import parse_unit

MODEL = """\
name: {name}
description: {description}
bodies: {{a: {{mass: 2, inertia: 0.1}}}}
joints:
  j: {{type: prismatic, child: a, direction: [1, 0], initial: {{q: 0.1}}}}
"""


def model(folder: Path, **given: str) -> Path:
    path = folder / "a.model.yaml"
    path.write_text(MODEL.format(**{"name": "a", "description": "a", **given}), encoding="utf-8")
    return path


@pytest.mark.parametrize(("text", "message"), [
    ("a: [" + "1," * 160 + "1]", "has more than 150 keys and values"),
    ("a: " + "x" * 100_001, "value of 100001 characters"),
    ("a: 1" + "0" * 400, "number that is too large"),
    ("0x" + "f" * 900 + ": 1", "number that is too large"),
])  # fmt: skip
def test_a_document_beyond_its_limits(
    text: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Others are in tests/corpus/yaml.yaml."""
    monkeypatch.setattr(document, "MOST_WRITTEN", 150)
    with pytest.raises(InputError, match=message) as caught:
        Document.parse(text)
    assert caught.value.problems[0].line == 1


@pytest.mark.parametrize(("text", "value"), [("&a [*a]", [None]), ("&a {b: *a}", {"b": None})])
def test_an_alias_of_itself_has_no_value(text: str, value: object) -> None:
    assert Document.parse(f"a: {text}").data == {"a": value}


UNITS = ("m^999999999", "km^99999", "km-99999", "m" + "9" * 5000, "Tm20.TN20", "x" * 100_000)


def test_units_out_of_all_scale_take_no_time() -> None:
    begin = time.process_time()
    for unit in UNITS:
        with pytest.raises(ValueError, match=r"exponents are up to 20|out of all scale|up to 100"):
            parse_unit(unit)
    assert time.process_time() - begin < 1


NAMES = ["../../x", "/tmp/x", "a/b", "..", ".", "con", "NUL.txt", "a:b", "x" * 400, "a.", "\n", "ü"]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_never_becomes_a_path(name: str):
    stem = file_stem(name)
    assert Path(stem).name == stem
    assert len(stem.encode()) <= LONGEST + 9
    assert not stem.startswith(".")
    assert stem.partition(".")[0].lower() not in ("con", "nul")
    assert (stem == name) == (name == "ü")


def test_two_names_never_become_one_file():
    names = ["a", "A", "a/b", "a_b", "a:b", "x" * 200, "x" * 201]
    stems = file_stems(names)
    assert len({stem.casefold() for stem in stems.values()}) == len(names)
    assert stems["a"] == "a"


def test_files_stay_in_the_build_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    name = "../../outside"
    work = tmp_path / "one" / "two"
    work.mkdir(parents=True)
    monkeypatch.chdir(work)
    (work / "parts").mkdir()
    part = model(work / "parts").relative_to(work)
    path = model(work, name=f"'{name}'")
    system = work / "system.yaml"
    system.write_text(
        f"name: '{name}'\ncomponents:\n  con: {{model: {part}}}\n  CON: {{model: {part}}}\n"
        "simulation: {stop_time: 0.02, step_size: 0.01, algorithm: jacobi}\n"
    )
    commands = (
        ["simulate", str(path), "--stop-time", "0.01"],
        ["draw", str(path)],
        ["run", str(system)],
        ["build", str(system), "--ssp"],
    )
    for command in commands:
        assert main(command) == 0, capsys.readouterr().err
    assert main(["build", str(path)]) == 2  # an FMU has to be called like a variable of C
    assert len(list(work.rglob("*.fmu"))) == 2
    outside = [p for p in tmp_path.rglob("*") if p.is_file() and work not in p.parents]
    assert not outside


def test_texts_do_no_harm_where_they_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    text = '"\\e[2J\\u202e\\ud800</script><script>alert(1)</script> @title@ $x$ \\\\input{x} %"'
    name = model(tmp_path, description=text).name
    for command in (
        ["build", name],
        ["simulate", name, "--stop-time", "0.1", "--animate", "a.html", "--output-file", "a.nc"],
        ["draw", name],
        ["equations", name],
    ):
        assert main(command) == 0, capsys.readouterr().err
    (built,) = Path().rglob("*.fmu")
    with zipfile.ZipFile(built) as archive:
        page = archive.read("documentation/index.html").decode()
        assert "[2J" in archive.read("modelDescription.xml").decode()
    for shown in (page, Path("a.html").read_text("utf-8"), *load("a.nc").attributes.values()):
        assert not re.search("[\x1b\u202e\ud800]", shown)
    for shown in (page, Path("a.html").read_text("utf-8")):
        assert "&lt;script&gt;alert(1)" in shown
        assert "<script>alert" not in shown
        assert "@title@" in shown


@pytest.mark.parametrize("text", ["a\ud800", "a\x00"])
def test_texts_of_python_that_no_fmu_can_hold(text: str, tmp_path: Path):
    model_ = Model(
        name="a",
        description=text,
        bodies={"a": Body(mass=2, inertia=1)},
        joints={"j": Joint("revolute", "a")},
    )
    with pytest.raises(InputError, match="zero byte, or half of a character"):
        build_fmu(model_program(model_), tmp_path / "a.fmu", native=True)


# ---- the last resort ----


def test_an_unexpected_error_is_one_line_and_a_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def defective(_: Path) -> None:
        raise KeyError("surprise")

    monkeypatch.setattr("m4e_fmi.model.load_model", defective)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("M4E_SECRET", "hidden in the environment")
    assert main(["draw", "a.model.yaml"]) == 1
    first, second = capsys.readouterr().err.splitlines()
    assert first == "failed: KeyError: 'surprise'"
    assert DEFECT in second
    report = Path(second.split("report ")[1]).read_text(encoding="utf-8")
    assert "Traceback" in report
    assert "['draw', 'a.model.yaml']" in report
    assert "hidden in the environment" not in report


def test_a_reader_that_leaves_is_no_error():
    code = "import sys; from m4e_fmi.cli import main; sys.exit(main(['info', sys.argv[1]]))"
    example = Path(__file__).parents[3] / "examples/paper_cases/spiderfloat.model.yaml"
    command = [sys.executable, "-c", code, str(example)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() in (0, 120)
