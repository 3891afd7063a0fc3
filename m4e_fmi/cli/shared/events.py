"""Events of a command for programs: one JSON object on a line (`--events`, docs/logs.md)."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import ClassVar

from m4e_fmi.errors import InputError, Problem

SCHEMA = 1
"""Number of the schema: another one if a field is renamed or left out, or means something else."""


@dataclass(frozen=True)
class Event:
    """Base of the events; `event` is the name of the kind."""

    event: ClassVar[str]

    def as_dict(self) -> dict[str, object]:
        """The kind and the fields."""
        return {"event": self.event, **{f.name: getattr(self, f.name) for f in fields(self)}}


@dataclass(frozen=True)
class Start(Event):
    """The first event: number of the schema, command, working folder, date, versions by package."""

    event = "start"
    schema: int
    command: list[str]
    folder: str
    date: str
    versions: dict[str, str]


@dataclass(frozen=True)
class Plan(Event):
    """The run before its first step; times in s, 0 for a step size that is not fixed."""

    event = "plan"
    name: str
    method: str
    start_time: float
    stop_time: float
    step_size: float
    output_interval: float
    components: list[str]
    results: str


@dataclass(frozen=True)
class Line(Event):
    """A line of text for people, as the progress of a build."""

    event = "line"
    text: str


@dataclass(frozen=True)
class Warned(Event):
    """A warning, or a message of an FMU."""

    event = "warning"
    text: str


@dataclass(frozen=True)
class Progress(Event):
    """Simulated time [s], its share of the whole [1], simulated over wall time [1]."""

    event = "progress"
    time: float
    fraction: float
    speed: float


@dataclass(frozen=True)
class Runs(Event):
    """Runs of a study that are done, and all."""

    event = "runs"
    done: int
    total: int


@dataclass(frozen=True)
class Written(Event):
    """A file that has been written."""

    event = "file"
    path: str


@dataclass(frozen=True)
class Summary(Event):
    """Numbers of the run: {name, unit, value}. Variables: {name, unit, min, mean, max}."""

    event = "summary"
    numbers: list[dict[str, object]]
    variables: list[dict[str, object]]


@dataclass(frozen=True)
class Failed(Event):
    """An error: its `kind` (input, run, interrupted, defect), its text, its problems.

    Problems of an input: {message, remedy, file, line, column}; no file is "", no line 0.
    """

    event = "error"
    kind: str
    text: str
    problems: list[dict[str, object]]

    @classmethod
    def of(cls, error: BaseException, kind: str, text: str) -> Failed:
        """The event of `error`, told as `text`."""
        found = error.problems if isinstance(error, InputError) else []
        return cls(kind, text, [_of_problem(problem) for problem in found])


@dataclass(frozen=True)
class End(Event):
    """The last event: the exit code of the command."""

    event = "end"
    exit_code: int


KINDS: tuple[type[Event], ...] = (
    Start, Plan, Line, Warned, Progress, Runs, Written, Summary, Failed, End,
)  # fmt: skip


def as_json(event: Event, wall_time: float) -> str:
    """The line of an event at `wall_time` [s] of the command; null for nan and infinity."""
    told = {**event.as_dict(), "wall_time": round(wall_time, 3)}
    return json.dumps(_finite(told), allow_nan=False)


def _of_problem(problem: Problem) -> dict[str, object]:
    keys = ("message", "remedy", "file", "line", "column")
    return {key: getattr(problem, key) for key in keys}


def _finite(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
