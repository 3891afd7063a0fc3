"""Files that mean harm, or look like it: one message, at once, and nothing done.

`tests/property/test_damaged_files.py` damages files at random.
"""

from __future__ import annotations

import re
import stat
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import fmpy
import pytest
from support import defects, paper_listings
from support.fuzz.cases import DEFECT
from support.fuzz.families import FMI_3

from m4e_fmi.cli import main
from m4e_fmi.cosim import fmu_files, load_system
from m4e_fmi.cosim.ssp import unpack_member
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files import archives, xml_text, yaml_tree
from m4e_fmi.files.csv_columns import read_columns
from m4e_fmi.files.document import Document
from m4e_fmi.files.file_names import LONGEST, file_stem, file_stems
from m4e_fmi.files.limits import MOST_VALUES
from m4e_fmi.files.xml_text import check_xml, xml_root
from m4e_fmi.fmu import Options, build_fmu, validate_fmu
from m4e_fmi.fmu.importer.opening import check_archive
from m4e_fmi.fmu.importer.reading import read_description
from m4e_fmi.fmu.importer.unpack import Unpacked
from m4e_fmi.model import Body, Joint, Model, load_model, model_from_lists
from m4e_fmi.multibody import model_program
from m4e_fmi.report import fmu_documentation
from m4e_fmi.results.results_file import load
from m4e_fmi.shown import cleaned
from m4e_fmi.units import near_unit, parse_unit

CENTRAL = b"PK\x01\x02"
"""Signature of an entry in the directory of an archive."""
MODEL = """\
name: {name}
description: {description}
bodies: {{a: {{mass: 2, inertia: 0.1}}}}
joints:
  j: {{type: prismatic, child: a, direction: {direction}, initial: {{q: 0.1}}}}
loads: {{f: {{type: joint_effort, joint: j, effort: {effort}}}}}
"""


def model(folder: Path, **given: str) -> Path:
    path = folder / "a.model.yaml"
    texts = {"name": "a", "description": "a", "direction": "[1, 0]", "effort": "1", **given}
    path.write_text(MODEL.format(**texts), encoding="utf-8")
    return path


def fmu(path: Path, text: str | bytes, **more: str) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(defects.XML, text)
        archive.writestr(f"binaries/{fmpy.platform}/oscillator{fmpy.sharedLibraryExtension}", b"")
        for name, content in more.items():
            archive.writestr(name, content)
    return path


# ---- YAML ----


def test_aliases_of_aliases_are_counted():
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 12)]
    with pytest.raises(InputError, match=f"stands for more than {MOST_VALUES} values") as caught:
        Document.parse("\n".join(lines), "bomb.yaml")
    assert 0 < caught.value.problems[0].line < 12


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [" + "1," * 160 + "1]", "has more than 150 keys and values"),
        ("a: " + "[" * 101 + "]" * 101, "nested too deeply: more than 100 levels"),
        ("a: " + "x" * 100_001, "value of 100001 characters"),
        ("a: 1" + "0" * 400, "number that is too large"),
        ("a: [0x" + "f" * 9000 + "]", "number that is too large"),
        ("0x" + "f" * 900 + ": 1", "number that is too large"),
    ],
)
def test_a_document_beyond_its_limits(text: str, message: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(yaml_tree, "MOST_WRITTEN", 150)
    with pytest.raises(InputError, match=message) as caught:
        Document.parse(text)
    assert caught.value.problems[0].line == 1


@pytest.mark.parametrize("unit", ["m^999999999", "km^99999", "km-99999", "m" + "9" * 5000,
                                  "Tm20.TN20"])  # fmt: skip
def test_a_unit_out_of_all_scale(unit: str):
    with pytest.raises(ValueError, match=r"exponents are up to 20|out of all scale|up to 100 l"):
        parse_unit(unit)


@pytest.mark.parametrize(
    ("text", "value"), [("a: &a [*a]", [None]), ("a: &a {b: *a}", {"b": None})]
)
def test_an_alias_of_itself_has_no_value(text: str, value: object):
    assert Document.parse(text).data == {"a": value}


def test_a_merge_of_itself_is_refused_in_plain_words():
    with pytest.raises(InputError, match=r"an alias, a merge, .* cannot be read") as caught:
        Document.parse("a: &a\n  <<: *a")
    assert "NoneType" not in str(caught.value)


@pytest.mark.parametrize(
    "value", ["9" * 5000, "!!int x", "2001-13-45", "!!timestamp x", "!!float x"]
)
def test_what_the_parser_cannot_make_anything_of(value: str):
    with pytest.raises(InputError):
        Document.parse(f"a: {value}")


def test_a_file_without_end_is_not_read(tmp_path: Path):
    endless = tmp_path / "a.yaml"
    endless.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="is longer than 10 MB"):
        Document.load(endless)


