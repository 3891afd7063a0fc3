"""Means by probability, energies of a year, and what each state contributes to them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from m4e_fmi.report.panels import aligned, quantity
from m4e_fmi.report.web.markup import paragraph, table
from m4e_fmi.statistics.marine import MEGAWATT_HOUR, YEAR, annual_energy
from m4e_fmi.study.given.grid import Axis
from m4e_fmi.study.report.result import StudyResult
from m4e_fmi.study.shown.over_states import NO_MEAN, States

MOST_ROWS = 200
"""Designs of a table; the page's table of numbers has all."""
ENERGIES = ("energy of a year", "standard error")
"""Columns of a table in which some quantity is a mean power."""
MARK = " by state"
NONE = "–"
PREFIXED = ("W", "N", "J", "Pa")
"""Units that get a prefix."""


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
        if _is_power(result, name):
            text = f"Probability times {name} times 8766 h"
            values = shares * mean * YEAR / MEGAWATT_HOUR
            found.append(Contribution(f"energy of a year{MARK}: {name}", name, "MWh", text, values))
        else:
            text = f"Probability times {told.text}"
            unit = result.units[name]
            found.append(Contribution(f"{name}{MARK}", name, unit, text, shares * mean))
    return found


def annual(result: StudyResult) -> str:
    """Tables of means by probability, for each design beside the states, as HTML."""
    states = result.states
    if states is None:
        return ""
    shares = states.shares
    others = [one for one in states.rest(result.grid.axes) if not one.repeats]
    heads = [*(one.name for one in others), "quantity", "mean by probability", *ENERGIES, "states"]
    rows = list(islice(_rows(result, states, others), MOST_ROWS + 1))
    text = (
        "Of each design the mean over all states by probability. Extremes, and loads that do the "
        "same damage, have none: the summary tells what acts over all states."
    )
    if not any(_is_power(result, name) for name in result.record.wanted):
        of_energies = [heads.index(name) for name in ENERGIES]
        heads, *rows = (
            [cell for k, cell in enumerate(row) if k not in of_energies] for row in (heads, *rows)
        )
    else:
        text += (
            " Energies are those of 8766 h of the mean power; their standard error is that over "
            "the sums of each seed, which all states share."
        )
    more = f" The first {MOST_ROWS} rows." if len(rows) > MOST_ROWS else ""
    caption = f"Sum of all probabilities: {float(np.nansum(shares)):.6g}.{more}"
    return paragraph(text, "note") + table(caption, heads, rows[:MOST_ROWS], texts=len(others) + 1)


def _rows(result: StudyResult, states: States, others: Sequence[Axis]) -> Iterator[Sequence[str]]:
    """Rows of the table: quantities of each point of the dimensions that are no states."""
    axes, shares = result.grid.axes, states.shares[states.shares > 0.0]
    seeds = [k for k, axis in enumerate(states.rest(axes)) if axis.repeats]
    found = dict[str, tuple[np.ndarray, np.ndarray]]()
    for name, told in result.record.wanted.items():
        if told.statistic not in NO_MEAN:
            designs, rows = result.designs(name), states.last(axes, result.numbers[name])
            rest = [k for k in range(rows.ndim) if k not in seeds]
            rows = rows.transpose([*rest, *seeds]).reshape((*(rows.shape[k] for k in rest), -1))
            found[name] = rows, states.last(designs.axes, designs.mean)
    for place in np.ndindex(tuple(map(len, others))):
        labels = [one.labels[k] for one, k in zip(others, place, strict=True)]
        for name, (rows, mean) in found.items():
            unit, is_power = result.units[name], _is_power(result, name)
            told = _annual_row(rows[place], mean[place], shares, unit, is_power=is_power)
            yield (*labels, name, *told)


def _annual_row(
    rows: np.ndarray, mean: np.ndarray, shares: np.ndarray, unit: str, *, is_power: bool
) -> tuple[str, str, str, str]:
    """Mean, energy, its error, number of states: of `rows` (states, n_seeds) and their `mean`.

    They are those of the seeds that have values of all states; if none has, of the `mean`.
    """
    counted = shares > 0.0
    count = f"{int(counted.sum())}"
    if lacking := int(np.isnan(mean[counted]).sum()):
        return f"not known: no value of {lacking} state{'s' * (lacking != 1)}", NONE, NONE, count
    whole = np.isfinite(rows[counted]).all(axis=0)  # seeds, as the summary takes them
    seeds = rows[..., whole]
    if not whole.any():
        seeds = mean[..., None]
        count += ", some without failed seeds"
    elif not whole.all():
        count += f", of {int(whole.sum())} of {whole.size} seeds"
    total = float(np.average(seeds[counted].mean(axis=-1), weights=shares[counted]))
    shown = quantity(total, unit) if unit in PREFIXED else f"{aligned(total)[0]} {unit}".rstrip()
    if not is_power:
        return shown, NONE, NONE, count
    energy = annual_energy(seeds, shares, shared_seeds=True)
    error = energy.error / MEGAWATT_HOUR
    return (
        shown,
        f"{aligned(energy.megawatt_hours)[0]} MWh",
        NONE if math.isnan(error) else f"{aligned(error)[0]} MWh",
        count,
    )


def _is_power(result: StudyResult, name: str) -> bool:
    """True for mean powers: their sums over states are energies."""
    return result.units[name] == "W" and result.record.wanted[name].statistic == "mean"
