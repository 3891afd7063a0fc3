"""Responses to waves as a picture: amplitudes and phases over the period."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.pictures import save
from m4e_fmi.report.drawing.style import BODY_COLOURS, GREY, GRID

if TYPE_CHECKING:
    from m4e_fmi.analysis.response import WaveResponse

POWER = "W"


def plot_waves(response: WaveResponse, picture: Path) -> Path:
    """Draw amplitudes, phases and mean powers by period to `picture`, outputs of one unit together.

    Of waves in several directions, a line each. InputError if no picture has such a suffix.
    """
    from matplotlib.figure import Figure

    units = list(dict.fromkeys(v.unit for v in response.outputs))
    if not response.height:
        units = [unit for unit in units if unit != POWER]
    figure = Figure(figsize=(11, 0.8 + 2.6 * max(1, len(units))), layout="constrained")
    rows = figure.subplots(max(1, len(units)), 2, squeeze=False)
    for unit, row in zip(units, rows, strict=False):
        _draw_unit(response, unit, row)
    for axis in rows.flat:
        axis.grid(color=GRID, lw=0.6)
        axis.tick_params(labelsize=8, colors=GREY)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
        axis.set_xlabel("wave period [s]", fontsize=9)
    waves = f"waves of {response.height:g} m" if response.height else "small waves"
    figure.suptitle(f"{response.point.program.name}: response to {waves}", fontsize=11)
    return save(figure, picture)


def _draw_unit(response: WaveResponse, unit: str, row: np.ndarray) -> None:
    """The outputs of one unit: amplitude or mean on the left, phase on the right."""
    left, right = row
    power = unit == POWER
    marker = "o" if len(response.periods) == 1 else ""
    for j, v in enumerate(response.outputs):
        if v.unit != unit:
            continue
        order = np.argsort(response.periods)
        periods = response.periods[order]
        for d, angle in enumerate(np.degrees(response.directions).tolist()):
            several = len(response.directions) > 1
            label = shortened(v.name) + (f", {round(angle, 6):g} deg" if several else "")
            colour = BODY_COLOURS[(j * len(response.directions) + d) % len(BODY_COLOURS)]
            style = {"color": colour, "lw": 1.4, "marker": marker, "ms": 4, "label": label}
            values = response.values[d, order, j]
            left.plot(periods, response.means[d, order, j] if power else abs(values), **style)
            if not power:
                right.plot(periods, _degrees(values), **style)
    left.set_ylabel("mean [W]" if power else f"[{unit}/m]", fontsize=9)
    left.set_ylim(bottom=None if power else 0.0)
    left.legend(fontsize=7, frameon=False)
    if power:
        right.set_visible(False)
    else:
        right.set_ylabel("behind the crest [deg]", fontsize=9)
        right.set_yticks(range(-180, 181, 90))
        right.set_ylim(-190, 190)


def _degrees(values: np.ndarray) -> np.ndarray:
    """Phases [deg] (k,) of `values` (k,), with a gap (nan) where the line would cross ±180."""
    found = np.degrees(np.angle(values))
    jumps = np.abs(np.diff(found, prepend=found[:1])) > 180.0
    return np.where(jumps, np.nan, found)
