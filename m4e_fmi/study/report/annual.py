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
from m4e_fmi.study.report.result import Dimension, StudyResult
from m4e_fmi.study.shown.over_states import has_mean_over_states

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
    shares = _shares(result)
    if shares is None:
        return []
    found = []
    for name, told in result.record.wanted.items():
        if not has_mean_over_states(told.statistic):
            continue
        mean = result.designs(name).mean
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
    if result.probability is None:
        return ""
    names, shares = result.probability
    others = [one for one in result.design_dimensions if one.name not in names]
    heads = [*(one.name for one in others), "quantity", "mean by probability", *ENERGIES, "states"]
    rows = list(islice(_rows(result, shares, others), MOST_ROWS + 1))
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


def _rows(
    result: StudyResult, shares: np.ndarray, others: Sequence[Dimension]
) -> Iterator[Sequence[str]]:
    """Rows of the table: quantities of each point of the dimensions that are no states."""
    found = {
        name: (
            _by_state(result, result.by_seeds(result.numbers[name]), extra=1),
            _by_state(result, result.designs(name).mean),
        )
        for name, told in result.record.wanted.items()
        if has_mean_over_states(told.statistic)
    }
    for place in np.ndindex(tuple(one.count for one in others)):
        labels = [one.labels[k] for one, k in zip(others, place, strict=True)]
        for name, (rows, mean) in found.items():
            unit, is_power = result.units[name], _is_power(result, name)
            told = _annual_row(rows[place], mean[place], shares, unit, is_power=is_power)
            yield (*labels, name, *told)


def _annual_row(
    rows: np.ndarray, mean: np.ndarray, shares: np.ndarray, unit: str, *, is_power: bool
) -> tuple[str, str, str, str]:
    """Mean, energy, its error, number of states: of `rows` (states…, n_seeds) and their `mean`.

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


def _by_state(result: StudyResult, values: np.ndarray, extra: int = 0) -> np.ndarray:
    """`values` (designs…, extra…) with the dimensions of the states behind the other ones."""
    assert result.probability is not None
    names = [one.name for one in result.design_dimensions]
    states = [names.index(name) for name in result.probability[0]]
    others = [k for k in range(len(names)) if k not in states]
    last = range(len(names), len(names) + extra)
    return values.transpose((*others, *states, *last))


def _shares(result: StudyResult) -> np.ndarray | None:
    """Probabilities [1] that fit the shape of designs; None without."""
    if result.probability is None:
        return None
    names, shares = result.probability
    order = [one.name for one in result.design_dimensions if one.name in names]
    turned = shares.transpose([names.index(name) for name in order])
    shape = [one.count if one.name in names else 1 for one in result.design_dimensions]
    return turned.reshape(shape)
