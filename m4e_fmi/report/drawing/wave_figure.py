"""Responses to waves as a picture: amplitudes and phases over the period."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.style import BODY_COLOURS, plain, save
from m4e_fmi.units import POWER

if TYPE_CHECKING:
    from m4e_fmi.analysis.response import WaveResponse


def plot_waves(response: WaveResponse, picture: str | Path) -> Path:
    """Draw amplitudes, phases and mean powers by period to `picture`.

    Outputs of one unit share a row. Of waves in several directions each output has its own, with a
    line for each direction. InputError if no picture has such a suffix.
    """
    from matplotlib.figure import Figure

    shown = range(len(response.outputs))
    several = len(response.directions) > 1
    groups = [[j] for j in shown] if several else _by_unit(response, shown)
    figure = Figure(figsize=(11, 0.8 + 2.6 * max(1, len(groups))), layout="constrained")
    rows = figure.subplots(max(1, len(groups)), 2, squeeze=False)
    for group, row in zip(groups, rows, strict=False):
        _draw(response, group, row)
    for axis in rows.flat:
        plain(axis)
        axis.set_xlabel("wave period [s]", fontsize=9)
    waves = f"waves of {response.height:g} m" if response.height else "small waves"
    figure.suptitle(f"{response.point.program.name}: response to {waves}", fontsize=11)
    if several and shown:
        lines, names = rows[0, 0].get_legend_handles_labels()
        figure.legend(
            lines, names, title="waves to", loc="outside right upper", fontsize=8, frameon=False
        )
    return save(figure, picture)


def _by_unit(response: WaveResponse, shown: Sequence[int]) -> list[list[int]]:
    """The outputs `shown`, those of one unit together."""
    units = dict.fromkeys(response.outputs[j].unit for j in shown)
    return [[j for j in shown if response.outputs[j].unit == unit] for unit in units]


def _draw(response: WaveResponse, outputs: Sequence[int], row: np.ndarray) -> None:
    """Outputs of one unit: amplitude or mean on the left, phase on the right."""
    left, right = row
    unit = response.outputs[outputs[0]].unit
    order = np.argsort(response.periods)
    periods, several = response.periods[order], len(response.directions) > 1
    colours = _colours(response, outputs)
    counts = False
    for place, j in enumerate(outputs):
        for d, angle in enumerate(np.degrees(response.directions).tolist()):
            name = f"{round(angle, 6):g} deg" if several else response.outputs[j].name
            style = {
                "color": colours[d if several else place],
                "lw": 1.4,
                "marker": "o" if len(periods) < 8 else "",
                "ms": 4,
                "label": shortened(name),
            }
            if unit == POWER:
                left.plot(periods, response.means[d, order, j], **style)
                continue
            phases = response.phases[d, order, j]
            counts |= bool(np.isfinite(phases).any())
            left.plot(periods, abs(response.values[d, order, j]), **style)
            right.plot(*_broken(periods, phases), **style)
    left.set_ylabel("mean [W]" if unit == POWER else f"[{unit}/m]", fontsize=9)
    if several:
        left.set_title(response.outputs[outputs[0]].name, fontsize=9, loc="left")
    else:
        left.legend(fontsize=7, frameon=False)
    if unit == POWER:
        right.set_visible(False)
        return
    left.set_ylim(bottom=0.0, top=None if counts else 1.0)
    right.set_ylabel("behind the crest [deg]", fontsize=9)
    right.set_yticks(range(-180, 181, 90))
    right.set_ylim(-190, 190)


def _colours(response: WaveResponse, outputs: Sequence[int]) -> Sequence[object]:
    """A colour for each direction, in their order, or of one direction for each of the outputs."""
    count = len(response.directions) if len(response.directions) > 1 else len(outputs)
    if len(response.directions) == 1 and count <= len(BODY_COLOURS):
        return BODY_COLOURS
    from matplotlib import colormaps

    return list(colormaps["viridis"](np.linspace(0.0, 0.9, count)))


def _broken(periods: np.ndarray, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`periods` (k,) [s] and `phases` (k,) [rad] in deg, with breaks at ±180."""
    degrees = np.degrees(phases)
    jumps = np.flatnonzero(np.abs(np.diff(degrees)) > 180.0) + 1
    return np.insert(periods, jumps, np.nan), np.insert(degrees, jumps, np.nan)
