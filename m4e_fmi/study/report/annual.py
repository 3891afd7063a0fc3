"""Means by probability, energies of a year, and what each state contributes to them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.report.web.markup import paragraph, table
from m4e_fmi.study.report.result import StudyResult
from m4e_fmi.study.shown.over_states import (
    MEGAWATT_HOUR,
    NO_MEAN,
    POWERS,
    YEAR,
    Averaged,
    is_power,
    over_states,
    shown_unit,
)

MARK = " by state"


@dataclass(frozen=True)
class Contribution:
    """Contribution of each state to a sum over all: `values` (designs…) in `unit`.

    They are computed from the quantity `of`.
    """

    name: str
    of: str
    unit: str
    text: str
    values: np.ndarray = field(repr=False)


def contributions(result: StudyResult) -> list[Contribution]:
    """Probability times value of each quantity; of mean powers the energy of a year in MWh."""
    states, found = result.states, []
    for name, told in result.record.wanted.items():
        if states is None or told.statistic in NO_MEAN:
            continue
        designs = result.designs(name)
        mean, names = designs.mean, [axis.name for axis in designs.axes]
        order = [states.names.index(name) for name in names if name in states.names]
        shape = [len(axis) if axis.name in states.names else 1 for axis in designs.axes]
        shares = states.shares.transpose(order).reshape(shape)
        if is_power(told, unit := result.units[name]):
            text = f"Probability times {name} times 8766 h"
            values = shares * mean * POWERS[unit] * YEAR / MEGAWATT_HOUR
            found.append(Contribution(f"energy of a year{MARK}: {name}", name, "MWh", text, values))
        else:
            text = f"Probability times {told}"
            found.append(Contribution(f"{name}{MARK}", name, unit, text, shares * mean))
    return found


def of_all_states(result: StudyResult) -> Iterator[tuple[str, str, str, Averaged]]:
    """Quantities and what of all states is told of them, with units and values of the designs.

    Energies of a year come first.
    """
    if (states := result.states) is None:
        return
    for name, wanted in result.record.wanted.items():
        unit = result.units[name]
        numbers = over_states(result.grid, result.numbers[name], states, wanted, unit)
        yield from ((name, *one) for one in reversed(numbers))


def annual(result: StudyResult) -> str:
    """A table of one number over all states for each design beside them, as HTML."""
    states = result.states
    if states is None:
        return ""
    others = [one for one in states.rest(result.grid.axes) if not one.repeats]
    rows = []
    for name, told, unit, values in of_all_states(result):
        scale, shown = shown_unit(values, unit)
        for place in np.ndindex(values.mean.shape):
            points = [result.point(one, k) for one, k in zip(others, place, strict=True)]
            value = f"{values.scaled(scale).cell(place)} {shown}".rstrip()
            rows.append((name, told, *points, value))
    caption = f"Sum of all probabilities: {float(np.nansum(states.shares)):.6g}."
    heads = ["quantity", "over all states", *(one.name for one in others), "value"]
    text = (
        "With seeds ± 95 % confidence: of sums by those of each seed, which all states share. *: "
        "for seeds that failed in a state stands the mean of the others there."
    )
    body = table(caption, heads, rows, texts=len(heads) - 1)
    return paragraph(text, "note") + body
