"""A mooring, ready to be run: MoorDyn's input text and the names of what it connects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Any

from m4e_adapters.hydrodynamics.config import Current
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import Stretching
from m4e_adapters.moordyn.ready_files.attachments import COUPLED
from m4e_adapters.moordyn.stability import (
    FLOW,
    MARGIN,
    NOTHING,
    SCHEMES,
    Segment,
    kind,
    stable_step,
)
from m4e_fmi.errors import InputError, Problem

FREE_STEP = 1.0  # [s] internal step where nothing moves inside the lines
SHORTEST = 1e-6  # [s] internal step: a million of them a second

NetData = dict[str, Any]
"""JSON values that describe points and lines, see `statics.Net`."""


@dataclass(frozen=True)
class Fairlead:
    """A point that is moved from outside: its name and where it starts [m], world frame.

    `moves_in_space`: along Y, too, else its y is fixed. `placed` is False for one that has no place
    unless a connection or a start value gives it one.
    """

    name: str
    x: float
    y: float
    z: float
    placed: bool = True
    moves_in_space: bool = False

    @property
    def place(self) -> tuple[float, ...]:
        """Where it starts along the axes on which it moves."""
        return (self.x, self.y, self.z) if self.moves_in_space else (self.x, self.z)


@dataclass(frozen=True)
class Failure:
    """Ends of lines that part together from what they are at, and go on at a free point.

    `ends` are (line, end) numbers from 0, end 1 for B. They part at a `time` [s], at a `tension`
    [N] of one of them, or when somebody says so; None: not by itself.
    """

    ends: tuple[tuple[int, int], ...]
    time: float | None = None
    tension: float | None = None


@dataclass(frozen=True)
class Sea:
    """The water around lines, moved by `waves` and a `current`: `gravity` [m/s2], `depth` [m]."""

    waves: tuple[WaveSystem, ...]
    current: Current | None
    stretching: Stretching
    depth: float
    gravity: float


@dataclass(frozen=True)
class Mooring:
    """Data of a `LineSystem`.

    `text` is a MoorDyn v2 input file, one row a line; `files` are what it names; `fairleads` and
    `lines` are in its order. `ends` has of each coupled object 1 for a point or 2 for a rod, whose
    ends are two fairleads, and `axes` the direction of a rod as drawn; empty: points only. `inert`:
    coupled objects have masses of their own; `moving`: `text` moves the water. `time_step` [s] is
    the longest internal step of `scheme`. `net` describes points and lines for their static
    equilibrium (see `statics.Net`; JSON values), None where only MoorDyn can look for it; `at_rest`
    says whether lines start there. `bed` is z [m] of the seabed. `drawn` are the fairleads where a
    ready file has them, to be compared with where they start; `notes` say what in a ready file is
    taken otherwise than it stands there. `winches` are numbers of the lines whose length is set.
    `sea` is None if the water is not moved from outside. `kinds` are what the loop needs of each
    line to shorten internal steps. `no_way_back` says why the state cannot be saved and restored;
    empty where it can. `strengths` [N] are those of lines, as far as they are known; `anchors` and
    `points` have the numbers in the text of fixed and free points, by name.
    """

    text: str
    fairleads: tuple[Fairlead, ...]
    lines: tuple[str, ...]
    time_step: float
    net: NetData | None
    at_rest: bool
    bed: float
    scheme: str = "RK2"
    files: Mapping[str, bytes] = field(default_factory=dict)
    ends: tuple[int, ...] = ()
    axes: tuple[tuple[float, float, float], ...] = ()
    inert: bool = False
    moving: bool = False
    winches: tuple[int, ...] = ()
    failures: tuple[Failure, ...] = ()
    drawn: tuple[Fairlead, ...] = ()
    notes: tuple[str, ...] = ()
    sea: Sea | None = None
    kinds: tuple[tuple[float, ...], ...] = ()
    no_way_back: str = ""
    strengths: Mapping[str, float] = field(default_factory=dict)
    anchors: Mapping[str, int] = field(default_factory=dict)
    points: Mapping[str, int] = field(default_factory=dict)

    def rows(self, title: str) -> list[list[str]]:
        """Words of the rows of the table `title` of the text; none without it."""
        lines = self.text.splitlines()
        first = next((k for k, row in enumerate(lines) if row.strip("- ") == title), len(lines))
        return [row.split() for row in takewhile(lambda row: "---" not in row, lines[first + 3 :])]

    @property
    def flat(self) -> bool:
        """True of a seabed that is not read from a file."""
        return "seafloorfile" not in self.text.lower()

    @property
    def moved(self) -> dict[str, Fairlead]:
        """Fairleads that are points, by their number in the text; MoorDyn has rods before them."""
        numbers = [row[0] for row in self.rows("POINTS") if row[1].upper() in COUPLED]
        first = len(self.fairleads) - len(numbers)
        return dict(zip(numbers, self.fairleads[first:], strict=True))

    @property
    def at_lines(self) -> list[list[str]]:
        """Numbers in the text of the points, or rods, at ends A and B of each line."""
        return [[w.upper().lstrip("CONPIT0") for w in row[2:4]] for row in self.rows("LINES")]

    def ends_at(self, point: int) -> list[tuple[int, int]]:
        """(line, end) from 0, end 1 for B, of all that is at a point, by its number."""
        pairs = enumerate(self.at_lines)
        return [(k, end) for k, both in pairs for end in (0, 1) if both[end] == str(point)]

    def described(self) -> dict[str, Any]:
        """The arguments of a `LineSystem`, but for its text and files: JSON values."""
        return {
            "names": [fairlead.name for fairlead in self.fairleads],
            "fairleads": [None if f.moves_in_space else f.y for f in self.fairleads],
            "placed": [fairlead.name for fairlead in self.fairleads if fairlead.placed],
            "drawn": [(fairlead.name, *fairlead.place) for fairlead in self.drawn],
            "lines": list(self.lines),
            "time_step": self.time_step,
            "share": MARGIN,
            "order": SCHEMES[self.scheme],
            "kinds": [[*kind[:-1], FLOW if self.moving else 0.0] for kind in self.kinds],
            "net": self.net,
            "at_rest": self.at_rest,
            "bed": self.bed,
            "notes": list(self.notes),
            "ends": list(self.ends),
            "axes": [list(axis) for axis in self.axes],
            "inert": self.inert,
            "moving": self.moving,
            "winches": list(self.winches),
            "failures": [
                (failure.ends, failure.time, failure.tension) for failure in self.failures
            ],
        }


def internal_step(segments: dict[str, Segment], *, scheme: str, wanted: float | None) -> float:
    """The longest internal time step [s]: the `wanted` one if it is stable in a taut line.

    `segments` holds one segment of every line that has moving nodes, by the line's name. InputError
    for a step that is unstable, or too short; its keys are those of a mooring section.
    """
    if not segments:
        return wanted or FREE_STEP
    limits = {name: _longest(segment, scheme) for name, segment in segments.items()}
    worst = min(limits, key=lambda name: limits[name])
    if limits[worst] < SHORTEST:
        message = f"{worst} would need internal steps of {limits[worst]:.3g} s"
        advice = "check lengths, masses, stiffness and damping, in SI units; use fewer segments"
        raise InputError([Problem(message, advice, keys=("lines", worst))])
    if wanted is None:
        return min(FREE_STEP, MARGIN * limits[worst])
    if wanted > limits[worst]:
        message = (
            f"internal time step {wanted:g} s is unstable: {worst} allows at most "
            f"{limits[worst]:.3g} s with {scheme}"
        )
        advice = "leave the step out to have a stable one chosen, or use fewer segments"
        if scheme == "RK2":
            advice += ", or scheme RK4"
        raise InputError([Problem(message, advice, keys=("solver", "time_step"))])
    return wanted


def kinds_of(
    segments: dict[str, Segment], moving: dict[str, Segment], *, bed: float
) -> tuple[tuple[float, ...], ...]:
    """Numbers of each line for the loop over MoorDyn; in lines beside `moving` nothing moves.

    `bed` is z [m] of the seabed at its highest.
    """
    return tuple(
        kind(segment, bed=bed) if name in moving else NOTHING for name, segment in segments.items()
    )


def _longest(segment: Segment, scheme: str) -> float:
    """The longest stable step [s]; 0 for numbers with which it cannot be computed."""
    try:
        return stable_step(segment, scheme)
    except (ArithmeticError, ValueError):
        return 0.0
