"""Time histories as PNG files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import InputError, Problem, unknown_names
from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.style import BODY_COLOURS, DOTS_PER_INCH, GREY, plain, save
from m4e_fmi.report.panels import Panel, by_unit, fitting, moving, panels
from m4e_fmi.results.results_file import Results, Series, load_results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from m4e_fmi.simulate import Simulation

ZOOM = 60.0  # s shown in the right column
LEGEND_COLUMNS = 3
LEGEND_ROW = 0.11  # of a panel's height


def plot_run(results: str | Path, picture: str | Path, *, variables: Sequence[str] = ()) -> Path:
    """Draw a results file to `picture` (PNG): the whole run, and its last minute.

    What people look at first, or the `variables` named, as ``component.variable``. InputError for
    a name that is not there.
    """
    return save(results_figure(load_results(results), variables), picture)


def results_figure(results: Results, variables: Sequence[str] = ()) -> Figure:
    """The same as a figure of matplotlib."""
    shown = _shown(results.series, variables)
    return _draw(results.attributes.get("title", ""), results.time, shown)


def plot_simulation(
    simulation: Simulation, picture: str | Path, *, variables: Sequence[str] = ()
) -> Path:
    """Draw a simulation to `picture` (PNG).

    What people look at first of its states and outputs, or the `variables` named. InputError for a
    name that is not there.
    """
    return save(simulation_figure(simulation, variables), picture)


def simulation_figure(simulation: Simulation, variables: Sequence[str] = ()) -> Figure:
    """The same as a figure of matplotlib."""
    series = {
        name: simulation[name]
        for name, variable in simulation.variables.items()
        if variables or not variable.local
    }
    shown = _shown(series, variables)
    return _draw(simulation.program.name, simulation.time, shown)


def _shown(series: dict[str, Series], variables: Sequence[str]) -> list[Panel]:
    """The panels of the `variables` named; if none is, the usual ones with what fits in them."""
    if not variables:
        return [fitting(panel) for panel in moving(panels(series))]
    problems = unknown_names(variables, series, "there is no variable", "variables")
    problems += [
        Problem(f"{name} is text, which cannot be drawn", "name other variables")
        for name in variables
        if name in series and series[name].recorded.is_text
    ]
    InputError.raise_for(problems)
    return by_unit({name: series[name] for name in variables})


def _draw(title: str, time: np.ndarray, shown: list[Panel]) -> Figure:
    from matplotlib.figure import Figure

    class ShownFigure(Figure):
        """A figure of matplotlib that notebooks show as a picture, without pyplot."""

        def _repr_png_(self) -> bytes:
            picture = io.BytesIO()
            self.savefig(picture, format="png", dpi=DOTS_PER_INCH)
            return picture.getvalue()

    zoomed = bool(len(time)) and time[-1] - time[0] > 2 * ZOOM
    columns = 2 if zoomed else 1
    figure = ShownFigure(figsize=(11, 1.2 + 1.75 * max(1, len(shown))), layout="constrained")
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
        unit = f"[{panel.unit}]" if panel.unit else ""
        row[0].set_ylabel("\n".join(filter(None, (shortened(panel.title), unit))))
        if panel.items:
            row[0].set_yticks(list(panel.items.values()), list(map(shortened, panel.items)))
        lines = row[0].get_lines()  # a legend fills its columns, and is read from left to right
        handles = [line for first in range(LEGEND_COLUMNS) for line in lines[first::LEGEND_COLUMNS]]
        row[0].legend(
            handles=handles, loc="upper left", ncols=LEGEND_COLUMNS,
            fontsize=7, frameon=False, borderaxespad=0.1, handlelength=3,
        )  # fmt: skip
        low, high = row[0].get_ylim()
        rows = -(-len(panel.series) // LEGEND_COLUMNS)
        row[0].set_ylim(low, high + LEGEND_ROW * rows * (high - low))  # room for the legend
        if panel.left_out:
            count = len(panel.series)
            note = f"{count} of {count + panel.left_out} shown, those that vary most"
            row[0].set_title(note, fontsize=8, loc="right", color=GREY)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    if zoomed:
        axes[0][1].set_xlim(time[-1] - ZOOM, time[-1])
        axes[0][1].set_title(f"last {ZOOM:g} s", fontsize=9, loc="left", color="#5b6770")
    if len(time) > 1:
        axes[0][0].set_xlim(time[0], time[-1])
    axes[0][0].set_title(shortened(title), fontsize=11, loc="left", fontweight="bold")
    return figure


def _fill(axis: Axes, time: np.ndarray, panel: Panel) -> None:
    for k, (name, curve) in enumerate(panel.curves.items()):
        colour = BODY_COLOURS[k % len(BODY_COLOURS)]
        drawn = "steps-post" if panel.steps else "default"
        marker = "." if len(time) == 1 else ""
        axis.plot(
            time,
            curve,
            color=colour,
            lw=0.9,
            label=shortened(name),
            drawstyle=drawn,
            marker=marker,
        )
    plain(axis)
    axis.margins(x=0)
