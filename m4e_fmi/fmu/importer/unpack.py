"""Folders that FMUs are unpacked into: plain ASCII paths, removed afterwards whatever happens."""

from __future__ import annotations

import errno
import re
import tempfile
from pathlib import Path

import fmpy
import platformdirs

from m4e_fmi.errors import M4eError, RunError
from m4e_fmi.files.archives import ERRORS
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.fmu.importer.opening import opened, refusal

# FMUs get this path as a percent-encoded URI, which some cannot decode and crash
_PLAIN = re.compile(r"[A-Za-z0-9_./\\:-]+$")


class Unpacked:
    """The content of an FMU in a folder of its own, until `remove` or the interpreter's end.

    `content` is the SHA-256 of the file as it was read before; "" for one that was not.
    """

    def __init__(self, fmu: Path, content: str = "") -> None:
        try:
            self._temporary = TemporaryFolder(_plain_folder())
        except OSError as error:
            remedy = "free disk space, or set TMPDIR to another folder"
            raise RunError(f"{fmu}: no folder to unpack it into: {error}", remedy) from error
        self.folder = self._temporary.path
        try:
            with opened(fmu, content) as file:
                fmpy.extract(file, self.folder)  # type: ignore[arg-type]  what zipfile takes
        except RunError:
            self.remove()
            raise
        except ERRORS as error:
            self.remove()
            raise _cannot_unpack(fmu, error) from error

    def remove(self) -> None:
        """Remove the folder."""
        self._temporary.remove()


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
