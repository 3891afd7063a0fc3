"""How often a component steps: so many times in a macro step, or once in so many macro steps.

A component may have a step of its own, h, beside the macro step H of the system. Either H = n h: it
makes n steps in each macro step; or h = m H: it makes one in every m-th. Its points are then points
of the system, or lie between them at equal distances, and never drift away from them: they are
counted, and a number in floating point only where the FMU is called. Where h = p/q H is neither,
the system steps by the longest part of H that meets all points (`common_step`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from m4e_fmi.units import parse_unit

FINEST = 10
"""Times that a system may step, to meet the points of all, in a step that was given for it."""
HUGE = re.compile(r"e[+-]?\d{3}", re.IGNORECASE)
"""In a number that is no step, and takes forever as a fraction."""
TIMES = "give a number of seconds, or a text as '10 ms' or '1/3 ms', a blank before the unit"
"""What to do about a text that is no time."""
DIGITS = 5e-6
"""Relative error of a step that is written down: 0.000333333 s is a third of 1 ms."""


@dataclass(frozen=True)
class ComponentStep:
    """A component's own step [s]: `pieces` in each macro step, or one in `every` so many.

    `constant` is one whose FMU makes no other steps, `adaptive` one in a system whose steps change:
    its own change with them, and `step` is the longest.
    """

    step: float
    pieces: int = 1
    every: int = 1
    constant: bool = False
    adaptive: bool = False

    @property
    def is_sampled(self) -> bool:
        """Whether there are points of the system at which the component does nothing."""
        return self.every > 1

    @property
    def shortens(self) -> bool:
        """Whether the steps of the system may be shorter than usual."""
        return self.is_sampled or not self.constant

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
        if self.is_sampled:
            return f"{how}, once in {self.every} steps"
        return f"{how}, {self.pieces} times in each step" if self.pieces > 1 else how


def seconds(given: float | str) -> Fraction:
    """The time [s] that `given` is: a number of seconds or a text as ``"10 ms"``, ``"1/3 ms"``.

    ValueError, whose arguments are message and remedy, if it is none or not above zero.
    """
    try:
        found = time_of(str(given))
    except ValueError:
        raise ValueError(f"step_size {given!r} is not a valid duration", TIMES) from None
    if found <= 0:
        raise ValueError(f"step_size {given!r}: expected more than 0 s", TIMES)
    return found


def time_of(text: str) -> Fraction:
    """The time [s] that a text is: ``"10 ms"``, ``"1/3 ms"`` or ``"0.1"``; ValueError if none."""
    number, _, unit = text.strip().partition(" ")
    scale = parse_unit(unit.strip() or "s")
    if HUGE.search(number) or not scale.same_dimension(parse_unit("s")):
        raise ValueError(f"{text!r} is not a valid duration")
    try:
        return Fraction(number) * Fraction(str(scale.factor))
    except ZeroDivisionError:
        raise ValueError(f"{text!r} is not a valid duration") from None


def common_step(
    macro: Fraction, steps: Mapping[str, Fraction], tick: Fraction
) -> tuple[Fraction, dict[str, tuple[str, str]]]:
    """The longest step [s], `macro` or a part of it, to which all own `steps` of components fit.

    It is a multiple of `tick` [s]. The own steps that leave no such, or none of reasonable length,
    are told with message and remedy each.
    """
    problems: dict[str, tuple[str, str]] = {}
    found, before = macro, Fraction(0)
    while found != before:
        before = found
        for name, step in steps.items():
            if name in problems or fits(step, found):
                continue
            finer = _divisor(step, found)
            if macro / finer > FINEST or (finer / tick).denominator > 1:
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
    """Whether one of the two goes a whole number of times into the other."""
    ratio = max(step, macro) / min(step, macro)
    return abs(ratio - round(ratio)) <= DIGITS * ratio


def rate(step: Fraction, macro: Fraction, *, constant: bool = False) -> ComponentStep:
    """The rate of a component that steps by `step` in a system that steps by `macro` [s].

    ValueError, whose arguments are message and remedy, if neither is a multiple of the other.
    """
    if not fits(step, macro):
        raise ValueError(*_misfit(step, macro))
    count = round(max(step, macro) / min(step, macro))
    if step > macro and count > 1:
        return ComponentStep(float(count * macro), every=count, constant=constant)
    return ComponentStep(float(macro / count), pieces=count, constant=constant)


def _clash(step: Fraction, steps: Mapping[str, Fraction]) -> tuple[str, str]:
    other = next(name for name, one in steps.items() if not fits(step, one))
    message = f"step_size {float(step):g} s and {float(steps[other]):g} s of {other!r} do not meet"
    return message, "take steps of which one is a multiple of the other"


def _misfit(step: Fraction, macro: Fraction) -> tuple[str, str]:
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
    return message, f"take {fitting}, or for the system {systems}"


def _written(time: Fraction) -> str:
    """A time as one would write it: exact, if it has few digits, else as a fraction."""
    text = f"{float(time):.12g}"
    return f"{text} s" if Fraction(text) == time else f"{time} s"
