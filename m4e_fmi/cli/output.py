"""The one place where text leaves for the terminal: nothing in a name can act on it."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

_OWN = re.compile(r"\r(?:\x1b\[K)?")
"""Begins a line anew: of a counter or a progress bar, at the start of what is written."""
_ACTING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters but tab and line feed
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # direction of writing
    "\u2028\u2029\ufeff\ud800-\udfff\U000e0000-\U000e007f]"  # lines, marks, halves, tags
)


def cleaned(text: str) -> str:
    """`text` with U+FFFD in place of each character that acts on a terminal."""
    return _ACTING.sub("\ufffd", text)


class Clean:
    """A text stream that cleans what is written to another one, and never fails to encode it.

    Work goes on, unheard, once the reader of the other one has left; of one that is `spare`, also
    once it takes nothing for another reason.
    """

    def __init__(self, stream: Any, *, spare: bool = False) -> None:
        self._stream = stream
        self._lost = OSError if spare else BrokenPipeError

    def write(self, text: str) -> int:
        own = _OWN.match(text)
        begin = own.end() if own else 0
        text = text[:begin] + cleaned(text[begin:])
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        try:
            return self._stream.write(text.encode(encoding, "replace").decode(encoding))
        except self._lost:
            self._leave()
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except self._lost:
            self._leave()

    def _leave(self) -> None:
        """Let go to nowhere what is still to be written, also that which is buffered."""
        with suppress(OSError), Path(os.devnull).open("w") as nowhere:
            os.dup2(nowhere.fileno(), self._stream.fileno())

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def clean_output() -> Iterator[None]:
    """Within it, standard output and standard error are cleaned, and nobody need read them."""
    before = sys.stdout, sys.stderr
    sys.stdout = before[0] and Clean(before[0])
    sys.stderr = before[1] and Clean(before[1], spare=True)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
