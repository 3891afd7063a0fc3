"""A comparison of two files as a picture: each pair of records, and their difference beside it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.style import COLOURS, GREY, plain, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from m4e_fmi.analysis.comparison import Comparison, Difference

MOST_SHOWN = 8
"""Variables in a picture: those with the largest differences."""


def plot_differences(found: Comparison, picture: Path) -> Path:
    """Draw a comparison to `picture`. InputError if no picture has such a suffix."""
    from matplotlib.figure import Figure

    shown = [one for one in found.worst if len(one.time)][:MOST_SHOWN]
    figure = Figure(figsize=(11, 1.2 + 1.6 * max(1, len(shown))), layout="constrained")
    grid = figure.subplots(max(1, len(shown)), 2, squeeze=False, sharex=True)
    for (records, differences), one in zip(grid, shown, strict=False):
        _draw_records(records, one, found)  # without rows in common: empty axes
        _draw_difference(differences, one, found)
    for axis in grid.flat:
        plain(axis)
    grid[0, 0].legend(
        fontsize=8, frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0
    )
    figure.align_ylabels()
    for axis in grid[-1]:
        axis.set_xlabel("time [s]", fontsize=9)
    title = f"{shortened(found.path.name)} beside {shortened(found.reference.name)}"
    if (more := len(found.differences) - len(shown)) > 0:
        title += f": the {len(shown)} largest differences of {len(shown) + more} variables"
    figure.suptitle(title, fontsize=11)
    return save(figure, picture)


def _draw_records(axis: Axes, one: Difference, found: Comparison) -> None:
    reference = f"reference, {shortened(found.reference.name)}"
    axis.plot(one.time, one.reference, color=GREY, lw=2.2, alpha=0.55, label=reference)
    axis.plot(one.time, one.values, color=COLOURS[0], lw=0.9, label=shortened(found.path.name))
    axis.set_ylabel(f"{shortened(one.name)}\n[{one.unit}]", fontsize=8)


def _draw_difference(axis: Axes, one: Difference, found: Comparison) -> None:
    axis.plot(one.time, one.difference, color=COLOURS[1], lw=0.9)
    axis.set_ylabel(f"difference [{one.unit}]", fontsize=8)
    text = f"RMS {100 * one.rms_share:.3g} %, largest {100 * one.largest_share:.3g} %"
    axis.set_title(f"{text} of the {found.relative_to}", fontsize=8, loc="right", color=GREY)
    if found.tolerance is not None and one.scale > 0.0:
        limit = found.tolerance * one.scale
        for level in (-limit, limit):
            axis.axhline(level, color=GREY, lw=0.8, ls="--")