@pytest.mark.parametrize("kind", ["[]", "{}", "null", "[sum]", "1"])
def test_a_kind_that_is_no_word(kind: str, tmp_path: Path):
    path = tmp_path / "system.yaml"
    path.write_text(
        f"name: a\ncomponents: {{b: {{kind: {kind}}}}}\nsimulation: {{stop_time: 1, step_size: 1}}"
    )
    with pytest.raises(InputError, match="unknown kind"):
        load_system(path)


@pytest.mark.parametrize("name", ["true", "1", "1.5", "2001-01-01"])
def test_a_component_whose_name_yaml_takes_for_something_else(name: str, tmp_path: Path):
    part = model(tmp_path).name
    path = tmp_path / "system.yaml"
    path.write_text(
        f"name: a\ncomponents: {{{name}: {{model: {part}}}}}\n"
        "simulation: {stop_time: 1, step_size: 1}\n"
    )
    with pytest.raises(InputError, match=r"use letters, digits and _"):
        load_system(path)


@pytest.mark.parametrize("name", ["x" * 300, "y" * 300 + "/x", "a/" * 3000 + "x"])
@pytest.mark.parametrize("part", ["{model: NAME}", "{fmu: NAME}",
                                  "{kind: table, file: NAME, signals: {a: m}}"])  # fmt: skip
def test_a_file_whose_name_is_too_long(name: str, part: str, tmp_path: Path):
    path = tmp_path / "system.yaml"
    path.write_text(
        f"name: a\ncomponents: {{b: {part.replace('NAME', name)}}}\n"
        "simulation: {stop_time: 1, step_size: 1, algorithm: jacobi}\n"
    )
    assert main(["run", str(path)]) == 2


def test_a_long_unit_takes_no_time():
    begin = time.process_time()
    with pytest.raises(ValueError, match="units have up to 100 letters"):
        parse_unit("x" * 100_000)
    assert near_unit("x y " * 25_000) == ""
    assert time.process_time() - begin < 1


# ---- numbers ----


@pytest.mark.parametrize(
    "direction", ["[1e300, 0]", "[1e-300, 0]", "[1e200, 1e200]", "[0, 1e-160]"]
)
def test_a_direction_out_of_all_scale(direction: str, tmp_path: Path):
    with pytest.raises(InputError, match="is out of all scale"):
        load_model(model(tmp_path, direction=direction))


