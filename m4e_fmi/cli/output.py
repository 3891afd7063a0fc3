"""The one place where text leaves for the terminal: nothing in a name can act on it."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
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
    """A text stream that cleans what is written to another one, and never fails to encode it."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        own = _OWN.match(text)
        begin = own.end() if own else 0
        text = text[:begin] + cleaned(text[begin:])
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        return self._stream.write(text.encode(encoding, "replace").decode(encoding))

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def clean_output() -> Iterator[None]:
    """Within it, standard output and standard error are cleaned."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (None if s is None else Clean(s) for s in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
