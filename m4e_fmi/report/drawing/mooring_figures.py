"""Mooring lines in pictures: at rest, and what they go through in a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import count, takewhile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.report.drawing.style import BODY_COLOURS, GREY, GRID, INK, plain, save
from m4e_fmi.results.results_file import load_results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from m4e_fmi.analysis.mooring_data import MooringData


def plot_mooring(data: MooringData, picture: str | Path) -> Path:
    """Draw profiles, a view from above, and pull and tensions by offset.

    Offsets have a row of two for each direction. InputError if no picture has such a suffix.
    """
    from matplotlib.figure import Figure

    rows = 1 + len(data.curves)
    figure = Figure(figsize=(11, 0.8 + 2.9 * rows), layout="constrained")
    axes = figure.subplots(rows, 2, squeeze=False)
    side, above = axes[0]
    for k, line in enumerate(data.lines):
        style = {"color": BODY_COLOURS[k % len(BODY_COLOURS)], "lw": 1.4, "label": line.name}
        x, y, z = (line.nodes - data.about).T
        side.plot(np.hypot(x, y), z + data.about[2], **style)
        above.plot(*line.nodes[:, :2].T, **style)
        above.plot(*line.nodes[0, :2], "s", color=style["color"], ms=4)
    side.axhline(data.bed, color=GREY, lw=1.0)
    side.axhline(0.0, color=GREY, lw=0.6, ls="--")
    side.set(xlabel="horizontal distance [m]", ylabel="z [m]")
    above.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", adjustable="datalim")
    above.legend(fontsize=7, frameon=False)
    for curve, (pull, tension) in zip(data.curves, axes[1:], strict=True):
        pull.plot(curve.offsets, curve.pull / 1e3, color=INK, lw=1.4)
        pull.set(ylabel="pull back [kN]", title=f"towards {np.degrees(curve.direction):.4g} deg")
        for k in range(len(data.lines)):
            colour = BODY_COLOURS[k % len(BODY_COLOURS)]
            tension.plot(curve.offsets, curve.tensions[:, k] / 1e3, color=colour, lw=1.4)
        for strength in {line.strength for line in data.lines if line.strength == line.strength}:
            tension.axhline(strength / 1e3, color=GREY, lw=0.9, ls="--")
        tension.set(ylabel="largest tension [kN]")
        for axis in (pull, tension):
            axis.set_xlabel("offset [m]")
    return _finished(figure, f"{data.title}: mooring lines at rest", picture)


def plot_lines(results: str | Path, picture: str | Path, *, times: Sequence[float] = ()) -> Path:
    """Draw where the mooring lines of a run were, and the tensions along them: a row a line.

    Bands are between the least and the largest value of each node, lines in grey the means.
    Profiles are those of the rows nearest to `times` [s], by default of that with the largest
    tension. InputError if the results lack the nodes of lines, or a time.
    """
    from matplotlib.figure import Figure

    run = load_results(results)
    lines = {
        (component, name.removesuffix(".tension[1]")): members
        for component, members in run.components.items()
        for name in members
        if name.endswith(".tension[1]") and name.replace("tension", "node_z") in members
    }
    if not lines:
        message = f"{results} has no nodes of mooring lines"
        raise InputError.single(message, "run the system with --variables 'mooring.*' or '*'")
    first, last = run.time[0], run.time[-1]
    if wrong := [t for t in times if not first <= t <= last]:
        message = f"{results} has no time {wrong[0]:g} s"
        raise InputError.single(message, f"take times from {first:g} to {last:g} s")
    figure = Figure(figsize=(11, 0.8 + 2.9 * len(lines)), layout="constrained")
    rows = figure.subplots(len(lines), 2, squeeze=False)
    for ((component, line), members), (side, along) in zip(lines.items(), rows, strict=True):
        x, y, z, tension = (
            _nodes(members, f"{line}.{what}") for what in ("node_x", "node_y", "node_z", "tension")
        )
        away = np.hypot(x - x[:, :1], y - y[:, :1])
        part = np.linspace(0, 100, tension.shape[1])
        _band(side, away.mean(axis=0), z)
        _band(along, part, tension / 1e3)
        wanted = times or [run.time[np.unravel_index(tension.argmax(), tension.shape)[0]]]
        for n, k in enumerate(np.abs(run.time - t).argmin() for t in wanted):
            style = {"color": BODY_COLOURS[n % len(BODY_COLOURS)], "lw": 1.2}
            side.plot(away[k], z[k], label=f"t = {run.time[k]:.6g} s", **style)
            along.plot(part, tension[k] / 1e3, **style)
        side.legend(fontsize=7, frameon=False)
        side.set(title=f"{component}.{line}", ylabel="z [m]")
        side.set_xlabel("horizontal distance from the end 'from' [m]")
        along.set(xlabel="part of the length from there [%]", ylabel="tension [kN]")
    return _finished(figure, f"{run.attributes.get('title', '')}: mooring lines", picture)


def _nodes(members: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Values (rows, nodes) of ``name[1]``, ``name[2]``, …"""
    names = takewhile(members.__contains__, (f"{name}[{k}]" for k in count(1)))
    return np.column_stack([members[one] for one in names])


def _band(axis: Axes, x: np.ndarray, values: np.ndarray) -> None:
    """Draw least, mean and largest `values` (rows, nodes) over `x` (nodes,)."""
    axis.fill_between(
        x, values.min(axis=0), values.max(axis=0), color=GRID, label="least to largest"
    )
    axis.plot(x, values.mean(axis=0), color=GREY, lw=1.0, label="mean")


def _finished(figure: Figure, title: str, picture: str | Path) -> Path:
    for axis in figure.axes:
        plain(axis)
        for text in (axis.xaxis.label, axis.yaxis.label, axis.title):
            text.set_fontsize(9)
    figure.suptitle(title, fontsize=11)
    return save(figure, picture)
