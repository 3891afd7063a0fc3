"""A mooring, ready to be run: MoorDyn's input text and the names of what it connects."""

from __future__ import annotations

from dataclasses import dataclass

from m4e_adapters.moordyn.stability import MARGIN, Segment, stable_step
from m4e_fmi.errors import InputError, Problem

FREE_STEP = 1.0  # [s] internal step where nothing moves inside the lines


@dataclass(frozen=True)
class Fairlead:
    """A point that is moved from outside: its name and where it starts [m], world frame."""

    name: str
    x: float
    y: float
    z: float


@dataclass(frozen=True)
class Mooring:
    """What a `LineSystem` needs.

    `text` is a MoorDyn v2 input file; `fairleads` and `lines` are in its order; `time_step` [s] is
    MoorDyn's internal step; `static_duration` [s] is what the static solution may take, 0: unknown.
    `drawn` are the fairleads where a ready file has them, to be compared with where they start.
    """

    text: str
    fairleads: tuple[Fairlead, ...]
    lines: tuple[str, ...]
    time_step: float
    static_duration: float
    drawn: tuple[Fairlead, ...] = ()


def internal_step(
    segments: dict[str, Segment], *, scheme: str, wanted: float | None, file: str = ""
) -> float:
    """The internal time step [s]: the `wanted` one if it is stable, else InputError.

    `segments` holds one segment of every line that has moving nodes, by the line's name.
    """
    if not segments:
        return wanted or FREE_STEP
    limits = {name: stable_step(segment, scheme) for name, segment in segments.items()}
    worst = min(limits, key=lambda name: limits[name])
    if wanted is None:
        return MARGIN * limits[worst]
    if wanted > limits[worst]:
        message = (
            f"internal time step {wanted:g} s is unstable: {worst} allows at most "
            f"{limits[worst]:.3g} s with {scheme}"
        )
        advice = "leave the step out to have a stable one chosen, or use fewer segments"
        if scheme == "RK2":
            advice += ", or scheme RK4"
        raise InputError([Problem(message, advice, file)])
    return wanted
