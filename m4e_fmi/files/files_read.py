"""Reading files, and a record of which were read: the sources that a result was made from.

Readers of models and configurations use `read_bytes` and `read_text`, and call `depends_on` for a
file that a library reads for them, or whose appearance would change the result. `files_read`
collects them with hashes of their contents, so that every change is noticed whatever the time
stamps say.
"""

from __future__ import annotations

import errno
import hashlib
import io
import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

ABSENT = None
UNREADABLE = "unreadable"
CHANGING = "changing"

Files = dict[str, str | None]
"""Absolute path → SHA-256 of the content; ABSENT for a file that is not there."""

_collections: list[Files] = []


@contextmanager
def files_read() -> Generator[Files]:
    """Collects the files that are read meanwhile in this process, in all its threads."""
    found: Files = {}
    _collections.append(found)
    try:
        yield found
    finally:
        _collections[:] = [each for each in _collections if each is not found]


class TooLongError(Exception):
    """The file is longer than the limit for reading."""


def opened(path: str | Path) -> io.BufferedReader:
    """A file, open for reading. OSError for a pipe in a folder, which nobody may ever write to.

    The pipes of a shell, as in ``m4e-fmi info <(program)``, have no place in a folder.
    """
    if Path(os.path.realpath(path)).is_fifo():
        raise OSError(errno.ESPIPE, "it is a pipe, not a file", str(path))
    return Path(path).open("rb")


def read_bytes(path: str | Path, *, largest: int | None = None) -> bytes:
    """Content of a file; OSError if it cannot be read, TooLongError beyond `largest` bytes."""
    with opened(path) as file:  # the size of a device is not known before
        content = file.read(-1 if largest is None else largest + 1)
    if largest is not None and len(content) > largest:
        raise TooLongError(f"is longer than {largest / 1e6:g} MB")
    _note(path, hashlib.sha256(content).hexdigest())
    return content


def read_text(path: str | Path, encoding: str = "utf-8", *, largest: int | None = None) -> str:
    """Text of a file, its lines ended by a newline; as `read_bytes`, and UnicodeDecodeError."""
    content = read_bytes(path, largest=largest)
    return io.TextIOWrapper(io.BytesIO(content), encoding=encoding).read()


def depends_on(path: str | Path) -> None:
    """Note a file, to be called before anything reads it or asks whether it is there."""
    _note(path, file_hash(path))


def file_hash(path: str | Path) -> str | None:
    """SHA-256 (hexadecimal) of a file's content; ABSENT, or UNREADABLE if it is there all the same.

    A folder is not a file: ABSENT.
    """
    try:
        with opened(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return ABSENT
    except OSError:
        return ABSENT if Path(path).is_dir() else UNREADABLE


def are_unchanged(files: Files) -> bool:
    """True if all files are as they were when they were collected."""
    return all(file_hash(path) == content for path, content in files.items())


def _note(path: str | Path, content: str | None) -> None:
    name = str(Path(path).absolute())  # without resolving links: another target is another content
    for files in _collections:
        if files.setdefault(name, content) != content:
            files[name] = CHANGING  # between two readings: no content is equal to this
