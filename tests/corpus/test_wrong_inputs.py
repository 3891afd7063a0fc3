"""Wrong files and command lines, and word for word what is said about each.

A group is a file `GROUP.yaml` of this folder: good files, a command that accepts them, and cases
that each change something; `GROUP.txt` beside it has the exit code and text to which each leads.

- `files`: contents by name: a text, `{copy: PATH}` of a file of this project, `{hex: BYTES}`, or
  `{c_fmu: NAME}`, an FMU of tests/support/c_fmus; a folder `NAME.ssp` becomes an archive
- `before`: commands that are run once, in the folder of the good files
- `command`: what is typed after `m4e-fmi`
- `cases`, by name: `change`: old texts, each there once (also in a file of an FMU), and new ones;
  `files` and `command` add to or replace those of the group

``pytest --update tests/corpus`` accepts what is said: read the difference.
"""

from __future__ import annotations

import re
import shlex
import shutil
import zipfile
from collections.abc import Callable
from contextlib import chdir
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from m4e_fmi.cli import main

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
HEAD = re.compile(r"^== (.*)\n", re.MULTILINE)
USAGE = re.compile(r"^usage: .*?\n(?=m4e-fmi)", re.DOTALL)
"""The list of options before the mistakes in them."""
VARYING = re.compile(r"\d+\.\d(?= s of checks)|(?<=needs )GLIBC_.*")
"""Numbers and names that depend on the machine."""


@dataclass
class Case:
    """One case of a group; its files are those of the group, too."""

    group: str
    name: str
    command: str
    files: dict[str, Any] = field(default_factory=dict)
    change: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.group}: {self.name}"


@cache
def read_group(name: str) -> dict[str, Any]:
    return YAML(typ="safe", pure=True).load((FOLDER / f"{name}.yaml").read_text("utf-8"))


GROUPS = sorted(path.stem for path in FOLDER.glob("*.yaml"))


def cases(group: str) -> list[Case]:
    """The cases of a group; the command is that of the group, if a case has none."""
    given = read_group(group)
    shared = {"command": given.get("command", "")}
    return [Case(group, name, **(shared | case)) for name, case in given["cases"].items()]


@pytest.fixture(scope="session")
def good_files(
    tmp_path_factory: pytest.TempPathFactory, c_fmu: Callable[[str], Path]
) -> Callable[[str], Path]:
    """`good_files(group)` is a folder with the group's files, after its commands `before`."""

    @cache
    def made(group: str) -> Path:
        folder, given = tmp_path_factory.mktemp(group), read_group(group)
        write_files(given.get("files", {}), folder, c_fmu)
        with chdir(folder):
            assert not any(main(shlex.split(command)) for command in given.get("before", ()))
        return folder

    return made


def write_files(files: dict[str, Any], folder: Path, c_fmu: Callable[[str], Path]) -> None:
    for name, given in files.items():
        match given:
            case str():
                content = given.encode()
            case {"hex": digits}:
                content = bytes.fromhex(digits)
            case {"copy": path}:
                content = (ROOT / path).read_bytes()
            case {"c_fmu": model}:
                content = c_fmu(model).read_bytes()
            case _:
                raise ValueError(f"{name}: {given}")
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def change_file(folder: Path, old: str, new: str) -> None:
    """Replace a text that is in one file of the folder, or of an FMU in it, once."""
    files = {(path, ""): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for path in folder.rglob("*.fmu"):
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as archive:
                files |= {(path, name): archive.read(name) for name in archive.namelist()}
    counts = {place: content.count(old.encode()) for place, content in files.items()}
    assert sum(counts.values()) == 1, f"there {sum(counts.values())} times: {old}"
    path, member = max(files, key=counts.__getitem__)
    files[path, member] = files[path, member].replace(old.encode(), new.encode())
    if not member:
        path.write_bytes(files[path, ""])
        return
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for (of, name), content in files.items():
            if of == path and name:
                archive.writestr(name, content)


def pack(folder: Path) -> None:
    """Make archives of the folders `NAME.ssp`."""
    for path in folder.glob("*.ssp/"):
        content = path.rename(path.with_suffix(".folder"))
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(content.rglob("*")):
                archive.write(file, file.relative_to(content))
        shutil.rmtree(content)


def exit_code(command: str) -> object:
    """That of a command, also of one whose options are wrong."""
    try:
        return main(shlex.split(command))
    except SystemExit as ended:
        return ended.code


def contents(folder: Path) -> dict[Path, bytes]:
    """All files but those that are built."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path: path.read_bytes() for path in files if folder / "build" not in path.parents}


def expected(group: str) -> dict[str, str]:
    """The texts of a group, by the names of its cases."""
    path = FOLDER / f"{group}.txt"
    parts = HEAD.split(path.read_text("utf-8") if path.exists() else "")[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


@pytest.mark.parametrize("case", [case for group in GROUPS for case in cases(group)], ids=str)
def test_what_is_said(
    case: Case,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    request: pytest.FixtureRequest,
    good_files: Callable[[str], Path],
    c_fmu: Callable[[str], Path],
) -> None:
    folder = tmp_path / "f"
    shutil.copytree(good_files(case.group), folder)
    write_files(case.files, folder, c_fmu)
    for old, new in case.change.items():
        change_file(folder, old, new)
    pack(folder)
    monkeypatch.chdir(folder)
    capsys.readouterr()
    before = contents(folder)
    code = exit_code(case.command)
    assert code != 2 or contents(folder) == before  # what is refused leaves no trace
    said = VARYING.sub("…", USAGE.sub("", "".join(capsys.readouterr())))
    assert "Traceback" not in said
    said = f"exit {code}\n{said.replace(f'{folder}/', '').rstrip()}"
    texts = expected(case.group)
    if request.config.getoption("--update"):
        texts[case.name] = said
        names = [c.name for c in cases(case.group) if c.name in texts]
        text = "\n".join(f"== {name}\n{texts[name].rstrip()}\n" for name in names)
        (FOLDER / f"{case.group}.txt").write_text(text, "utf-8")
    assert said == texts.get(case.name, "").rstrip()


@pytest.mark.parametrize("group", GROUPS)
def test_every_text_has_its_case(group: str) -> None:
    assert list(expected(group)) == [case.name for case in cases(group)]


@pytest.mark.parametrize("group", [group for group in GROUPS if read_group(group).get("files")])
def test_the_good_files_are_good(
    group: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    good_files: Callable[[str], Path],
) -> None:
    shutil.copytree(good_files(group), tmp_path / "f")
    pack(tmp_path / "f")
    monkeypatch.chdir(tmp_path / "f")
    assert main(shlex.split(read_group(group)["command"])) == 0
