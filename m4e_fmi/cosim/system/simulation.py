"""Settings of a simulation, checked, and steps of components in it.

Times are read from texts as exact fractions; the master counts them in whole nanoseconds. A
component may have a step of its own, h, beside the macro step H of the system. Either H = n h: it
makes n steps in each macro step; or h = m H: it makes one in every m-th. Its points are then points
of the system, or lie between them at equal distances, and never drift away from them: they are
integers, converted to floating point only where the FMU is called. A step that is neither is an
error, which names the nearest that are.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import Annotated, Self, SupportsFloat, SupportsIndex

from pydantic import (
    BeforeValidator,
    ConfigDict,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.dataclasses import dataclass as checked_dataclass
from pydantic_core import ArgsKwargs, ErrorDetails

from m4e_fmi.coupling_algorithms import DEFAULT_ALGORITHM, algorithm_names
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import rejected, rejected_at
from m4e_fmi.files.limits import LONGEST_RUN, beyond_limits
from m4e_fmi.units import parse_unit

NS_PER_SECOND = 1_000_000_000
"""Nanoseconds, in which the master counts time."""
NEVER = 2**62
"""A time [ns] that no run reaches."""
HUGE = re.compile(r"e[+-]?\d{3}", re.IGNORECASE)
"""An exponent that no step has, and that takes forever as a fraction."""
TIMES = "give a number of seconds, or a text as '10 ms' or '1/3 ms', a blank before the unit"
"""Remedy for a text that is not a duration."""
DIGITS = 5e-6
"""Relative error of a step written in decimals: 0.000333333 s is a third of 1 ms."""
ODD = 1e-3
"""Nanoseconds by which a time may miss whole ones for being a number in floating point."""
TOLERANCES = ("tolerance", "coupling_tolerance")
CHECKPOINTS = ("checkpoint_interval", "checkpoint_wall_interval")


def nanoseconds(time: float) -> int:
    """A time [s] as the master counts it [ns]."""
    return round(time * NS_PER_SECOND)


@dataclass(frozen=True)
class ComponentStep:
    """A component's own step [s]: `pieces` in each macro step, or one in `every` so many.

    `constant`: its FMU makes no other steps. `adaptive`: the steps of the system change, its own
    change with them, and `step` is the longest. `held`: it steps by the system's step and holds its
    outputs in between, as a digital controller does.
    """

    step: float
    pieces: int = 1
    every: int = 1
    constant: bool = False
    adaptive: bool = False
    held: bool = False

    @property
    def step_ns(self) -> int:
        """`step` as the master counts it [ns]."""
        return nanoseconds(self.step)

    @property
    def is_longer(self) -> bool:
        """True if inputs and outputs stand still all through it."""
        return self.held or self.every > 1

    @property
    def shortens(self) -> bool:
        """True if the steps of the system may be shorter than usual."""
        return self.is_longer or not self.constant

    def __str__(self) -> str:
        if self.adaptive and self.pieces == 1:
            return (
                f"is stepped with the system, whose steps are of {self.step:g} s at most, for the "
                "coupling_tolerance: it is not sampled at its step_size"
            )
        if self.adaptive:
            return (
                f"makes {self.pieces} steps in each of the system's, of {self.step:g} s at most, "
                "for the coupling_tolerance: not all are of its step_size"
            )
        only = " (the only size of step that its FMU makes)" if self.constant else ""
        how = f"steps by {self.step:g} s{only}"
        if self.held:
            return f"{how}, and holds its outputs in between"
        if self.is_longer:
            return f"{how}, once in {self.every} steps"
        return f"{how}, {self.pieces} times in each step" if self.pieces > 1 else how


def seconds(given: float | str) -> Fraction:
    """The time [s] of a number of seconds or a text as ``"10 ms"``, ``"1/3 ms"``.

    InputError if `given` is not a duration, or not above zero.
    """
    try:
        found = time_of(str(given))
    except ValueError:
        message = f"step_size {given!r} is not a valid duration"
        raise InputError.single(message, TIMES) from None
    if found <= 0:
        raise InputError.single(f"step_size {given!r}: expected more than 0 s", TIMES)
    return found


def time_of(text: str) -> Fraction:
    """The time [s] of a text: ``"10 ms"``, ``"1/3 ms"`` or ``"0.1"``; ValueError if it has none."""
    number, _, unit = text.strip().partition(" ")
    scale = parse_unit(unit.strip() or "s")
    if HUGE.search(number) or not scale.same_dimension(parse_unit("s")):
        raise ValueError(f"{text!r} is not a valid duration")
    try:
        return Fraction(number) * Fraction(str(scale.factor))
    except ZeroDivisionError:
        raise ValueError(f"{text!r} is not a valid duration") from None


def fits(step: Fraction, macro: Fraction) -> bool:
    """True if one of the two is a multiple of the other."""
    ratio = max(step, macro) / min(step, macro)
    return abs(ratio - round(ratio)) <= DIGITS * ratio


def rate(step: Fraction, macro: Fraction, *, constant: bool = False) -> ComponentStep:
    """The step of a component that steps by `step` in a system that steps by `macro` [s].

    InputError if neither is a multiple of the other.
    """
    if not fits(step, macro):
        raise InputError([misfit(step, macro)])
    count = round(max(step, macro) / min(step, macro))
    if step > macro and count > 1:
        return ComponentStep(float(count * macro), every=count, constant=constant)
    return ComponentStep(float(macro / count), pieces=count, constant=constant)


def misfit(step: Fraction, macro: Fraction) -> Problem:
    """The problem of a step that does not fit to the system's, with the nearest that do."""
    own, whole = float(step), float(macro)
    if step < macro:
        message = f"step_size {own:g} s goes {whole / own:g} times into the system's {whole:g} s"
        fewer = int(macro / step)
        fitting = f"{_written(macro / (fewer + 1))} or {_written(macro / fewer)}"
        systems = f"{_written(step * fewer)} or {_written(step * (fewer + 1))}"
    else:
        message = f"step_size {own:g} s is {own / whole:g} times the system's {whole:g} s"
        fewer = int(step / macro)
        fitting = f"{_written(macro * fewer)} or {_written(macro * (fewer + 1))}"
        systems = f"{_written(step / (fewer + 1))} or {_written(step / fewer)}"
    return Problem(message, f"take {fitting}, or for the system {systems}")