@pytest.mark.parametrize(
    "effort", ["1e308*10*t", "sign(1e308*10)*t", "sign(1e308*1e308)", "1e300**2*t", "sign(0*1e999)"]
)
@pytest.mark.parametrize("command", ["info", "equations", "simulate", "linearize"])
def test_an_overflow_in_a_load(
    effort: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    path = model(tmp_path, effort=effort)
    more = ("--no-plot", "--stop-time", "0.01", "--output-file", str(tmp_path / "a.nc"))
    code = main([command, str(path), *(more if command == "simulate" else ())])
    assert code in (0, 1, 2)
    assert DEFECT not in capsys.readouterr().err


def test_a_mass_that_is_none():
    lists = paper_listings.small_double_pendulum()
    lists["m0"] = [None, 1.0]
    with pytest.raises(InputError, match="got None"):
        model_from_lists(lists)


# ---- names ----

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


def test_components_that_differ_in_capitals_have_files_of_their_own(tmp_path: Path):
    path = model(tmp_path)
    system = tmp_path / "system.yaml"
    system.write_text(
        f"name: s\ncomponents: {{a: {{model: {path.name}}}, A: {{model: {path.name}}}}}\n"
        "simulation: {stop_time: 1, step_size: 0.1}\n"
    )
    files = fmu_files(load_system(system), tmp_path / "build")
    assert len({str(file).casefold() for file in files.values()}) == 2


def test_members_of_a_package_have_files_of_their_own(tmp_path: Path):
    path = tmp_path / "a.ssp"
    members = {"resources/a/b.fmu": b"1", "resources/a_b.fmu": b"2", "resources/A_B.fmu": b"3"}
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", "")
        for name, content in members.items():
            archive.writestr(name, content)
    files = {name: unpack_member(path, name, tmp_path / "out") for name in members}
    assert {name: file.read_bytes() for name, file in files.items()} == members
    assert len({str(file).casefold() for file in files.values()}) == 3


# ---- FMUs ----


def bomb(encoding: str) -> bytes:
    text = (
        f'<?xml version="1.0" encoding="{encoding}"?>\n<!-- a --><!DOCTYPE a [<!ENTITY b "c">]>\n'
    )
    return (text + "<fmiModelDescription/>").encode(encoding)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
def test_a_doctype_is_found_in_every_encoding(encoding: str, tmp_path: Path):
    with pytest.raises(InputError, match="has a DOCTYPE") as caught:
        check_archive(fmu(tmp_path / "a.fmu", bomb(encoding)))
    assert caught.value.problems[0].line == 2


@pytest.mark.parametrize("encoding", ["utf-32", "euc-jp", "utf-7"])
def test_an_encoding_that_cannot_be_checked_is_refused(encoding: str, tmp_path: Path):
    with pytest.raises(InputError, match=r"encoding that is not read|cannot be understood"):
        read_description(fmu(tmp_path / "a.fmu", bomb(encoding)))


def test_the_word_in_a_comment_is_no_doctype():
    check_xml(b"<a><!-- <!DOCTYPE --></a>", "a.xml")


def test_a_description_may_be_too_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(xml_text, "LARGEST_XML", 1_000_000)
    path = fmu(tmp_path / "a.fmu", f"<a>{'b' * 2_000_000}</a>")
    with pytest.raises(InputError, match="has 2 MB; XML files of up to 1 MB are read"):
        check_archive(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [("<a>" * 101 + "</a>" * 101, "nested more than 100"), ("<a><b/><b/></a>", "more than 2 el")],
)
def test_xml_may_be_too_deep_or_long(text: str, message: str, monkeypatch: pytest.MonkeyPatch):
    if "b" in text:
        monkeypatch.setattr(xml_text, "MOST_ELEMENTS", 2)
    with pytest.raises(InputError, match=message):
        xml_root(text.encode(), "a.xml")


# ---- archives ----


def rewritten(path: Path, signature: bytes, at: int, value: bytes) -> Path:
    """The archive with bytes of the last header of that kind exchanged."""
    content = bytearray(path.read_bytes())
    place = content.rindex(signature) + at
    content[place : place + len(value)] = value
    path.write_bytes(content)
    return path


def test_entries_that_lie_in_one_another(tmp_path: Path):
    path = fmu(tmp_path / "a.fmu", defects.description(), x="y")
    rewritten(path, CENTRAL, 20, (10**6).to_bytes(4, "little"))
    with pytest.raises(InputError, match="entries that lie in one another"):
        check_archive(path)


@pytest.mark.parametrize(("name", "other"), [("A", "a"), ("a", "a/b")])
def test_entries_that_are_one_to_the_file_system(
    name: str, other: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(archives.sys, "platform", "win32")
    path = fmu(tmp_path / "a.fmu", defects.description(), **{name: "1", other: "2"})
    with pytest.raises(InputError, match=r"'A' and 'a' twice|'a' as a file and as a folder"):
        check_archive(path)


@pytest.mark.parametrize("name", ["con", "a/NUL.txt", "com1"])
def test_devices_of_windows_are_no_entries_there(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = fmu(tmp_path / "a.fmu", defects.description(), **{name: "1"})
    check_archive(path)
    monkeypatch.setattr(archives.sys, "platform", "win32")
    with pytest.raises(InputError, match="takes for a device"):
        check_archive(path)


def test_an_encrypted_archive_is_named_so(tmp_path: Path):
    path = fmu(tmp_path / "a.fmu", defects.description())
    with pytest.raises(InputError, match=r"the archive is encrypted\n +.*without a password"):
        check_archive(rewritten(path, CENTRAL, 8, b"\x01"))


def test_a_link_in_an_archive_becomes_a_plain_file(tmp_path: Path):
    path = fmu(tmp_path / "a.fmu", defects.description())
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(link, "/etc/passwd")
    unpacked = Unpacked(path)
    file = unpacked.folder / "resources" / "link"
    assert not file.is_symlink()
    assert file.read_text() == "/etc/passwd"
    unpacked.remove()


@pytest.mark.parametrize(("limit", "most"), [("MOST_ENTRIES", 1), ("DEEPEST_FOLDER", 1)])
def test_an_archive_may_have_too_many_entries_or_folders(
    limit: str, most: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(archives, limit, most)
    with pytest.raises(InputError, match=r"has 2 entries; 1 are|3 levels deep; 1 are"):
        check_archive(fmu(tmp_path / "a.fmu", defects.description()))


def test_a_package_that_needs_another_version_of_zip(tmp_path: Path):
    path = tmp_path / "a.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", "")
    with pytest.raises(InputError, match="not a readable ZIP archive: zip file version"):
        load_system(rewritten(path, CENTRAL, 6, b"\xff\x00"))


def test_a_large_array_is_not_looked_at(tmp_path: Path):
    text = FMI_3.replace('start="3"/>', 'start="9000000"/>')
    report = validate_fmu(fmu(tmp_path / "a.fmu", text))
    (finding,) = report.of_severity("warning")
    assert finding.id == "description.limits"
    assert "9,000,006 variables" in finding.message
    assert all("at most 50,000" in group.skipped for group in report.groups[1:])


@pytest.mark.parametrize(
    ("method", "place"), [(zipfile.ZIP_DEFLATED, 0), (zipfile.ZIP_LZMA, 9)]
)  # after the properties, for LZMA
def test_a_damaged_archive_needs_no_disk_space(tmp_path: Path, method: int, place: int):
    path = fmu(tmp_path / "a.fmu", defects.description())
    with zipfile.ZipFile(path, "a", method) as archive:
        archive.writestr("extra", "a" * 100)
    content = path.read_bytes()
    place += content.index(b"extra") + len("extra")
    path.write_bytes(content[:place] + bytes([content[place] ^ 255]) + content[place + 1 :])
    with pytest.raises(InputError, match="it is damaged") as caught:
        Unpacked(path)
    assert "disk space" not in str(caught.value)


def test_a_name_that_is_too_long_needs_no_disk_space(tmp_path: Path):
    path = fmu(tmp_path / "a.fmu", defects.description(), **{"x" * 300: ""})
    with pytest.raises(InputError, match="a name of 300 characters"):
        check_archive(path)


def test_a_full_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(fmpy, "extract", full)
    with pytest.raises(RunError, match="free disk space"):
        Unpacked(fmu(tmp_path / "a.fmu", defects.description()))


def test_marks_of_the_page_in_a_description_stay_as_they_are(tmp_path: Path):
    read = load_model(model(tmp_path, description="'@sections@ @title@'"))
    files = fmu_documentation(read, model_program(read), Options())
    (page,) = [text for name, text in files.items() if name.endswith("index.html")]
    assert b"@sections@ @title@" in page
    assert page.count(b"<h2>Variables</h2>") == 1


# ---- what is printed ----


@pytest.mark.parametrize(
    "component",
    [
        "{kind: table, file: FILE, signals: {speed: m/s}}",
        "{model: FILE}",
        "{kind: mooring, file: FILE}",
        "{fmu: FILE}",
        "{kind: hydrodynamics, bodies: {a: {shape: {mesh: FILE}, center_of_gravity: [0, 0]}}}",
    ],
)
def test_of_a_file_that_another_one_names_nothing_is_printed(
    component: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "passwd"
    file.write_text("xyzzy:x:0:0, xyzzy\nname: xyzzy\n- xyzzy\n: xyzzy\n")
    text = f"name: a\ncomponents:\n  b: {component.replace('FILE', str(file))}\n"
    (tmp_path / "system.yaml").write_text(
        f"{text}simulation: {{stop_time: 1, step_size: 0.1, algorithm: jacobi}}\n"
    )
    assert main(["run", str(tmp_path / "system.yaml")]) == 2
    told = "".join(capsys.readouterr())
    assert "passwd" in told
    assert "xyzzy" not in told


def test_a_table_that_is_none_is_not_printed(tmp_path: Path):
    path = tmp_path / "environ.csv"
    path.write_bytes(b"SECRET=abc\0PATH=a,b\0")
    with pytest.raises(InputError) as caught:
        read_columns(path, [("time", "s"), ("force", "N")])
    assert "abc" not in str(caught.value)


def test_of_a_long_line_little_is_printed(tmp_path: Path):
    path = tmp_path / "a.csv"
    path.write_text(f"time,force\n0,{'secret' * 1000}\n")
    with pytest.raises(InputError) as caught:
        read_columns(path, [("time", "s"), ("force", "N")])
    assert len(str(caught.value)) < 400


def test_control_characters_do_not_reach_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    path = model(tmp_path, name='"a\\e[2J\\u202eb\\u0085c\\rd"', description='"\\e]0;x\\a"')
    assert main(["info", str(path)]) == 0
    assert main(["info", str(model(tmp_path, effort='"\\e[2J"'))]) == 2
    printed = "".join(capsys.readouterr())
    assert not set("\x1b\u202e\x85\x07\r") & set(printed)
    assert "a\ufffd[2J\ufffdb\ufffdc\ufffdd" in printed


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


def test_plain_text_is_printed_as_it_is():
    text = "Schwimmkörper π → 浮\t1\n"
    assert cleaned(text) == text


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
