"""Records in pictures: a fitted free decay, and a comparison of two files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.style import COLOURS, GREY, plain, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from m4e_fmi.analysis.comparison import Comparison, Difference
    from m4e_fmi.analysis.decay import Decay
    from m4e_fmi.results.compared_file import Measured

MOST_POINTS = 400
"""Rows up to which the record is drawn as points."""


def plot_decay(decay: Decay, motion: Measured, picture: str | Path) -> Path:
    """Draw a fit to `picture`. InputError if no picture has such a suffix."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.5), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1.7, 1], height_ratios=[2.4, 1])
    record, residual = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    residual.sharex(record)
    damping = figure.add_subplot(grid[:, 1])
    _draw_record(record, decay, motion)
    residual.plot(decay.time, decay.residual, color=COLOURS[0], lw=0.9)
    residual.set_ylabel(f"record - fit [{motion.unit}]", fontsize=9)
    residual.set_xlabel("time [s]", fontsize=9)
    text = f"{100 * decay.residual_share:.2g} % of the release (root mean square)"
    residual.set_title(text, fontsize=8, loc="right", color=GREY)
    _draw_damping(damping, decay, motion.unit)
    for axis in (record, residual, damping):
        plain(axis)
    period, ratio = decay.period, decay.damping_ratio
    figure.suptitle(
        f"{shortened(motion.path.name)}, {shortened(motion.name)}: period {period} s, "
        f"linear damping ratio {ratio}",
        fontsize=11,
    )
    return save(figure, picture)


def _draw_record(axis: Axes, decay: Decay, motion: Measured) -> None:
    few = len(decay.time) < MOST_POINTS
    before = motion.time <= decay.window.start
    after = motion.time >= decay.window.end
    for part in (before, after):
        if part.sum() > 1:
            axis.plot(motion.time[part], motion.values[part], color=GREY, lw=0.9)
    axis.plot(
        decay.time, decay.motion, color=COLOURS[0], label="record", alpha=0.6,
        lw=0.0 if few else 2.2, marker="." if few else "", ms=3,
    )  # fmt: skip
    axis.plot(decay.time, decay.fitted, color=COLOURS[1], lw=0.9, label="fit")
    axis.plot(decay.peaks.time, decay.peaks.values, "o", color=COLOURS[3], ms=4, label="peaks")
    axis.axhline(decay.rest.value, color=GREY, lw=0.7, ls="--", label="rest")
    axis.set_ylabel(f"{shortened(motion.name)} [{motion.unit}]", fontsize=9)
    axis.legend(fontsize=8, frameon=False, ncols=4, loc="upper right")


def _draw_damping(axis: Axes, decay: Decay, unit: str) -> None:
    """Damping ratios of neighbouring peaks, and that of the fit with two standard errors."""
    peaks = decay.peaks
    largest = max([decay.release, *peaks.between.tolist()])
    amplitudes = np.linspace(0.0, largest, 41)
    found = [decay.equivalent_ratio(float(a)) for a in amplitudes]
    middle = np.array([f.value for f in found])
    spread = np.array([2.0 * f.error for f in found])
    axis.fill_between(
        amplitudes, middle - spread, middle + spread, color=COLOURS[1], alpha=0.15, lw=0,
        label="± 2 standard errors",
    )  # fmt: skip
    axis.plot(amplitudes, middle, color=COLOURS[1], lw=1.2, label="fit: ζ + 4/(3π) b a")
    axis.plot(peaks.between, peaks.ratios, "o", color=COLOURS[3], ms=5, label="from two peaks")
    shown = [*peaks.ratios.tolist(), *middle.tolist(), 0.0]
    room = 0.15 * (max(shown) - min(shown)) or 1.0
    axis.set_ylim(min(shown) - (room if min(shown) < 0.0 else 0.0), max(shown) + room)
    axis.set_xlim(0.0, 1.03 * largest)
    axis.set_xlabel(f"amplitude a [{unit}]", fontsize=9)
    axis.set_ylabel("damping ratio (logarithmic decrement of half a period over π)", fontsize=9)
    axis.legend(fontsize=8, frameon=False, loc="lower right")


MOST_SHOWN = 8
"""Variables in a picture: those with the largest differences."""


def plot_differences(found: Comparison, picture: str | Path) -> Path:
    """Draw a comparison to `picture`. InputError if no picture has such a suffix."""
    from matplotlib.figure import Figure

    shown = [one for one in found.worst if len(one.time)][:MOST_SHOWN]
    figure = Figure(figsize=(11, 1.2 + 1.6 * max(1, len(shown))), layout="constrained")
    grid = figure.subplots(max(1, len(shown)), 2, squeeze=False, sharex=True)
    for (records, differences), one in zip(grid, shown, strict=False):  # without rows: empty axes
        reference = f"reference, {shortened(found.reference.name)}"
        records.plot(one.time, one.reference, color=GREY, lw=2.2, alpha=0.55, label=reference)
        own = shortened(found.path.name)
        records.plot(one.time, one.values, color=COLOURS[0], lw=0.9, label=own)
        records.set_ylabel(f"{shortened(one.name)}\n[{one.unit}]", fontsize=8)
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


def _draw_difference(axis: Axes, one: Difference, found: Comparison) -> None:
    axis.plot(one.time, one.difference, color=COLOURS[1], lw=0.9)
    axis.set_ylabel(f"difference [{one.unit}]", fontsize=8)
    text = f"RMS {100 * one.rms_share:.3g} %, largest {100 * one.largest_share:.3g} %"
    axis.set_title(f"{text} of the {found.relative_to}", fontsize=8, loc="right", color=GREY)
    if found.tolerance is not None and one.scale > 0.0:
        limit = found.tolerance * one.scale
        for level in (-limit, limit):
            axis.axhline(level, color=GREY, lw=0.8, ls="--")