def _written(time: Fraction) -> str:
    """A time as text: in decimals, if it has few digits, else as a fraction."""
    text = f"{float(time):.12g}"
    return f"{text} s" if Fraction(text) == time else f"{time} s"


def _number(given: object, info: ValidationInfo) -> float:
    """A setting as a number: one of any library, or a time as a text with a unit."""
    key = info.field_name
    is_time = key not in TOLERANCES
    if isinstance(given, str) and is_time:
        try:
            return float(time_of(given))
        except ValueError:
            raise rejected(f"{key} {given!r} is not a valid duration", TIMES) from None
    is_scalar = getattr(given, "shape", ()) == () and not isinstance(given, bool)
    if is_scalar and isinstance(given, str | SupportsFloat | SupportsIndex):
        with suppress(TypeError, ValueError, OverflowError):
            return float(given)
    remedy = TIMES if is_time else "1e-6 is usual"
    raise rejected(f"{key}: expected a number, got {given!r}", remedy)


Number = Annotated[float, BeforeValidator(_number)]
"""A number, of any library."""
Time = Number
"""A time in seconds, or a text as ``"10 ms"``."""


@checked_dataclass(frozen=True, config=ConfigDict(extra="forbid"))
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

    stop_time: Time
    step_size: Time
    algorithm: str = DEFAULT_ALGORITHM
    output_interval: Time | None = None
    start_time: Time = 0.0
    tolerance: Number | None = None
    coupling_tolerance: Number | None = None
    checkpoint_interval: Time | None = None
    checkpoint_wall_interval: Time | None = None

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

    @model_validator(mode="wrap")
    @classmethod
    def _checked(cls, given: object, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """The simulation of a file's section, or of arguments: their problems are an InputError."""
        try:
            made = handler(given)
            span = made.stop_time - made.start_time
            intervals = {"output_interval": made.output_interval, "step_size": made.step_size}
            if found := list(_problems(made)) or list(beyond_limits(span, **intervals)):
                wrong = [rejected_at((key,), *texts) for key, *texts in found]
                raise ValidationError.from_exception_data("simulation", wrong)
        except ValidationError as error:
            if not isinstance(given, ArgsKwargs):
                raise
            raise InputError(_problem(one) for one in error.errors()) from None
        return made


SETTINGS = tuple(field.name for field in fields(Simulation))


def _problem(error: ErrorDetails) -> Problem:
    """The problem of an argument."""
    other = {"message": f"{'.'.join(map(str, error['loc']))}: {error['msg']}"}
    return Problem(**error.get("ctx", other))


def _problems(simulation: Simulation) -> Iterator[tuple[str, str, str]]:
    """Problems of times, tolerances, checkpoints and algorithm: key, message, remedy."""
    span = simulation.stop_time - simulation.start_time
    step = simulation.step_size
    if not (math.isfinite(span) and span > 0):
        text = f"stop_time {simulation.stop_time:g} s is not after the start"
        yield ("stop_time", text, f"start_time is {simulation.start_time:g} s")
    else:
        latest = max(abs(simulation.start_time), abs(simulation.stop_time))
        yield from beyond_limits(latest)
    if not (math.isfinite(step) and step * NS_PER_SECOND >= 1):
        text = f"step_size {step:g} s: expected 1e-9 s or more"
        yield ("step_size", text, "give it in seconds, as 0.01, or as '10 ms'")
    elif span > 0 and step > span:
        text = f"step_size {step:g} s is longer than the run of {span:g} s"
        yield ("step_size", text, f"take {span:g} s or less, or a longer run")
    interval = simulation.output_interval
    if interval is not None and not abs(interval) <= LONGEST_RUN:
        text = f"output_interval {interval:g} s: expected a multiple of step_size"
        yield ("output_interval", text, "leave it out for a row after every step")
    elif interval is not None and step <= LONGEST_RUN and not _is_multiple(interval, step):
        count = nanoseconds(interval) / simulation.step_ns
        text = f"output_interval {interval:g} s is not a multiple of step_size {step:g} s"
        remedy = f"take {max(1, round(count)) * step:g} s, or leave it out"
        if not is_whole(step):
            text += f", which is one of {simulation.step_ns} ns: steps are whole nanoseconds"
            remedy = "take a step_size of whole nanoseconds, or leave output_interval out"
        yield ("output_interval", text, remedy)
    for key in CHECKPOINTS:
        interval = getattr(simulation, key)
        if interval is not None and not 0 < interval <= LONGEST_RUN:
            text = f"{key} {interval:g} s: expected a time above 0"
            yield (key, text, "leave it out for a run without checkpoints")
    for key in TOLERANCES:
        tolerance = getattr(simulation, key)
        if tolerance is not None and not 0 < tolerance < 1:
            text = f"{key} {tolerance:g}: expected a number between 0 and 1"
            yield (key, text, "1e-6 is usual")
    if simulation.algorithm not in algorithm_names():
        text = f"unknown algorithm {simulation.algorithm!r}"
        yield ("algorithm", text, suggestion(simulation.algorithm, algorithm_names()))


def _is_multiple(interval: float, step: float) -> bool:
    """True if `interval` is a multiple of `step`, or `step` [s] is less than a nanosecond."""
    whole, part = nanoseconds(interval), nanoseconds(step)
    return step * NS_PER_SECOND < 1 or (whole >= part and whole % part == 0)


def is_whole(time: float) -> bool:
    """True for a time [s] of whole nanoseconds."""
    return abs(time * NS_PER_SECOND - nanoseconds(time)) < ODD
