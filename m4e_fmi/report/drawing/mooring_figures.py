"""Mooring lines at rest in pictures: profiles, from above, tensions and pull by offset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.style import BODY_COLOURS, GREY, INK, plain, save

if TYPE_CHECKING:
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
    for axis in axes.flat:
        plain(axis)
        axis.xaxis.label.set_size(9)
        axis.yaxis.label.set_size(9)
        axis.title.set_size(9)
    figure.suptitle(f"{data.title}: mooring lines at rest", fontsize=11)
    return save(figure, picture)
