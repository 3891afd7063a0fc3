"""Temporary folders that the next process removes if this one is killed.

They are in one folder per process, named by a token. The process holds a lock file with the same
token while it lives; its number would not do, as another process may have it by now.
"""

from __future__ import annotations

import errno
import itertools
import os
import re
import shutil
import tempfile
import threading
import uuid
import weakref
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.files.locks import PATIENCE, Lock
from m4e_fmi.signals import held

PREFIX = "m4e_fmi_"
_OWNED = re.compile(rf"{PREFIX}([0-9a-f]{{32}})(\.lock)?$")


@dataclass
class _Place:
    """The folder of this process in another, with `count` temporary ones in it."""

    folder: Path
    lock: Lock
    count: int = 0
    numbers: Iterator[int] = field(default_factory=itertools.count)


_places: dict[tuple[Path, int], _Place] = {}
"""By folder and process: a forked one has none."""
_changing = threading.RLock()  # the garbage collector may remove one meanwhile


class TemporaryFolder:
    """A new empty folder at `path`, in `parent` (the system's for temporary files if None).

    It is removed with its contents: by `remove`, at the end of a ``with`` block or of the
    interpreter, or when another process makes one in `parent` after this one was killed. OSError if
    it cannot be made.
    """

    def __init__(self, parent: Path | None = None) -> None:
        parent = (parent or Path(tempfile.gettempdir())).absolute()
        with held(), _changing:
            place = _place(parent)
            place.count += 1
            try:
                self.path = place.folder / str(next(place.numbers))
                place.folder.mkdir(mode=0o700, exist_ok=True)  # others may have tidied up
                self.path.mkdir(mode=0o700)
            except OSError:
                place.count -= 1
                _leave(parent)
                raise
            self._finalizer = weakref.finalize(self, _remove, self.path, os.getpid())

    def remove(self) -> None:
        """Remove the folder and all files that can be removed."""
        self._finalizer()

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_: object) -> None:
        self.remove()


def _place(parent: Path) -> _Place:
    """The place of this process in `parent`; a new one removes those of dead processes first."""
    key = parent, os.getpid()
    if key not in _places:
        _sweep(parent)
        folder = parent / f"{PREFIX}{uuid.uuid4().hex}"
        lock = Lock.take(folder.with_suffix(".lock"), patience=PATIENCE)
        if lock is None:
            raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN), str(parent))
        _places[key] = _Place(folder, lock)
    return _places[key]


def _leave(parent: Path) -> None:
    """Give the place up if there is no folder in it."""
    key = parent, os.getpid()
    if _places[key].count == 0:
        place = _places.pop(key)
        shutil.rmtree(place.folder, ignore_errors=True)
        place.lock.release()


def _remove(folder: Path, process: int) -> None:
    if process != os.getpid():  # forked: it is the other's
        return
    with held():
        shutil.rmtree(folder, ignore_errors=True)
        with _changing:
            parent = folder.parent.parent
            _places[parent, process].count -= 1
            _leave(parent)


def _sweep(parent: Path) -> None:
    own = {place.folder for place in _places.values()}
    with suppress(OSError):
        found = [path for path in parent.glob(f"{PREFIX}*") if _OWNED.match(path.name)]
        for folder in {path.with_suffix("") for path in found} - own:
            lock = Lock.take(folder.with_suffix(".lock"), sure=True)
            if lock:
                shutil.rmtree(folder, ignore_errors=True)
                lock.release()
