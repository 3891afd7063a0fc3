"""Steps of components: several in a macro step, or one in several macro steps.

A component may have a step of its own, h, beside the macro step H of the system. Either H = n h: it
makes n steps in each macro step; or h = m H: it makes one in every m-th. Its points are then points
of the system, or lie between them at equal distances, and never drift away from them: they are
integers, converted to floating point only where the FMU is called. Where h = p/q H is neither, the
system steps by the longest part of H that meets all points (`common_step`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.units import parse_unit

NS_PER_SECOND = 1_000_000_000
"""Nanoseconds, in which the master counts time."""
FINEST = 10
"""Most parts into which the given step of a system is divided to meet the points of all."""
HUGE = re.compile(r"e[+-]?\d{3}", re.IGNORECASE)
"""An exponent that no step has, and that takes forever as a fraction."""
TIMES = "give a number of seconds, or a text as '10 ms' or '1/3 ms', a blank before the unit"
"""Remedy for a text that is not a duration."""
DIGITS = 5e-6
"""Relative error of a step written in decimals: 0.000333333 s is a third of 1 ms."""


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


def common_step(
    macro: Fraction, steps: Mapping[str, Fraction]
) -> tuple[Fraction, dict[str, Problem]]:
    """The longest step [s], `macro` or a part of it, to which all own `steps` of components fit.

    It is of whole nanoseconds. Own steps that fit to no such step, or to none of reasonable length,
    have a problem each, by component.
    """
    problems: dict[str, Problem] = {}
    found, before = macro, Fraction(0)
    while found != before:
        before = found
        for name, step in steps.items():
            if name in problems or fits(step, found):
                continue
            finer = _divisor(step, found)
            if macro / finer > FINEST or (finer * NS_PER_SECOND).denominator > 1:
                problems[name] = (
                    _misfit(step, macro) if not fits(step, macro) else _clash(step, steps)
                )
            else:
                found = finer
    return found, problems


def _divisor(a: Fraction, b: Fraction) -> Fraction:
    """The largest number of which both are multiples."""
    whole = math.gcd(a.numerator * b.denominator, b.numerator * a.denominator)
    return Fraction(whole, a.denominator * b.denominator)


def fits(step: Fraction, macro: Fraction) -> bool:
    """True if one of the two is a multiple of the other."""
    ratio = max(step, macro) / min(step, macro)
    return abs(ratio - round(ratio)) <= DIGITS * ratio


def rate(step: Fraction, macro: Fraction, *, constant: bool = False) -> ComponentStep:
    """The step of a component that steps by `step` in a system that steps by `macro` [s].

    InputError if neither is a multiple of the other.
    """
    if not fits(step, macro):
        raise InputError([_misfit(step, macro)])
    count = round(max(step, macro) / min(step, macro))
    if step > macro and count > 1:
        return ComponentStep(float(count * macro), every=count, constant=constant)
    return ComponentStep(float(macro / count), pieces=count, constant=constant)


def _clash(step: Fraction, steps: Mapping[str, Fraction]) -> Problem:
    """The problem of a step that fits to the system's, but not to another component's."""
    other = next(name for name, one in steps.items() if not fits(step, one))
    message = f"step_size {float(step):g} s and {float(steps[other]):g} s of {other!r} do not meet"
    return Problem(message, "take steps of which one is a multiple of the other")


def _misfit(step: Fraction, macro: Fraction) -> Problem:
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
