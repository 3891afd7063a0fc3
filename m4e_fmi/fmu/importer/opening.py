"""An FMU file before it is unpacked: whether it is an archive that may be."""

from __future__ import annotations

import hashlib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from m4e_fmi.errors import InputError, Problem, RunError, is_file, is_other, suggestion
from m4e_fmi.files.archives import opened_archive
from m4e_fmi.files.file_kinds import FMU, check_suffix
from m4e_fmi.files.xml_text import check_size, check_xml

MODEL_DESCRIPTION = "modelDescription.xml"
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"


def refusal(path: Path, message: str, remedy: str) -> InputError:
    """The error that says why an FMU file is of no use."""
    return InputError([Problem(message, remedy, str(path))])


def check_archive(path: Path) -> tuple[set[str], bytes]:
    """Names in the FMU at `path`, and its model description (bytes of the XML file).

    InputError if it is no readable archive with a model description, or should not be unpacked.
    """
    if path.is_dir():
        raise refusal(
            path, "is a folder, not an FMU", "name the .fmu file; unpacked ones are not read"
        )
    if is_other(path):
        raise refusal(path, "is a pipe or a device, not an FMU", "copy the FMU into a file")
    if not is_file(path):
        near = [p.name for p in path.parent.glob("*.fmu")] if path.parent.is_dir() else []
        raise refusal(path, "no such file", suggestion(path.name, near, "FMUs here"))
    if path.suffix.lower() in (".yaml", ".yml"):
        raise refusal(path, "this is YAML, not an FMU", "a model is a component as 'model: NAME'")
    check_suffix(path, FMU)
    with opened_archive(path, "an FMU", whole=True) as archive:
        names = set(archive.namelist())
        if MODEL_DESCRIPTION not in names:
            message = f"not an FMU: there is no {MODEL_DESCRIPTION} at the top of the archive"
            raise refusal(path, message, "pack the content of the folder, not the folder itself")
        inside = f"{path}/{MODEL_DESCRIPTION}"
        check_size(archive.getinfo(MODEL_DESCRIPTION).file_size, inside)
        text = archive.read(MODEL_DESCRIPTION)
    check_xml(text, inside)
    return names, text


def replaced(path: Path) -> RunError:
    """The error that says that another FMU has come to the place of one that was built or read."""
    remedy = "start again; runs of different systems at one time need build folders of their own"
    return RunError(f"{path}: was replaced by another FMU meanwhile", remedy)


@contextmanager
def opened(path: Path, content: str) -> Generator[BinaryIO, None, None]:
    """The FMU file at `path`, open for reading; RunError unless its SHA-256 is `content`, if given.

    So that an FMU is never used by the description of another that was at its place before.
    """
    with path.open("rb") as file:
        if content and hashlib.file_digest(file, "sha256").hexdigest() != content:
            raise replaced(path)
        file.seek(0)
        yield file
