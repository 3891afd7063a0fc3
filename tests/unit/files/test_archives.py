"""XML and archives that mean harm, or look like it: refused, and nothing done."""

from __future__ import annotations

import stat
import zipfile
from pathlib import Path

import fmpy
import pytest
from support import defects
from support.fuzz.families import FMI_3

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.ssp import unpack_member
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files import archives, xml_text
from m4e_fmi.files.xml_text import check_xml
from m4e_fmi.fmu import validate_fmu
from m4e_fmi.fmu.importer.opening import Unpacked, check_archive
from m4e_fmi.fmu.importer.reading import read_description

CENTRAL = b"PK\x01\x02"
"""Signature of an entry in the directory of an archive."""


def fmu(path: Path, text: str | bytes, **more: str) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(defects.XML, text)
        archive.writestr(f"binaries/{fmpy.platform}/oscillator{fmpy.sharedLibraryExtension}", b"")
        for name, content in more.items():
            archive.writestr(name, content)
    return path


def bomb(encoding: str) -> bytes:
    text = (
        f'<?xml version="1.0" encoding="{encoding}"?>\n<!-- a --><!DOCTYPE a [<!ENTITY b "c">]>\n'
    )
    return (text + "<fmiModelDescription/>").encode(encoding)


def rewritten(path: Path, signature: bytes, at: int, value: bytes) -> Path:
    """The archive with bytes of the last header of that kind exchanged."""
    content = bytearray(path.read_bytes())
    place = content.rindex(signature) + at
    content[place : place + len(value)] = value
    path.write_bytes(content)
    return path


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


def test_a_full_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(fmpy, "extract", full)
    with pytest.raises(RunError, match="free disk space"):
        Unpacked(fmu(tmp_path / "a.fmu", defects.description()))


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


@pytest.mark.parametrize(("encoding", "message"), [
    ("utf-8", "has a DOCTYPE"), ("utf-16", "has a DOCTYPE"), ("iso-8859-1", "has a DOCTYPE"),
    *((other, "encoding that is not read|cannot be understood")
      for other in ("utf-32", "euc-jp", "utf-7")),
])  # fmt: skip
def test_a_doctype_is_found_in_every_encoding_or_that_is_refused(
    encoding: str, message: str, tmp_path: Path
) -> None:
    check_xml(b"<a><!-- <!DOCTYPE --></a>", "a.xml")
    with pytest.raises(InputError, match=message) as caught:
        read_description(fmu(tmp_path / "a.fmu", bomb(encoding)))
    assert message != "has a DOCTYPE" or caught.value.problems[0].line == 2


@pytest.mark.parametrize(("limit", "most", "text", "message"), [
    ("LARGEST_XML", 1_000_000, f"<a>{'b' * 2_000_000}</a>", "has 2 MB; XML files of up to 1 MB"),
    ("MOST_ELEMENTS", 2, "<a><b/><b/></a>", "more than 2 el"),
    ("MOST_ELEMENTS", 9999, "<a>" * 101 + "</a>" * 101, "nested more than 100"),
])  # fmt: skip
def test_xml_may_be_too_long_or_deep(
    limit: str, most: int, text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(xml_text, limit, most)
    with pytest.raises(InputError, match=message):
        read_description(fmu(tmp_path / "a.fmu", text))


TWICE = "'A' and 'a' twice"
ON_WINDOWS = "takes for a device"
ENTRIES = {  # entries of an archive besides its two, whether only Windows refuses it, message
    "a name of 300 characters": ({"x" * 300: ""}, False),
    TWICE: ({"A": "1", "a": "2"}, True),
    "'a' as a file and as a folder": ({"a": "1", "a/b": "2"}, True),
    **{f"{name}|{ON_WINDOWS}": ({name: "1"}, True) for name in ("con", "a/NUL.txt", "com1")},
}


@pytest.mark.parametrize("message", ENTRIES)
def test_names_of_entries(message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names, windows = ENTRIES[message]
    path = fmu(tmp_path / "a.fmu", defects.description(), **names)
    if windows:
        if ON_WINDOWS in message:
            check_archive(path)
        monkeypatch.setattr(archives.sys, "platform", "win32")
    with pytest.raises(InputError, match=message):
        check_archive(path)


@pytest.mark.parametrize(("at", "value", "message"), [
    (20, (10**6).to_bytes(4, "little"), "entries that lie in one another"),
    (8, b"\x01", r"the archive is encrypted\n +.*without a password"),
])  # fmt: skip
def test_headers_of_entries(at: int, value: bytes, message: str, tmp_path: Path) -> None:
    path = fmu(tmp_path / "a.fmu", defects.description(), x="y")
    with pytest.raises(InputError, match=message):
        check_archive(rewritten(path, CENTRAL, at, value))


@pytest.mark.parametrize(("limit", "message"), [
    ("MOST_ENTRIES", "has 2 entries; 1 are"), ("DEEPEST_FOLDER", "3 levels deep; 1 are"),
])  # fmt: skip
def test_an_archive_may_have_too_many_entries_or_folders(
    limit: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archives, limit, 1)
    with pytest.raises(InputError, match=message):
        check_archive(fmu(tmp_path / "a.fmu", defects.description()))
