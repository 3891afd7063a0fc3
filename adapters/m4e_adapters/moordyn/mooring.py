"""A mooring, ready to be run: MoorDyn's input text and the names of what it connects."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from m4e_adapters.hydrodynamics.config import Current
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.current import current_velocity
from m4e_adapters.hydrodynamics.seas.water.kinematics import Stretching, wavenumber
from m4e_adapters.moordyn.stability import MARGIN, Segment, stable_step
from m4e_fmi.errors import InputError, Problem

FREE_STEP = 1.0  # [s] internal step where nothing moves inside the lines
HEIGHTS = 101  # at which the fastest current is looked for
SHORTEST = 1e-6  # [s] internal step: a million of them a second


NetData = dict[str, Any]
"""JSON values that describe points and lines, see `rest.net_at`."""


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
class Sea:
    """The water around lines, moved by `waves` and a `current`: `gravity` [m/s2], `depth` [m]."""

    waves: tuple[WaveSystem, ...]
    current: Current | None
    stretching: Stretching
    depth: float
    gravity: float

    @property
    def speed(self) -> float:
        """Hardly exceeded by the water [m/s]: four standard deviations and the current."""
        energy, steady = 0.0, 0.0
        if self.current is not None:
            heights = np.linspace(-self.depth, 0.0, HEIGHTS)
            found = current_velocity(self.current, heights, depth=self.depth)
            steady = float(np.linalg.norm(found, axis=1).max())
        for system in self.waves:
            omega, amplitude = system.configured()
            number = wavenumber(omega, depth=self.depth, gravity=self.gravity)
            energy += 0.5 * float(np.sum((omega * amplitude / np.tanh(number * self.depth)) ** 2))
        return 4.0 * math.sqrt(energy) + steady


@dataclass(frozen=True)
class Mooring:
    """Data of a `LineSystem`.

    `text` is a MoorDyn v2 input file; `fairleads` and `lines` are in its order; `time_step` [s] is
    MoorDyn's internal step. `net` describes points and lines for their static equilibrium (see
    `rest.net_at`; JSON values), None where only MoorDyn can look for it; `at_rest` says whether
    lines start there. `bed` is z [m] of the seabed. `drawn` are the fairleads where a ready file
    has them, to be compared with where they start; `notes` say what in a ready file is taken
    otherwise than it stands there. `sea` is None if the water stands still.
    """

    text: str
    fairleads: tuple[Fairlead, ...]
    lines: tuple[str, ...]
    time_step: float
    net: NetData | None
    at_rest: bool
    bed: float
    drawn: tuple[Fairlead, ...] = ()
    notes: tuple[str, ...] = ()
    sea: Sea | None = None

    def in_space(self) -> Mooring:
        """The same with fairleads that move along Y, too."""
        moved, drawn = (
            tuple(replace(fairlead, moves_in_space=True) for fairlead in group)
            for group in (self.fairleads, self.drawn)
        )
        return replace(self, fairleads=moved, drawn=drawn)


def net_line(
    *,
    ends: tuple[int, int],
    segments: int,
    length: float,
    diameter: float,
    mass_per_length: float,
    stiffness: float,
    bending: float,
    drag: float,
    axial_drag: float,
    density: float,
    gravity: float,
) -> dict[str, object]:
    """A line as `statics.Net` takes it: `ends` are numbers of points from 0, the rest is SI.

    `drag` and `axial_drag` are coefficients, the latter for the area π d l.
    """
    return {
        "ends": ends,
        "segments": segments,
        "length": length,
        "stiffness": stiffness,
        "bending": bending,
        "weight": mass_per_length * gravity,
        "buoyancy": density * gravity * math.pi * diameter**2 / 4,
        "diameter": diameter,
        "drag": 0.5 * density * diameter * drag,
        "axial_drag": 0.5 * density * diameter * math.pi * axial_drag,
    }


def internal_step(segments: dict[str, Segment], *, scheme: str, wanted: float | None) -> float:
    """The internal time step [s]: the `wanted` one if it is stable.

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
            f"{limits[worst]:.3g} s with {scheme}, where it lands on the seabed or moves at up to "
            f"{segments[worst].speed:.3g} m/s"
        )
        advice = "leave the step out to have a stable one chosen, or use fewer segments"
        if scheme == "RK2":
            advice += ", or scheme RK4"
        raise InputError([Problem(message, advice, keys=("solver", "time_step"))])
    return wanted


def _longest(segment: Segment, scheme: str) -> float:
    """The longest stable step [s]; 0 for numbers with which it cannot be computed."""
    try:
        return stable_step(segment, scheme)
    except (ArithmeticError, ValueError):
        return 0.0
