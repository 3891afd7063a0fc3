"""Lines of a command: on the terminal, in a log file, and as events for programs.

All go through one logger; options choose where it leads:

- people read standard output (progress, results) and standard error (notes, warnings, errors);
  `--quiet` leaves warnings and errors;
- `--log-file` has all lines with their wall time;
- `--events` has one JSON object on a line of standard output, in place of the lines for people.
"""

from __future__ import annotations

import argparse
import errno
import logging
import os
import re
import sys
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import ExitStack, contextmanager, suppress
from datetime import datetime
from pathlib import Path

from m4e_fmi.cli.shared.events import (
    SCHEMA,
    End,
    Event,
    Line,
    Progress,
    Runs,
    Start,
    Warned,
    Written,
    as_json,
)
from m4e_fmi.cli.shared.output import alone
from m4e_fmi.errors import is_other
from m4e_fmi.shown import cleaned, one_line

LOG = logging.getLogger("m4e_fmi.command")
LOG.propagate = False
LOG.setLevel(1)
PROGRESS = 5
"""Level of records that only programs get."""
SUFFIXES = (".log", ".txt")
INTERVAL = 1.0
"""Seconds between events of progress."""
_COUNTING = re.compile(r"(\d+) of (\d+)$")
_WARNING = re.compile(r"(^|: )warning\b")
_BAR = "tqdm"
"""The module of progress bars; before it is imported, there are none."""
_FEW = 10
"""Of lines that count, one in so many is kept where they cannot overwrite each other."""


def add_log(command: argparse.ArgumentParser, *, events: bool = False) -> None:
    """Add --quiet, --log-file and, if the command tells `events`, --events."""
    group = command.add_argument_group("what is told")
    group.add_argument("--quiet", action="store_true", help="warnings and errors only")
    group.add_argument(
        "--log-file", type=Path, metavar="FILE", help="all lines with their time (.log, .txt)"
    )
    if events:
        group.add_argument(
            "--events",
            action="store_true",
            help="standard output for programs: JSON, an object a line (docs/logs.md)",
        )


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


@contextmanager
def progress(stop_time: float, *, start: float = 0.0) -> Generator[Callable[[float], None]]:
    """A callable to be told the simulated time [s]: a bar on terminals, events for programs."""
    from m4e_fmi.report import progress_bar

    if _for_programs():
        with _progress_events(stop_time, start) as told:
            yield told
    elif _for_people():
        with progress_bar(stop_time, start=start) as told:
            yield told
    else:
        yield _unseen


@contextmanager
def runs_progress() -> Generator[Callable[[int, int], None] | None]:
    """A callable to be told the runs that are done and all: a bar, or events for programs."""
    from m4e_fmi.study.shown.progress import runs_bar

    if _for_programs():
        yield lambda done, total: tell_event(Runs(done, total))
    elif _for_people():
        with runs_bar() as told:
            yield told
    else:
        yield None


def _for_programs() -> bool:
    return any(isinstance(one, _Events) for one in LOG.handlers)


def _for_people() -> bool:
    return any(isinstance(one, _People) and one.level < logging.WARNING for one in LOG.handlers)


def _unseen(_: float) -> None:
    pass


@contextmanager
def _progress_events(stop_time: float, start: float) -> Generator[Callable[[float], None]]:
    """Events of progress: the first, one in each INTERVAL, the last."""
    began, last = time.perf_counter(), -INTERVAL
    waiting: float | None = None

    def emit(t: float) -> None:
        nonlocal last
        last = time.perf_counter() - began
        span = stop_time - start
        tell_event(Progress(t, (t - start) / span if span else 1.0, (t - start) / max(last, 1e-9)))

    def told(t: float) -> None:
        nonlocal waiting
        waiting = t
        if time.perf_counter() - began - last >= INTERVAL:
            emit(t)
            waiting = None

    yield told
    if waiting is not None:
        emit(waiting)


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
        self._people = _People()
        LOG.addHandler(self._people)
        self._others: list[logging.Handler] = []

    def open(self, options: argparse.Namespace, command: Sequence[str]) -> None:
        """Lead the lines where `options` say; InputError or RunError for a file that cannot be."""
        if getattr(options, "quiet", False):
            self._people.setLevel(logging.WARNING)
        events, path = getattr(options, "events", False), getattr(options, "log_file", None)
        if not (events or path):
            return
        start = _start(command)
        if events:
            self._people.only_beside = True
            self._add(_Events(self._began))
        tell_event(start)
        if path:
            self._add(_File(path, start))

    def _add(self, handler: logging.Handler) -> None:
        self._others.append(handler)
        LOG.addHandler(handler)

    def end(self, exit_code: int) -> None:
        """Tell the exit code."""
        tell_event(End(exit_code))
        for one in self._others:
            if isinstance(one, _File):
                one.line("INFO", f"exit code {exit_code}")

    def close(self) -> None:
        """Take the handlers back."""
        for handler in (self._people, *self._others):
            LOG.removeHandler(handler)
            handler.close()


def _start(command: Sequence[str]) -> Start:
    from m4e_fmi.cli.shared.defect import versions

    date = datetime.now().astimezone().isoformat(timespec="seconds")
    return Start(SCHEMA, ["m4e-fmi", *command], os.getcwd(), date, versions())  # noqa: PTH109


class _People(logging.Handler):
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


class _Events(logging.Handler):
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


class _File(logging.Handler):
    """Lines in a file, with their wall time; one that takes no more is told of, and left."""

    def __init__(self, path: Path, start: Start) -> None:
        from m4e_fmi.files.writing import cannot_write, check_suffix

        super().__init__()
        check_suffix(path, SUFFIXES, "a log")
        self._path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if is_other(path):  # opening a pipe would wait for its reader
                raise FileExistsError(errno.EEXIST, "it is not a regular file")
            self._file = path.open("w", encoding="utf-8", errors="replace")
        except OSError as error:
            raise cannot_write(path, error) from error
        self.line("INFO", f"command: {' '.join(start.command)}")
        self.line("INFO", f"folder: {start.folder}")
        self.line("INFO", ", ".join(f"{name} {one}" for name, one in start.versions.items()))

    def emit(self, record: logging.LogRecord) -> None:
        """Write the lines of a record."""
        text = record.getMessage()
        if text and _is_kept(record):
            self.line(record.levelname, text.removeprefix(f"{record.levelname.lower()}: "))

    def line(self, level: str, text: str) -> None:
        """Write `text`; its further lines are indented."""
        if self._file.closed:
            return
        when = datetime.now().astimezone().isoformat(timespec="milliseconds")
        further = "\n" + " " * (len(when) + 10)
        try:
            self._file.write(f"{when} {level:<8} {cleaned(text).replace(chr(10), further)}\n")
            self._file.flush()
        except OSError as error:
            self.close()
            warn(f"warning: the log ends here: {self._path}: {error.strerror or error}")

    def close(self) -> None:
        """Close the file."""
        with suppress(OSError):
            self._file.close()
        super().close()


__all__ = [
    "LOG", "Log", "add_log", "count", "fail", "logged", "note", "print_files", "progress", "say",
    "show", "tell_event", "warn",
]  # fmt: skip
