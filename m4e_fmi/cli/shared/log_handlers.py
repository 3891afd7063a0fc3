"""Where the lines of a command lead: to the terminal, or to programs as events."""

from __future__ import annotations

import argparse
import logging
import os
import sys
import time
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager
from datetime import datetime

from m4e_fmi.cli.shared.events import SCHEMA, End, Event, Line, Start, Warned, as_json
from m4e_fmi.cli.shared.log import LOG, tell_event
from m4e_fmi.cli.shared.output import alone
from m4e_fmi.shown import cleaned

_BAR = "tqdm"
"""The module of progress bars; before it is imported, there are none."""
_FEW = 10
"""Of lines that count, one in so many is kept where they cannot overwrite each other."""


def add_log(command: argparse.ArgumentParser, *, events: bool = False) -> None:
    """Add --quiet and, if the command tells `events`, --events."""
    group = command.add_argument_group("what is told")
    group.add_argument("--quiet", action="store_true", help="warnings and errors only")
    if events:
        group.add_argument(
            "--events",
            action="store_true",
            help="standard output for programs: JSON, an object a line (docs/logs.md)",
        )


@contextmanager
def logged() -> Generator[Log]:
    """Lines go to people during the block, and where `Log.open` leads them."""
    log = Log()
    try:
        yield log
    finally:
        log.close()


class Log:
    """The handlers of one command."""

    def __init__(self) -> None:
        self._began = time.perf_counter()
        self._people = ForPeople()
        LOG.addHandler(self._people)
        self._programs: ForPrograms | None = None

    def open(self, options: argparse.Namespace, command: Sequence[str]) -> None:
        """Lead the lines where `options` say."""
        if getattr(options, "quiet", False):
            self._people.setLevel(logging.WARNING)
        if getattr(options, "events", False):
            self._people.only_beside = True
            self._programs = ForPrograms(self._began)
            LOG.addHandler(self._programs)
            tell_event(_start(command))

    def end(self, exit_code: int) -> None:
        """Tell the exit code."""
        tell_event(End(exit_code))

    def close(self) -> None:
        """Take the handlers back."""
        for handler in filter(None, (self._people, self._programs)):
            LOG.removeHandler(handler)
            handler.close()


def _start(command: Sequence[str]) -> Start:
    from m4e_fmi.cli.shared.defect import versions

    date = datetime.now().astimezone().isoformat(timespec="seconds")
    return Start(SCHEMA, ["m4e-fmi", *command], os.getcwd(), date, versions())  # noqa: PTH109


class ForPeople(logging.Handler):
    """Lines on the terminal; `only_beside` leaves standard output to others."""

    only_beside = False

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line where it belongs; warnings and errors that are left alone stand beside."""
        text = record.getMessage()
        if not text:
            return
        beside, number = getattr(record, "beside", False), getattr(record, "number", None)
        stream = sys.stderr if beside else sys.stdout
        if self.only_beside and not beside:
            return
        if number and stream.isatty():
            end = "\n" if number[0] == number[1] else ""
            print(f"\r\033[K{text}", end=end, file=stream, flush=True)
        elif beside or self.level >= logging.WARNING:
            _say_beside(text)
        elif _is_kept(record):
            print(text, flush=True)


def _say_beside(text: str) -> None:
    """Print on the standard error, above a progress bar if there may be one."""
    if _BAR in sys.modules:
        from m4e_fmi.report import say_beside

        say_beside(text)
    else:  # an error is told although nothing can be imported any more
        print(text, file=sys.stderr, flush=True)


def _is_kept(record: logging.LogRecord) -> bool:
    """False for most of the lines that count, where they cannot overwrite each other.

    Warnings are kept, however they end.
    """
    number = getattr(record, "number", None)
    return not number or number[0] % _FEW == 0 or record.levelno >= logging.WARNING


class ForPrograms(logging.Handler):
    """Events, as JSON on standard output, where nobody else prints meanwhile."""

    def __init__(self, began: float) -> None:
        super().__init__()
        self._began = began
        self._taken = ExitStack()
        self._out = self._taken.enter_context(alone())

    def emit(self, record: logging.LogRecord) -> None:
        """Write the event of a record, or one of its line."""
        event: Event | None = getattr(record, "event", None)
        text = record.getMessage()
        if event is None and text and _is_kept(record):
            kind = Warned if record.levelno >= logging.WARNING else Line
            event = kind(cleaned(text))
        if event is not None:
            text = as_json(event, time.perf_counter() - self._began)
            print(text, file=self._out, flush=True)

    def close(self) -> None:
        """Give the standard output back."""
        self._taken.close()
        super().close()
