"""FMU files: checked before they are unpacked, into folders that are removed whatever happens.

Also the remedies for libraries in them that cannot be loaded.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from itertools import count
from pathlib import Path
from typing import BinaryIO

import fmpy
import platformdirs

from m4e_fmi.errors import (
    InputError,
    M4eError,
    Problem,
    RunError,
    is_file,
    is_other,
    suggestion,
)
from m4e_fmi.files.archives import ERRORS, opened_archive
from m4e_fmi.files.file_kinds import FMU, check_suffix
from m4e_fmi.files.locks import TemporaryFolder
from m4e_fmi.files.xml_text import check_size, check_xml
from m4e_fmi.signals import held

MODEL_DESCRIPTION = "modelDescription.xml"
# FMUs get this path as a percent-encoded URI, which some cannot decode and crash
_PLAIN = re.compile(r"[A-Za-z0-9_./\\:-]+$")
_MISSING = re.compile(
    r"([^\s/:]+): cannot open shared object file|Library not loaded: (?:\S*/)?(\S+)"
)
"""Words of the loaders of Linux and macOS; that of Windows does not name the library."""
_SYMBOL = re.compile(r"(?:undefined symbol: |ymbol not found\D*?[:'] ?'?)(\w+)")


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


_numbers = count()


@cache
def _folder_of(process: int, parent: Path) -> TemporaryFolder:  # noqa: ARG001  one each
    """The folder in `parent` into which a process unpacks its FMUs."""
    return TemporaryFolder(parent)


class Unpacked:
    """The content of an FMU in a folder of its own, until `remove` or the interpreter's end.

    `content` is the SHA-256 of the file as it was read before; "" for one that was not.
    """

    def __init__(self, fmu: Path, content: str = "") -> None:
        self._process = os.getpid()
        try:
            above = _folder_of(self._process, _plain_folder()).path
            self.folder = above / str(next(_numbers))
            self.folder.mkdir(parents=True)  # somebody may have cleaned up
        except OSError as error:
            remedy = "free disk space, or set TMPDIR to another folder"
            raise RunError(f"{fmu}: no folder to unpack it into: {error}", remedy) from error
        try:
            with opened(fmu, content) as file:
                fmpy.extract(file, self.folder)
        except RunError:
            self.remove()
            raise
        except ERRORS as error:
            self.remove()
            raise _cannot_unpack(fmu, error) from error

    def remove(self) -> None:
        """Remove the folder, but not from a process that was forked meanwhile."""
        if self._process == os.getpid():
            with held():
                shutil.rmtree(self.folder, ignore_errors=True)


def _cannot_unpack(fmu: Path, error: Exception) -> M4eError:
    """The error by its cause: the disk, the file names, or the archive itself."""
    number = getattr(error, "errno", None)
    message = f"cannot be unpacked: {error}"
    if number in (errno.ENAMETOOLONG, errno.EINVAL, errno.ENOENT):
        return refusal(fmu, message, "give the files in it shorter and plainer names")
    if number == errno.EFBIG:
        return RunError(
            f"{fmu}: {message}", "free disk space, or raise the limit of file sizes (ulimit -f)"
        )
    if isinstance(error, OSError):
        return RunError(f"{fmu}: {message}", "free disk space, or set TMPDIR to another folder")
    return refusal(fmu, message, "copy or export the file again: it is damaged")


def _plain_folder() -> Path:
    """An existing folder for temporary files whose path has no character beyond plain ASCII."""
    candidates = [
        Path(tempfile.gettempdir()),
        platformdirs.user_cache_path("m4e_fmi"),
        Path("/tmp"),
        Path("/var/tmp"),
    ]
    for folder in candidates:
        if _PLAIN.match(str(folder)):
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError:
                continue
            return folder
    tried = ", ".join(str(folder) for folder in candidates)
    remedy = "set TMPDIR to an existing folder with only letters, digits, '_', '-' and '.'"
    raise RunError(f"no folder with a plain ASCII path to unpack FMUs into (tried {tried})", remedy)


def remedy_for(why: str, version: str) -> str:
    """The remedy where an FMU's library is not loaded, by the loader's words.

    `version` is that of FMI.
    """
    found, symbol = _MISSING.search(why), _SYMBOL.search(why)
    if symbol and "fmi" not in symbol[1]:
        return (
            f"none of the libraries that it needs has {symbol[1]}: one of them is of another "
            "version here, or the FMU was linked without it; ask the FMU's author"
        )
    if not found:
        return f"a library it needs is missing, or it is not an FMI {version} binary"
    name = found[1] or found[2]
    return (
        f"install the package of your system that has {name}, which the FMU needs (on Debian and "
        f"Ubuntu `apt-file search {name}` finds it), or ask the FMU's author for one without"
    )
