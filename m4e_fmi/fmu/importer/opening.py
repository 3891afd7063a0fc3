"""An FMU file before it is unpacked: whether it is an archive that may be."""

from __future__ import annotations

import hashlib
import lzma
import zipfile
import zlib
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO
from xml.parsers import expat

from m4e_fmi.errors import InputError, Problem, RunError, suggestion
from m4e_fmi.files.file_kinds import FMU, check_suffix

MODEL_DESCRIPTION = "modelDescription.xml"
MAX_UNPACKED = 2**31
"""Bytes that an FMU may unpack to."""
MAX_RATIO = 200
"""Unpacked over packed size above which an archive of more than SMALL bytes is taken for a bomb."""
SMALL = 10_000_000
MAX_DESCRIPTION = 50_000_000
"""Bytes of a model description that is read."""
LONGEST_NAME = 255
"""Bytes of the name of a file or folder, beyond which no usual file system takes it."""


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
    if not path.is_file():
        near = [p.name for p in path.parent.glob("*.fmu")] if path.parent.is_dir() else []
        raise refusal(path, "no such file", suggestion(path.name, near, "FMUs here"))
    if path.suffix.lower() in (".yaml", ".yml"):
        raise refusal(path, "this is YAML, not an FMU", "a model is a component as 'model: NAME'")
    check_suffix(path, FMU)
    try:
        with zipfile.ZipFile(path) as archive:
            infos = archive.infolist()
            check_entries(path, archive)
            if MODEL_DESCRIPTION not in archive.namelist():
                message = f"not an FMU: there is no {MODEL_DESCRIPTION} at the top of the archive"
                raise refusal(
                    path, message, "pack the content of the folder, not the folder itself"
                )
            size = archive.getinfo(MODEL_DESCRIPTION).file_size
            if size > MAX_DESCRIPTION:
                message = f"{MODEL_DESCRIPTION} has {size / 1e6:.0f} MB"
                limit = f"{MAX_DESCRIPTION / 1e6:.0f} MB are read at most: export fewer variables"
                raise refusal(path, message, limit)
            text = archive.read(MODEL_DESCRIPTION)
            if has_doctype(text):
                message = f"{MODEL_DESCRIPTION} has a DOCTYPE, which FMI does not use"
                raise refusal(path, message, "do not use this file unless you know why it has one")
    except (
        zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, OSError, RuntimeError, ValueError
    ) as error:  # fmt: skip
        remedy = "copy or export the file again: it is truncated, or was never an FMU"
        raise refusal(path, f"not a readable ZIP archive: {error}", remedy) from error
    return {info.filename for info in infos}, text


def has_doctype(text: bytes) -> bool:
    """True if XML has a DOCTYPE, in whatever encoding; False where it cannot be read so far."""
    found: list[str] = []
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = lambda name, *_: found.append(name)

    def root(*_: object) -> None:
        raise StopIteration  # all that may come before it has been read

    parser.StartElementHandler = root
    with suppress(StopIteration, expat.ExpatError, LookupError, ValueError):
        parser.Parse(text, True)
    return bool(found)


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


def check_entries(path: Path, archive: zipfile.ZipFile) -> None:
    """InputError if an archive should not be unpacked: see `read_description`."""
    distrust = "do not use this file: no tool that exports FMUs writes such an archive"
    infos = archive.infolist()
    for info in infos:
        name = info.filename
        if "\\" in name:
            remedy = "only / may stand between folders (FMI 2.0.4, section 2.3): pack it again"
            raise refusal(path, f"the archive holds {name!r}, a path with backslashes", remedy)
        if max(len(part.encode(errors="replace")) for part in name.split("/")) > LONGEST_NAME:
            remedy = "give its files shorter names"
            raise refusal(path, f"the archive holds a name of {len(name)} characters", remedy)
        if ":" in name or name.startswith("/") or ".." in name.split("/"):
            raise refusal(
                path, f"the archive holds {name!r}, which leads out of its folder", distrust
            )
    unpacked = sum(info.file_size for info in infos)
    packed = max(1, sum(info.compress_size for info in infos))
    if unpacked > MAX_UNPACKED or (unpacked > SMALL and unpacked / packed > MAX_RATIO):
        size = f"{unpacked / 1e6:.0f} MB from {packed / 1e6:.2f} MB"
        raise refusal(path, f"the archive would unpack to {size}", distrust)
    _check_twins(path, archive)


def _check_twins(path: Path, archive: zipfile.ZipFile) -> None:
    """InputError where two entries of one name differ: nobody can tell which one is meant.

    Some tools pack a folder twice; entries that are the same do no harm.
    """
    known: dict[str, zipfile.ZipInfo] = {}
    for info in archive.infolist():
        first = known.setdefault(info.filename, info)
        if first is not info and (
            (first.file_size, first.CRC) != (info.file_size, info.CRC)
            or archive.read(first) != archive.read(info)
        ):
            message = f"the archive holds {info.filename!r} twice, with different contents"
            raise refusal(path, message, "pack it again, with one of them")
