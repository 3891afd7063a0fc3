"""Lines of a command: on the terminal, and as events for programs.

All go through one logger; options choose where it leads:

- people read standard output (progress, results) and standard error (notes, warnings, errors);
  `--quiet` leaves warnings and errors;
- `--events` has one JSON object on a line of standard output, in place of the lines for people.
"""

from __future__ import annotations

import logging
import re
import sys
from collections.abc import Iterable
from pathlib import Path

from m4e_fmi.cli.shared.events import Event, Written
from m4e_fmi.shown import one_line

LOG = logging.getLogger("m4e_fmi.command")
LOG.propagate = False
LOG.setLevel(1)
PROGRESS = 5
"""Level of records that only programs get."""
_COUNTING = re.compile(r"(\d+) of (\d+)$")
_WARNING = re.compile(r"(^|: )warning\b")


def say(text: str) -> None:
    """Tell a line of progress; one that counts ("… 3 of 40") overwrites itself on a terminal."""
    text = one_line(text)
    _tell(logging.WARNING if _WARNING.search(text) else logging.INFO, text, counting=True)


def count(text: str) -> None:
    """Tell progress that counts beside a result, on a terminal's standard error only."""
    if sys.stderr.isatty() and _COUNTING.search(text):
        _tell(logging.INFO, one_line(text), beside=True, counting=True)


def show(text: str, event: Event | None = None) -> None:
    """Tell a result, of one line or more; programs get the `event` if there is one."""
    _tell(logging.INFO, text, event=event)


def note(text: str) -> None:
    """Tell a line beside the result, on standard error."""
    _tell(logging.INFO, one_line(text), beside=True)


def warn(text: str) -> None:
    """Tell a warning, or a message of an FMU, on standard error."""
    _tell(logging.WARNING, one_line(text), beside=True)


def fail(text: str, event: Event) -> None:
    """Tell an error, of one line or more, on standard error."""
    _tell(logging.ERROR, text, beside=True, event=event)


def tell_event(event: Event) -> None:
    """Tell programs an event that people get no line of."""
    _tell(PROGRESS, "", event=event)


def print_files(paths: Iterable[Path]) -> None:
    """Tell the paths of files that were written."""
    for path in paths:
        show(f"wrote {path}", Written(str(path)))


def _tell(
    level: int,
    text: str,
    *,
    beside: bool = False,
    counting: bool = False,
    event: Event | None = None,
) -> None:
    found = _COUNTING.search(text) if counting else None
    number = (int(found[1]), int(found[2])) if found else None
    LOG.log(level, text, extra={"beside": beside, "number": number, "event": event})
