"""Files that appear whole or not at all, and errors with a remedy where they cannot be written."""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import re
import shutil
import sys
import time
import uuid
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    from netCDF4 import Dataset

PROBE = 2**18
"""Bytes: more than what is left of a disk on which a block of results did not fit, usually."""
OLD = 86400.0
"""Seconds after which a part of a file is left over, whoever writes it."""
_PATIENCE = 2.0
"""Seconds that a file which is open elsewhere gets; Windows does not replace one."""
_NUMBERS = Path("/proc/self/ns/pid")
"""Linux: tells apart containers on one machine, each with numbers of processes of its own."""
_SPACE = str(_NUMBERS.readlink()) if _NUMBERS.is_symlink() else ""
_HOST = hashlib.sha256(f"{platform.node()}{_SPACE}".encode()).hexdigest()[:8]
_PART = re.compile(r"\.part-([0-9a-f]{8})-(\d+)-")
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_FORBIDDEN = (errno.EROFS, errno.EACCES, errno.EPERM)
_REMEDIES = {
    **dict.fromkeys(_FULL, "free disk space, or write elsewhere"),
    **dict.fromkeys(_FORBIDDEN, "choose a folder that you may write to"),
}


def check_suffix(path: str | Path, suffixes: Sequence[str], what: str) -> None:
    """InputError unless `path` ends in one of `suffixes`, in any case; `what` is written there."""
    suffix = Path(path).suffix
    if suffix.lower() not in suffixes:
        *others, last = suffixes
        form = repr(suffix) if suffix else "a file without a suffix"
        remedy = f"use {', '.join(others)} or {last}" if others else f"use {last}"
        raise InputError.single(f"{what} cannot be written as {form}", remedy, str(path))


@contextmanager
def written(path: str | Path) -> Generator[Path]:
    """A file to write, with the suffix and folder of `path`, which it replaces after the block.

    Missing folders are made. RunError, and no file, if it cannot be written.
    """
    path = Path(path)
    part = path.with_name(f"{part_prefix()}{uuid.uuid4().hex}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file():  # a device would be replaced by a file
            raise FileExistsError(errno.EEXIST, "it is not a regular file")
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        yield part
        _replace(path, part)
    except OSError as error:
        raise cannot_write(path, error) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def part_prefix() -> str:
    """Prefix of the names of files and folders that this process writes before it renames them."""
    return f".part-{_HOST}-{os.getpid()}-"


def remove_leftovers(folder: Path) -> None:
    """Remove unfinished files from `folder` that killed processes have left there.

    These are the files of processes of this machine that have ended, and all that are `OLD`.
    """
    for part in folder.glob(".part-*"):
        found = _PART.match(part.name)
        with suppress(OSError):
            if found and (_has_ended(*found.groups()) or part.stat().st_mtime < time.time() - OLD):
                shutil.rmtree(part) if part.is_dir() else part.unlink()


def _has_ended(host: str, process: str) -> bool:
    if host != _HOST or int(process) == os.getpid():
        return False
    if sys.platform == "win32":
        return True  # Windows removes no file that is open
    try:
        os.kill(int(process), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:  # somebody else's
        return False
    return False


def _replace(path: Path, part: Path) -> None:
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            part.replace(path)
            return
        except PermissionError:
            if sys.platform != "win32" or time.monotonic() > end:
                raise
            time.sleep(0.05)


def cannot_write(path: Path, error: Exception) -> RunError:
    """The error to raise when writing `path` failed with `error`."""
    cause = _plain_cause(path) or error  # netCDF gives others
    why = getattr(cause, "strerror", None) or cause
    remedy = _REMEDIES.get(getattr(cause, "errno", 0), "choose another file")
    return RunError(f"{path}: cannot be written: {why}", remedy)


def _plain_cause(path: Path) -> OSError | None:
    """Why a plain file beside `path` cannot be written; None if it can, or there is no folder."""
    if not path.parent.is_dir():
        return None
    probe = path.with_name(f"{part_prefix()}{uuid.uuid4().hex}")
    try:
        probe.write_bytes(bytes(PROBE))
    except OSError as error:
        return error
    finally:
        with suppress(OSError):
            probe.unlink(missing_ok=True)
    return None


@contextmanager
def netcdf(path: Path) -> Generator[Dataset]:
    """A new netCDF-4 file, open; OSError where netCDF's library fails."""
    from netCDF4 import Dataset

    with PROCESS:
        file = Dataset(path, "w", format="NETCDF4")
        try:
            yield file
            file.close()
        except RuntimeError as error:  # what netCDF4 makes of a full disk
            raise OSError(str(error)) from error
        finally:
            if file.isopen():
                with suppress(RuntimeError):
                    file.close()
