"""Settings of a simulation: times, algorithm and tolerances, checked."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import Annotated, SupportsFloat, SupportsIndex

from pydantic import BeforeValidator

from m4e_fmi.cosim.system.component_step import NS_PER_SECOND, TIMES, nanoseconds, time_of
from m4e_fmi.coupling_algorithms import DEFAULT_ALGORITHM, algorithm_names
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Section, rejected
from m4e_fmi.files.limits import LONGEST_RUN, beyond_limits

ODD = 1e-3
"""Nanoseconds by which a time may miss whole ones for being a number in floating point."""

TOLERANCES = ("tolerance", "coupling_tolerance")
CHECKPOINTS = ("checkpoint_interval", "checkpoint_wall_interval")
OPTIONAL = ("output_interval", *CHECKPOINTS, *TOLERANCES)
NUMBERS = ("stop_time", "step_size", "start_time", *OPTIONAL)
"""Settings of a simulation that are numbers."""


@dataclass(frozen=True)
class Simulation:
    """Times [s], algorithm and tolerances of a run.

    A time may be given as a text, ``"10 ms"``. `step_size` is the time between communication
    points; `output_interval`, a multiple of it, the time between rows of the results (None: every
    point). `tolerance` (relative) is handed to the FMUs that integrate with error control; None
    leaves them their own. `coupling_tolerance` (relative) makes the steps adaptive, none larger
    than `step_size`: None keeps them fixed. Checkpoints are taken every `checkpoint_interval` of
    simulated time, or `checkpoint_wall_interval` of wall time, whichever comes first; None: not by
    that. InputError with all problems of the settings.
    """

    stop_time: float
    step_size: float
    algorithm: str = DEFAULT_ALGORITHM
    output_interval: float | None = None
    start_time: float = 0.0
    tolerance: float | None = None
    coupling_tolerance: float | None = None
    checkpoint_interval: float | None = None
    checkpoint_wall_interval: float | None = None

    @property
    def has_checkpoints(self) -> bool:
        """True if checkpoints are taken."""
        return any(getattr(self, key) is not None for key in CHECKPOINTS)

    @property
    def last_time(self) -> float:
        """The stop time that FMUs are told [s]: some refuse to go further.

        In doubles, t + h of the last step may be larger than `stop_time` by so much.
        """
        return math.nextafter(math.nextafter(self.stop_time, math.inf), math.inf)

    @property
    def start_ns(self) -> int:
        """`start_time` as the master counts it [ns]."""
        return nanoseconds(self.start_time)

    @property
    def stop_ns(self) -> int:
        """`stop_time` as the master counts it [ns]."""
        return nanoseconds(self.stop_time)

    @property
    def step_ns(self) -> int:
        """`step_size` as the master counts it [ns]."""
        return nanoseconds(self.step_size)

    @property
    def step(self) -> Fraction:
        """The exact `step_ns` [s]."""
        return Fraction(self.step_ns, NS_PER_SECOND)

    @property
    def output_ns(self) -> int:
        """Time between rows of the results [ns]: `output_interval`, or a step."""
        return nanoseconds(self.output_interval or self.step_size)

    def __post_init__(self) -> None:
        problems: list[Problem] = []
        for key in NUMBERS:
            try:
                object.__setattr__(self, key, _number(key, getattr(self, key)))
            except InputError as error:
                problems += error.problems
        if not problems:
            problems = [*_time_problems(self), *_interval_problems(self), *_other_problems(self)]
        if not problems:
            span = self.stop_time - self.start_time
            intervals = {"output_interval": self.output_interval, "step_size": self.step_size}
            problems = [_problem(*found) for found in beyond_limits(span, **intervals)]
        if problems:
            raise InputError(problems)


SETTINGS = tuple(field.name for field in fields(Simulation))


def _number(key: str, given: object) -> float | None:
    """A setting as a number; InputError if it cannot be one.

    It may be a number of any library, and a time a text as ``"10 ms"``.
    """
    if given is None and key in OPTIONAL:
        return None
    if isinstance(given, str) and key not in TOLERANCES:
        try:
            return float(time_of(given))
        except ValueError:
            raise InputError.single(f"{key} {given!r} is not a valid duration", TIMES) from None
    is_scalar = getattr(given, "shape", ()) == () and not isinstance(given, str | bool)
    if is_scalar and isinstance(given, SupportsFloat | SupportsIndex):
        with suppress(TypeError, ValueError):
            return float(given)
    remedy = "1e-6 is usual" if key in TOLERANCES else TIMES
    raise InputError.single(f"{key}: expected a number, got {given!r}", remedy)


def _in_seconds(given: object) -> object:
    """A text with a unit as a time in seconds; other values as they are."""
    if not isinstance(given, str):
        return given
    try:
        return float(time_of(given))
    except ValueError:
        raise rejected(f"{given!r} is not a valid duration", TIMES) from None


Time = Annotated[float, BeforeValidator(_in_seconds)]
"""A time in seconds, or a text as ``"10 ms"``."""


class SimulationSection(Section):
    """A Simulation as files have it."""

    stop_time: Time
    step_size: Time
    algorithm: str = DEFAULT_ALGORITHM
    output_interval: Time | None = None
    start_time: Time = 0.0
    tolerance: float | None = None
    coupling_tolerance: float | None = None
    checkpoint_interval: Time | None = None
    checkpoint_wall_interval: Time | None = None


def _problem(key: str, message: str, remedy: str) -> Problem:
    return Problem(message, remedy, keys=(key,))


def _time_problems(simulation: Simulation) -> Iterator[Problem]:
    """Problems of start time, stop time and step."""
    span = simulation.stop_time - simulation.start_time
    step = simulation.step_size
    if not (math.isfinite(span) and span > 0):
        text = f"stop_time {simulation.stop_time:g} s is not after the start"
        yield _problem("stop_time", text, f"start_time is {simulation.start_time:g} s")
    else:
        latest = max(abs(simulation.start_time), abs(simulation.stop_time))
        yield from (_problem(*one) for one in beyond_limits(latest))
    if not (math.isfinite(step) and step * NS_PER_SECOND >= 1):
        text = f"step_size {step:g} s: expected 1e-9 s or more"
        yield _problem("step_size", text, "give it in seconds, as 0.01, or as '10 ms'")
    elif span > 0 and step > span:
        text = f"step_size {step:g} s is longer than the run of {span:g} s"
        yield _problem("step_size", text, f"take {span:g} s or less, or a longer run")


def _interval_problems(simulation: Simulation) -> Iterator[Problem]:
    """The problem of an output interval that is not a multiple of the step."""
    interval, step = simulation.output_interval, simulation.step_size
    if interval is None:
        return
    if not abs(interval) <= LONGEST_RUN:
        text = f"output_interval {interval:g} s: expected a multiple of step_size"
        yield _problem("output_interval", text, "leave it out for a row after every step")
    elif step <= LONGEST_RUN and step * NS_PER_SECOND >= 1:
        count = nanoseconds(interval) / simulation.step_ns
        if count >= 1 and count == int(count):
            return
        text = f"output_interval {interval:g} s is not a multiple of step_size {step:g} s"
        remedy = f"take {max(1, round(count)) * step:g} s, or leave it out"
        if not is_whole(step):
            text = (
                f"output_interval {interval:g} s: steps are whole nanoseconds, so that the "
                f"step_size of {step:.12g} s is one of {simulation.step_ns} ns"
            )
            nearest = _fitting(step, interval)
            remedy = f"take a step_size of {nearest:.12g} s, or leave output_interval out"
        yield _problem("output_interval", text, remedy)


def _other_problems(simulation: Simulation) -> Iterator[Problem]:
    """Problems of the tolerances, the checkpoints and the algorithm."""
    for key in CHECKPOINTS:
        interval = getattr(simulation, key)
        if interval is not None and not 0 < interval <= LONGEST_RUN:
            text = f"{key} {interval:g} s: expected a time above 0"
            yield _problem(key, text, "leave it out for a run without checkpoints")
    for key in TOLERANCES:
        tolerance = getattr(simulation, key)
        if tolerance is not None and not 0 < tolerance < 1:
            text = f"{key} {tolerance:g}: expected a number between 0 and 1"
            yield _problem(key, text, "1e-6 is usual")
    if simulation.algorithm not in algorithm_names():
        text = f"unknown algorithm {simulation.algorithm!r}"
        yield _problem("algorithm", text, suggestion(simulation.algorithm, algorithm_names()))


def is_whole(time: float) -> bool:
    """True for a time [s] of whole nanoseconds."""
    return abs(time * NS_PER_SECOND - nanoseconds(time)) < ODD


def _fitting(step: float, interval: float) -> float:
    """A time [s] near `step` of whole nanoseconds, of which `interval` [s] is a multiple."""
    whole, part = nanoseconds(interval), nanoseconds(step)
    count = max(1, round(whole / part))
    near = min(count, part)
    numbers = (n for k in range(near) for n in (near - k, near + k))
    found = next(n for n in numbers if whole % n == 0)
    return (whole // found if near == count else found) / NS_PER_SECOND
