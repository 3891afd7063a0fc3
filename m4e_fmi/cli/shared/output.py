"""Output to the terminal, the only place of it: no name can act on the terminal."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Generator, Iterable
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TextIO, cast

from m4e_fmi.shown import cleaned

_OWN = re.compile(r"\r(?:\x1b\[K)?")
"""Begins a line anew: of a counter or a progress bar, at the start of what is written."""
STANDARD_OUTPUT, STANDARD_ERROR = 1, 2
"""Numbers of these files."""


class Clean:
    """A text stream that cleans what is written to another one, and never fails to encode it.

    Work goes on, unheard, once the other one takes nothing any more: its reader has left, or the
    disk is full. The latter `complain` tells in the end, unless the stream is `spare`.
    """

    def __init__(self, stream: TextIO, name: str = "", *, spare: bool = False) -> None:
        self._stream, self._name = stream, name
        self._spare, self._why = spare, ""

    def write(self, text: str) -> int:
        """Write `text`, cleaned; the number of characters written."""
        own = _OWN.match(text)
        begin = own.end() if own else 0
        text = text[:begin] + cleaned(text[begin:])
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        try:
            return self._stream.write(text.encode(encoding, "replace").decode(encoding))
        except OSError as error:
            self._leave(error)
            return len(text)

    def flush(self) -> None:
        """Flush the other stream."""
        try:
            self._stream.flush()
        except OSError as error:
            self._leave(error)

    def _leave(self, error: OSError) -> None:
        """Let go to nowhere what is still to be written, also that which is buffered."""
        with suppress(OSError), Path(os.devnull).open("w") as nowhere:
            os.dup2(nowhere.fileno(), self._stream.fileno())
        if not (self._spare or isinstance(error, BrokenPipeError)):
            self._why = self._why or str(error.strerror or error)

    def complain(self) -> None:
        """OSError with the `name` of the stream if not all that was written has reached it."""
        self.flush()
        if self._why:
            raise OSError(f"{self._name} cannot be written: {self._why}")

    def writelines(self, lines: Iterable[str]) -> None:
        """Write each of `lines`, cleaned."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


@contextmanager
def clean_output() -> Generator[None]:
    """Standard output and error are cleaned during the block; they may be closed or unread."""
    before = sys.stdout, sys.stderr
    with ExitStack() as stack:
        if None in before:
            _take_closed()
        out, err = (
            stack.enter_context(Path(os.devnull).open("w", encoding="utf-8"))
            if one is None
            else one
            for one in before
        )
        sys.stdout = Clean(out, "the standard output")
        sys.stderr = Clean(err, spare=True)
        try:
            yield
        finally:
            sys.stdout, sys.stderr = before


@contextmanager
def alone() -> Generator[TextIO]:
    """The standard output for the caller alone: what others print goes to the standard error.

    Others are FMUs and Python code of users, here and in processes that are started meanwhile.
    """
    usual = own = sys.stdout
    with ExitStack() as stack:
        if _number(usual) == STANDARD_OUTPUT:
            usual.flush()
            kept = os.fdopen(os.dup(STANDARD_OUTPUT), "w", encoding=usual.encoding)
            stack.callback(_given_back, kept)
            os.dup2(STANDARD_ERROR, STANDARD_OUTPUT)
            own = cast("TextIO", Clean(kept, "the standard output"))
        sys.stdout = sys.stderr
        try:
            yield own
        finally:
            sys.stdout = usual
        if isinstance(own, Clean):
            own.complain()


def _number(stream: TextIO) -> int:
    """The number of the file of a stream, -1 if it has none."""
    try:
        return stream.fileno()
    except (AttributeError, OSError, ValueError):
        return -1


def _given_back(kept: TextIO) -> None:
    """Let the standard output lead to where `kept` does, and close that."""
    os.dup2(kept.fileno(), STANDARD_OUTPUT)
    with suppress(OSError):
        kept.close()


def _take_closed() -> None:
    """Let standard streams that were closed lead nowhere.

    The next file would have the number of one, and what an FMU prints would go into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # has the lowest number that is free
