"""Locks of the operating system, which end with the process that holds them, however it ends.

`claimed` is for files that a process writes for as long as it runs: nobody else may write them
meanwhile. It also removes the hidden files that dead processes have left beside them.

Temporary folders are removed by the next process if this one is killed. Each is named by a token.
The process holds a lock file with the same token while it lives; its number would not do, as
another process may have it by now.
"""

from __future__ import annotations

import errno
import os
import platform
import re
import shutil
import sys
import tempfile
import threading
import time
import uuid
import weakref
from collections.abc import Generator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from m4e_fmi.errors import RunError
from m4e_fmi.files.writing import cannot_write, remove_leftovers
from m4e_fmi.signals import held

LOCK, ROWS = ".m4e-lock", ".m4e-rows"
"""Suffixes of hidden files beside results: their lock, and their rows until the first step is
made."""
_BYTE = 2**30
"""The byte of the file that is locked, far behind its text: Windows lets nobody read it."""
_TRIALS = 100
PATIENCE, PAUSE = 0.5, 0.01
"""Seconds for which a lock is waited for that may be held for a moment only, and between trials."""
_HOST = platform.node()

_held: dict[Path, int] = {}
"""Lock files of this process, and the threads that hold them."""
PREFIX = "m4e_fmi_"
_OWNED = re.compile(rf"{PREFIX}([0-9a-f]{{32}})(\.lock)?$")


class Lock:
    """A lock file that this process holds, until `release` or its end; see `Lock.take`."""

    def __init__(self, path: Path, descriptor: int) -> None:
        self.path, self._descriptor = path, descriptor

    @classmethod
    def take(cls, path: Path, *, patience: float = 0.0, sure: bool = False) -> Lock | None:
        """The lock at `path`, with this process's number and machine in the file.

        None if another holds it for longer than `patience` [s]: processes that clean up after dead
        ones hold any lock for a moment. On a file system without locks, other holders are unknown:
        the lock is given, or None if it must be `sure`. OSError if the file cannot be
        made.
        """
        until = time.monotonic() + patience
        for _ in range(_TRIALS):
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            locked = _locked(descriptor)
            if locked or (locked is None and not sure):
                with suppress(FileNotFoundError):  # its holder may have removed it in the meantime
                    if os.path.samestat(os.fstat(descriptor), path.stat()):
                        with suppress(OSError):  # a full disk
                            os.ftruncate(descriptor, 0)
                            os.write(descriptor, f"process {os.getpid()} on {_HOST}".encode())
                        return cls(path, descriptor)
                os.close(descriptor)
                continue
            os.close(descriptor)
            if time.monotonic() >= until:
                return None
            time.sleep(PAUSE)
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    def release(self) -> None:
        """Remove the file, and let others have the lock."""
        if sys.platform == "win32":  # open files cannot be removed there
            os.close(self._descriptor)
            with suppress(OSError):
                self.path.unlink()
        else:
            with suppress(OSError):
                self.path.unlink()
            os.close(self._descriptor)


def _locked(descriptor: int) -> bool | None:
    """Lock an open file; False if another has it, None if the file system has no locks."""
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, _BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        os.lseek(descriptor, 0, os.SEEK_SET)
        return True
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


@contextmanager
def claimed(path: str | Path) -> Generator[Path]:
    """The absolute form of `path`, which nobody else writes during the block.

    RunError, which names the process, if another one (or another thread) has claimed it; or if
    no file can be made in its folder. A missing folder is made. Within the block the same
    thread may claim it again.
    """
    place = Path(path).resolve()
    file = place.with_name(f".{place.name}{LOCK}")
    if _held.get(file) == threading.get_ident():
        yield place
        return
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        lock = Lock.take(file, patience=PATIENCE)
    except OSError as error:
        raise cannot_write(Path(path), error) from error
    if lock is None:
        holder = ""
        with suppress(OSError, UnicodeDecodeError):
            holder = file.read_text(encoding="utf-8")
        raise RunError(
            f"{path}: another run writes it ({holder or 'its process is not known'})",
            "wait for its end, or choose another file with --output-file",
        )
    _held[file] = threading.get_ident()
    try:
        _remove_rows(place)
        _sweep(place.parent)
        yield place
    finally:
        _remove_rows(place)
        del _held[file]
        lock.release()


def _remove_rows(place: Path) -> None:
    with suppress(OSError):
        place.with_name(f".{place.name}{ROWS}").unlink(missing_ok=True)


def _sweep(folder: Path) -> None:
    """Remove files that dead processes have left in a folder of results."""
    remove_leftovers(folder)
    with suppress(OSError):
        for file in folder.glob(f".*{LOCK}"):
            if file in _held:
                continue
            lock = Lock.take(file, sure=True)
            if lock is not None:
                _remove_rows(file.with_name(file.name.removeprefix(".").removesuffix(LOCK)))
                lock.release()


class TemporaryFolder:
    """A new empty folder at `path`, in `parent` (the system's for temporary files if None).

    It is removed with its contents: by `remove`, at the end of a ``with`` block or of the
    interpreter, or when another process makes its first in `parent` after this one was killed.
    OSError if it cannot be made.
    """

    def __init__(self, parent: Path | None = None) -> None:
        parent = (parent or Path(tempfile.gettempdir())).absolute()
        self.path = parent / f"{PREFIX}{uuid.uuid4().hex}"
        with held():
            _remove_dead(parent)
            lock = Lock.take(self.path.with_suffix(".lock"), patience=PATIENCE)
            if lock is None:
                raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN), str(parent))
            self._finalizer = weakref.finalize(self, _remove, self.path, lock, os.getpid())
            try:
                self.path.mkdir(mode=0o700)
            except OSError:
                self.remove()
                raise

    def remove(self) -> None:
        """Remove the folder, as far as its files can be removed."""
        with held():
            self._finalizer()

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_: object) -> None:
        self.remove()


def _remove(folder: Path, lock: Lock, process: int) -> None:
    if process == os.getpid():  # else it is that of the process that this one was forked from
        with held():
            shutil.rmtree(folder, ignore_errors=True)
            lock.release()


@cache
def _remove_dead(parent: Path) -> None:
    """Remove the folders of dead processes, once."""
    found = [path for path in parent.glob(f"{PREFIX}*") if _OWNED.match(path.name)]
    for folder in {path.with_suffix("") for path in found}:
        with suppress(OSError):
            lock = Lock.take(folder.with_suffix(".lock"), sure=True)
            if lock:
                shutil.rmtree(folder, ignore_errors=True)
                lock.release()
