"""The call an FMU was given last, written down where it outlives the process that made it."""

from __future__ import annotations

import mmap
import struct
from pathlib import Path

_SIZE = 512
_HEAD = struct.Struct("<Q")


class CallJournal:
    """The file at `path` holds the number and the text of the last call."""

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(_SIZE))
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), _SIZE)
        self._number = 0

    def write(self, call: str) -> None:
        """Write a call down as the last one."""
        self._number += 1
        text = call.encode("ascii", "backslashreplace")[: _SIZE - _HEAD.size]
        self._map[:] = (_HEAD.pack(self._number) + text).ljust(_SIZE, b"\0")


def last_call(path: Path) -> tuple[int, str]:
    """Number and text of the last call in the journal at `path`; 0 and "" before the first."""
    content = path.read_bytes() if path.exists() else b""
    if len(content) < _SIZE:
        return 0, ""
    text = content[_HEAD.size :].rstrip(b"\0").decode("ascii", "replace")
    return _HEAD.unpack_from(content)[0], text
