"""The call an FMU was given last, written down where it outlives the process that made it."""

from __future__ import annotations

import mmap
import struct
from pathlib import Path

_SIZE = 512
_NUMBER = struct.Struct("<Q")


class Journal:
    """The file at `path` holds the number and the text of the last call.

    `occasion` says what the calls are made with, and stands after each; "" says nothing.
    """

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(_SIZE))
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), _SIZE)
        self._number = 0
        self.occasion = ""

    def write(self, call: str) -> None:
        self._number += 1
        call += f" with {self.occasion}" if self.occasion else ""
        text = call.encode("ascii", "backslashreplace")[: _SIZE - _NUMBER.size]
        self._map[:] = (_NUMBER.pack(self._number) + text).ljust(_SIZE, b"\0")


def last_call(path: Path) -> tuple[int, str]:
    """Number and text of the last call in the journal at `path`; 0 and "" before the first."""
    try:
        content = path.read_bytes()
    except OSError:
        content = b""
    if len(content) < _SIZE:
        return 0, ""
    text = content[_NUMBER.size :].rstrip(b"\0").decode("ascii", "replace")
    return _NUMBER.unpack_from(content)[0], text
