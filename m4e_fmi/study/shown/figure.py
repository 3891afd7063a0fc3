"""Pictures of studies: a map of two dimensions, a curve of one, a histogram of a sample."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.style import BODY_COLOURS, COLOURS, GREY, GRID, save
from m4e_fmi.study.given.grid import Axis
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.run import StudyOutcome
from m4e_fmi.study.shown.over_states import Averaged, averaged, over_states, states_of
from m4e_fmi.study.shown.summary import shown_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BINS = 20
"""Bars of a histogram."""
MOST_WRITTEN = 120
"""Cells of a map whose numbers are written."""


def plot_study(outcome: StudyOutcome, picture: Path) -> Path:
    """Draw each wanted quantity, means over seeds, to `picture`.

    InputError if no picture has such a suffix.
    """
    from matplotlib.figure import Figure

    wanted = outcome.study.wanted
    columns = 1 if len(wanted) == 1 else 2
    rows = max(1, -(-len(wanted) // columns))
    figure = Figure(figsize=(6.4 * columns, 0.6 + 4.2 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False)
    for one, panel in zip(wanted, panels.flat, strict=False):
        name, found = _shown(outcome, one)
        scale, shown = shown_unit(found, outcome.data[one.name].attrs["units"])
        _draw(panel, found.scaled(scale), f"{one.name}{shown}{name}", outcome)
        panel.tick_params(labelsize=8, colors=GREY)
    for panel in list(panels.flat)[len(wanted) :]:
        panel.set_visible(False)
    figure.suptitle(outcome.study.name, fontsize=11)
    return save(figure, picture)


def _shown(outcome: StudyOutcome, wanted: Wanted) -> tuple[str, Averaged]:
    """Values over designs, and what they are in words: over all sea states or cases, if there are.

    Of one design they are those of the states, without words.
    """
    grid, values = outcome.study.grid, outcome.data[wanted.name].values
    found = averaged(grid.axes, values)
    states = states_of(outcome.data)
    if states is None or not states.rest(found.axes):
        return "", found
    name, found = over_states(grid, values, states, wanted)
    return f", {name}", found


def _draw(panel: Axes, found: Averaged, text: str, outcome: StudyOutcome) -> None:
    alone = [axis for axis in found.axes if len(axis) == 1]
    axes = tuple(axis for axis in found.axes if len(axis) > 1) or found.axes[:1]
    shape = tuple(map(len, axes))
    parts = (found.mean, found.half_width, found.missing)
    found = Averaged(axes, *(part.reshape(shape) for part in parts))
    if len(axes) == 1 and len(axes[0].varied) > 1:
        good = found.mean[np.isfinite(found.mean)]
        panel.hist(good, bins=BINS, color=COLOURS[0])
        panel.set_xlabel(text, fontsize=9)
        panel.set_ylabel("runs", fontsize=9)
    elif len(axes) >= 2:
        first = (0,) * (len(axes) - 2)
        rest = ", ".join(
            f"{a.name} {a.labels[0]}" + (f" (the first of {len(a)})" if len(a) > 1 else "")
            for a in (*axes[2:], *alone)
        )
        _map(panel, axes, found.mean[(..., *first)], outcome)
        panel.set_title(f"{text}, {rest}" if rest else text, fontsize=9)
    elif axes:
        _curve(panel, found, text, outcome)
    else:
        panel.bar([text], [float(found.mean)], color=COLOURS[0])


def _label(axis: Axis, outcome: StudyOutcome) -> str:
    attrs = outcome.data[axis.name].attrs
    return f"{axis.name} [{attrs['units']}]" if attrs.get("units", "1") != "1" else axis.name


def _map(panel: Axes, axes: tuple[Axis, ...], values: np.ndarray, outcome: StudyOutcome) -> None:
    """Values (n, m) as colours; cells that have none are white."""
    image = panel.imshow(values, origin="lower", aspect="auto", cmap="viridis")
    for axis, ticks, name in (
        (axes[1], panel.set_xticks, panel.set_xlabel),
        (axes[0], panel.set_yticks, panel.set_ylabel),
    ):
        step = max(1, len(axis) // 12)
        ticks(range(0, len(axis), step), axis.labels[::step])
        name(_label(axis, outcome), fontsize=9)
    assert panel.figure is not None
    panel.figure.colorbar(image, ax=panel, shrink=0.9)
    if values.size > MOST_WRITTEN:
        return
    middle = np.nanmean(values) if np.isfinite(values).any() else 0.0
    for (i, j), value in np.ndenumerate(values):
        if np.isfinite(value):
            colour = "white" if value < middle else "black"
            panel.text(j, i, f"{value:.3g}", ha="center", va="center", fontsize=7, color=colour)


def _curve(panel: Axes, found: Averaged, text: str, outcome: StudyOutcome) -> None:
    """Values over their only axis, with their confidence."""
    (axis,) = found.axes
    at = np.arange(len(axis)) if not axis.is_numbers else np.array(axis.points, float)[:, 0]
    width = np.nan_to_num(found.half_width)
    panel.errorbar(
        at, found.mean, yerr=width, color=BODY_COLOURS[0], marker="o", ms=3, capsize=2, lw=1.2
    )
    if not axis.is_numbers:
        panel.set_xticks(at.tolist(), axis.labels)
    panel.set_xlabel(_label(axis, outcome), fontsize=9)
    panel.set_ylabel(text, fontsize=9)
    panel.grid(color=GRID, lw=0.6)
