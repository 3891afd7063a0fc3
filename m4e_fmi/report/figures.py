"""Time histories as PNG files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from m4e_fmi.report.panels import Panel, moving, panels
from m4e_fmi.report.pictures import save
from m4e_fmi.report.style import COLOURS
from m4e_fmi.results import Series, load

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation

ZOOM = 60.0  # s shown in the right column
LEGEND_COLUMNS = 3


def plot_run(results: str | Path, picture: Path) -> Path:
    """Draw a run's results file to `picture` (PNG): the whole run, and its last minute."""
    loaded = load(results)
    shown = moving(panels(loaded.series))
    return _draw(loaded.attributes.get("title", ""), loaded.time, shown, picture)


def plot_simulation(simulation: Simulation, picture: Path) -> Path:
    """Draw a simulation's states and outputs to `picture` (PNG)."""
    series = {
        name: Series(name, variable.unit, variable.description, simulation.values[name])
        for name, variable in simulation.variables.items()
        if not variable.local
    }
    return _draw(simulation.program.name, simulation.time, moving(panels(series)), picture)


def _draw(title: str, time: np.ndarray, shown: list[Panel], picture: Path) -> Path:
    from matplotlib.figure import Figure

    zoomed = bool(len(time)) and time[-1] - time[0] > 2 * ZOOM
    columns = 2 if zoomed else 1
    figure = Figure(figsize=(11, 1.2 + 1.75 * max(1, len(shown))), layout="constrained")
    axes = figure.subplots(
        max(1, len(shown)),
        columns,
        squeeze=False,
        sharex="col",
        sharey="row",
        gridspec_kw={"width_ratios": [2.4, 1] if zoomed else [1]},
    )
    for row, panel in zip(axes, shown, strict=False):
        for axis in row:
            _fill(axis, time, panel)
        row[0].set_ylabel(f"{panel.title}\n[{panel.unit}]" if panel.title else f"[{panel.unit}]")
        row[0].legend(
            handles=_by_rows(row[0].get_lines()), loc="upper left", ncols=LEGEND_COLUMNS,
            fontsize=7, frameon=False, borderaxespad=0.1,
        )  # fmt: skip
        low, high = row[0].get_ylim()
        row[0].set_ylim(low, high + 0.22 * (high - low))  # room for the legend
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    if zoomed:
        axes[0][1].set_xlim(time[-1] - ZOOM, time[-1])
        axes[0][1].set_title(f"last {ZOOM:g} s", fontsize=9, loc="left", color="#5b6770")
    if len(time):
        axes[0][0].set_xlim(time[0], time[-1])
    axes[0][0].set_title(title, fontsize=11, loc="left", fontweight="bold")
    return save(figure, picture)


def _by_rows(lines: Sequence[Any]) -> list[Any]:
    """`lines` in the order in which a legend, which fills its columns, reads from left to right."""
    return [line for column in range(LEGEND_COLUMNS) for line in lines[column::LEGEND_COLUMNS]]


def _fill(axis: Any, time: np.ndarray, panel: Panel) -> None:
    for colour, (name, series) in zip(COLOURS, panel.series.items(), strict=False):
        offset = series.values[0] if panel.from_start and len(series.values) else 0.0
        axis.plot(time, panel.scale * (series.values - offset), color=colour, lw=0.9, label=name)
    axis.grid(color="#d8dde2", lw=0.5)
    axis.tick_params(labelsize=8)
    axis.margins(x=0)
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
