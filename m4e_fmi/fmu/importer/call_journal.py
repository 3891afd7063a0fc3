"""The call an FMU was given last, written down where it outlives the process that made it."""

from __future__ import annotations

import mmap
import struct
from pathlib import Path
from typing import NamedTuple

_SIZE = 512
_HEAD = struct.Struct("<Q?")


class Journal:
    """The file at `path` holds the number and the text of the last call.

    `occasion` says what the calls are made with, and stands after each; "" says nothing. `unasked`
    marks calls that the standard forbids importers to make.
    """

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(_SIZE))
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), _SIZE)
        self._number = 0
        self.occasion = ""
        self.unasked = False

    def write(self, call: str) -> None:
        """Write a call down as the last one."""
        self._number += 1
        call += f" with {self.occasion}" if self.occasion else ""
        text = call.encode("ascii", "backslashreplace")[: _SIZE - _HEAD.size]
        self._map[:] = (_HEAD.pack(self._number, self.unasked) + text).ljust(_SIZE, b"\0")


class Call(NamedTuple):
    """A call in the journal: its number, its text, and whether no importer may make it."""

    number: int
    text: str
    unasked: bool


def last_call(path: Path) -> Call:
    """The last call in the journal at `path`; number 0 and "" before the first."""
    try:
        content = path.read_bytes()
    except OSError:
        content = b""
    if len(content) < _SIZE:
        return Call(0, "", False)
    text = content[_HEAD.size :].rstrip(b"\0").decode("ascii", "replace")
    number, unasked = _HEAD.unpack_from(content)
    return Call(number, text, unasked)
