"""Lines of a command: on the terminal, and as events for programs (docs/logs.md).

People read standard output (results) and standard error (progress, notes, warnings, errors);
`--verbose` adds what is built and the numerics, `--quiet` leaves warnings and errors. `--events`
has one JSON object on a line of standard output, in place of the lines for people.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import time
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from shutil import get_terminal_size
from typing import TextIO

from m4e_fmi.cli.shared.output import alone
from m4e_fmi.errors import InputError
from m4e_fmi.shown import cleaned, one_line

SCHEMA = 1
"""Number of the schema: another one if a field is renamed or left out, or means something else."""
EVENTS = {
    "start": ("schema", "command", "folder", "date", "versions"),
    "plan": (
        "name", "method", "start_time", "stop_time", "step_size", "output_interval", "components",
        "results",
    ),
    "line": ("text",),
    "warning": ("text",),
    "progress": ("time", "fraction", "speed"),
    "runs": ("done", "total"),
    "file": ("path",),
    "summary": ("numbers", "variables"),
    "error": ("kind", "text", "problems"),
    "end": ("exit_code",),
}  # fmt: skip
"""Fields of each kind of event; all have `event`, the kind, and `wall_time` [s] of the command."""
PROBLEM = ("message", "remedy", "file", "line", "column")
"""Fields of a problem of an input; no file is "", no line 0."""
INTERVAL = 1.0
"""Seconds between events of progress."""
_COUNTING = re.compile(r"(\d+) of (\d+)$")
_STANDING = re.compile(r"(?:^|: )(warning|note)\b")
_BAR = "tqdm"
"""The module of progress bars; before it is imported, there are none."""
_FEW = 10
"""Of lines that count, one in so many is kept where they cannot overwrite each other."""


class _Course:
    """Where lines of the running command lead."""

    quiet = verbose = passing = False
    programs: TextIO | None = None
    began = 0.0


_course = _Course()


def add_log(command: argparse.ArgumentParser, *, events: bool = False) -> None:
    """Add --quiet and, if the command tells `events`, --events."""
    group = command.add_argument_group("what is told")
    amount = group.add_mutually_exclusive_group()
    amount.add_argument("--quiet", action="store_true", help="warnings and errors only")
    amount.add_argument(
        "--verbose", action="store_true", help="also what is built, steps, times and energies"
    )
    if events:
        group.add_argument(
            "--events",
            action="store_true",
            help="standard output for programs: JSON, an object a line (docs/logs.md)",
        )


@contextmanager
def logged(options: argparse.Namespace, command: Sequence[str]) -> Generator[None]:
    """Lines lead where `options` say during the block, which runs the `command`."""
    _course.began = time.perf_counter()
    _course.quiet = getattr(options, "quiet", False)
    _course.verbose = getattr(options, "verbose", False)
    try:
        if not getattr(options, "events", False):
            yield
            return
        from m4e_fmi.doctor import versions

        with alone() as _course.programs:
            date = datetime.now().astimezone().isoformat(timespec="seconds")
            tell_event(
                "start", schema=SCHEMA, command=["m4e-fmi", *command], folder=str(Path.cwd()),
                date=date, versions=versions(),
            )  # fmt: skip
            yield
    finally:
        _clear()
        _course.quiet, _course.verbose, _course.programs = False, False, None


def say(text: str) -> None:
    """Tell a line of progress: with --verbose, or on a terminal until the next line is told.

    Warnings and notes are always told, and stay. Programs get one in so many of lines that count.
    """
    text = one_line(text)
    found = _COUNTING.search(text)
    if standing := _STANDING.search(text):
        (warn if standing[1] == "warning" else note)(text)
    elif _course.programs or _course.verbose:
        if not found or int(found[1]) % _FEW == 0:
            _tell(text)
    elif not _course.quiet and sys.stderr.isatty():
        _clear()
        print(text[: get_terminal_size().columns - 1], end="", file=sys.stderr, flush=True)
        _course.passing = True


def _clear() -> None:
    """Take the line of progress from the terminal, if there is one."""
    if _course.passing:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
        _course.passing = False


def detail(text: str) -> None:
    """Tell numerics: with --verbose, or to programs."""
    if _course.verbose or _course.programs:
        _tell(text)


def show(text: str, event: str = "", **fields: object) -> None:
    """Tell a result, of one line or more; programs get the `event` if there is one."""
    _tell(text, event=event, fields=fields)


def note(text: str) -> None:
    """Tell a line beside the result, on standard error."""
    _tell(one_line(text), beside=True)


def warn(text: str) -> None:
    """Tell a warning, or a message of an FMU, on standard error."""
    _tell(one_line(text), beside=True, warns=True)


def fail(text: str, error: BaseException, kind: str) -> None:
    """Tell an error of a `kind` (docs/logs.md), of one line or more, on standard error."""
    problems = error.problems if isinstance(error, InputError) else []
    found = [{key: getattr(problem, key) for key in PROBLEM} for problem in problems]
    fields = {"kind": kind, "text": text, "problems": found}
    _tell(text, beside=True, warns=True, event="error", fields=fields)


def show_result(text: str, values: object, options: argparse.Namespace) -> None:
    """Tell a result, or with --json print its `values`, also with --quiet."""
    if options.json:
        print(json.dumps(values, indent=2))
    else:
        show(text)


def print_files(paths: Iterable[Path], options: argparse.Namespace | None = None) -> None:
    """Tell the paths of files that were written, but not beside a result of --json."""
    told = [] if options and options.json else list(map(str, paths))
    for path in told:
        tell_event("file", path=path)
    if told and not _course.programs:
        show(f"wrote {', '.join(told)}")


def tell_event(event: str, /, **fields: object) -> None:
    """Tell programs an event, one of `EVENTS`; null stands for nan and infinity."""
    if _course.programs is not None:
        wall_time = round(time.perf_counter() - _course.began, 3)
        told = _finite({"event": event, **fields, "wall_time": wall_time})
        print(json.dumps(told, allow_nan=False), file=_course.programs, flush=True)


def _finite(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _tell(
    text: str,
    *,
    beside: bool = False,
    warns: bool = False,
    event: str = "",
    fields: Mapping[str, object] | None = None,
) -> None:
    """Tell programs an event, or that of the line; and people the line, where it belongs."""
    if event:
        tell_event(event, **(fields or {}))
    else:
        tell_event("warning" if warns else "line", text=cleaned(text))
    if (_course.programs and not beside) or (_course.quiet and not warns):
        return
    _clear()
    if (beside or _course.quiet) and _BAR in sys.modules:
        from m4e_fmi.report import say_beside

        say_beside(text)
    elif beside or _course.quiet:  # an error is told although nothing can be imported any more
        print(text, file=sys.stderr, flush=True)
    else:
        print(text, flush=True)


@contextmanager
def progress(stop_time: float, *, start: float = 0.0) -> Generator[Callable[[float], None]]:
    """A callable to be told the simulated time [s]: a bar on terminals, events for programs."""
    if _course.programs:
        with _progress_events(stop_time, start) as told:
            yield told
    elif _course.quiet:
        yield lambda _: None
    else:
        _clear()
        from m4e_fmi.report import progress_bar

        with progress_bar(stop_time, start=start) as told:
            yield told


@contextmanager
def runs_progress() -> Generator[Callable[[int, int], None] | None]:
    """A callable to be told the runs that are done and all: a bar, or events for programs."""
    if _course.programs:
        yield lambda done, total: tell_event("runs", done=done, total=total)
    elif _course.quiet:
        yield None
    else:
        _clear()
        from m4e_fmi.report import runs_bar

        with runs_bar() as told:
            yield told


@contextmanager
def _progress_events(stop_time: float, start: float) -> Generator[Callable[[float], None]]:
    """Events of progress: the first, one in each INTERVAL, the last."""
    began, last = time.perf_counter(), -INTERVAL
    waiting: float | None = None

    def emit(t: float) -> None:
        nonlocal last, waiting
        last, waiting = time.perf_counter() - began, None
        done, span = t - start, stop_time - start
        fraction = done / span if span else 1.0
        tell_event("progress", time=t, fraction=fraction, speed=done / max(last, 1e-9))

    def report(t: float) -> None:
        nonlocal waiting
        waiting = t
        if time.perf_counter() - began - last >= INTERVAL:
            emit(t)

    yield report
    if waiting is not None:
        emit(waiting)
