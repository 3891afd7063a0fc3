"""Hydrodynamic coefficients and their fit, and responses to waves, in pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.style import BODY_COLOURS, COLOURS, GREY, INK, plain, save
from m4e_fmi.units import POWER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from m4e_fmi.analysis.hydrodynamic_data import HydrodynamicData
    from m4e_fmi.analysis.response import WaveResponse

MOST_ROWS = 24
TRIFLE = 1e-6  # of the largest of its kind, below which a motion has no row
FAINT = 3e-3  # of the largest excitation, below which its phase is not drawn
HEADS = (
    "added mass A",
    "radiation damping B",
    "memory K(t)",
    "excitation |X|",
    "phase of X",
)


def plot_hydro(data: HydrodynamicData, picture: str | Path) -> Path:
    """Draw A, B, K(t), |X| and its phase of each motion, data as dots and their fit as a line.

    Motions without coefficients have no row. InputError if no picture has such a suffix.
    """
    from matplotlib.figure import Figure

    shown = _shown(data)
    rows = shown[:MOST_ROWS]
    figure = Figure(figsize=(15, 1.3 + 1.9 * max(1, len(rows))), layout="constrained")
    axes = figure.subplots(max(1, len(rows)), len(HEADS), squeeze=False)
    for k, row in zip(rows, axes, strict=False):
        _draw_motion(data, k, row)
    for axis in axes.flat:
        plain(axis)
        axis.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
        axis.yaxis.get_offset_text().set(size=8, color=GREY)
    for head, axis in zip(HEADS, axes[0], strict=True):
        axis.set_title(head, fontsize=10, color=INK, pad=14)
    for column, axis in enumerate(axes[-1]):
        axis.set_xlabel("time [s]" if column == 2 else "angular frequency [rad/s]", fontsize=9)
    axes[0, 0].legend(fontsize=8, frameon=False)
    if len(data.directions) > 1:
        axes[0, 3].legend(fontsize=7, frameon=False, title="waves to", title_fontsize=7)
    title = f"{data.title}: hydrodynamic coefficients, {data.states} states"
    if len(shown) > len(rows):
        title += f" (the first {len(rows)} of {len(shown)} motions)"
    figure.suptitle(title, fontsize=12)
    return save(figure, picture)


def _shown(data: HydrodynamicData) -> list[int]:
    """Motions that have coefficients."""
    kinds = np.array([m.force_unit for m in data.motions])
    mass = np.abs(data.added_mass.diagonal(axis1=1, axis2=2)).max(axis=0)
    force = np.abs(data.excitation).max(axis=(0, 1))
    found = []
    for k, kind in enumerate(kinds):
        same = kinds == kind
        largest = mass[same].max(), force[same].max()
        if mass[k] > TRIFLE * largest[0] or force[k] > TRIFLE * largest[1]:
            found.append(k)
    return found


def _draw_motion(data: HydrodynamicData, k: int, row: np.ndarray) -> None:
    motion, (mass, damping, memory, size, phase) = data.motions[k], row
    fitted = any(k in group.motions for group in data.memories)
    unit = "kg" if motion.unit == "m" else "kg·m²"
    mass.set_ylabel(f"{motion.name}\n[{unit}]", fontsize=9, color=INK)
    force = motion.force_unit.replace(".", "·")
    damping.set_ylabel(f"[{force}·s/{motion.unit}]", fontsize=8)
    memory.set_ylabel(f"[{force}/{motion.unit}]", fontsize=8)
    size.set_ylabel(f"[{force}/m]", fontsize=8)
    phase.set_ylabel("[deg]", fontsize=8)
    blue, red = COLOURS[0], COLOURS[1]
    dots = {"color": blue, "ls": "", "marker": ".", "ms": 4, "label": "data"}
    line = {"color": red, "lw": 1.2, "label": "fit"}
    for axis, values, fit in (
        (mass, data.added_mass, data.fit_added_mass),
        (damping, data.damping, data.fit_damping),
    ):
        axis.plot(data.omega, values[:, k, k], **dots)
        if fitted:
            axis.plot(data.fit_omega, fit[:, k, k], **line)
        axis.set_xlim(0.0, data.omega[-1])
    infinite = float(data.added_mass_inf[k, k])
    mass.axhline(infinite, color=GREY, lw=0.9, ls="--", label="A∞")
    memory.plot(data.time, data.memory[:, k, k], color=blue, lw=2.4, alpha=0.45)
    if fitted:
        memory.plot(data.time, data.fit_memory[:, k, k], color=red, lw=1.2)
    memory.set_xlim(0.0, data.time[-1])
    _draw_excitation(data, k, size, phase)


def _draw_excitation(data: HydrodynamicData, k: int, size: Axes, phase: Axes) -> None:
    largest = np.abs(data.excitation[:, :, k]).max(initial=0.0)
    for d, beta in enumerate(data.directions.tolist()):
        values, colour = data.excitation[:, d, k], COLOURS[d % len(COLOURS)]
        size.plot(data.omega, np.abs(values), color=colour, lw=1.2, label=f"{beta:g}°")
        angles = np.degrees(np.angle(values))
        jumps = np.abs(np.diff(angles, prepend=angles[:1])) > 180.0
        small = np.abs(values) <= FAINT * largest
        width = 1.0 + 0.7 * (len(data.directions) - 1 - d)  # that lines which coincide are seen
        phase.plot(data.omega, np.where(jumps | small, np.nan, angles), color=colour, lw=width)
    size.set_ylim(bottom=0.0)
    phase.set_yticks(range(-180, 181, 90))
    phase.set_ylim(-190, 190)
    for axis in (size, phase):
        axis.set_xlim(0.0, data.omega[-1])


def plot_waves(response: WaveResponse, picture: str | Path) -> Path:
    """Draw amplitudes, phases and mean powers by period to `picture`.

    Outputs of one unit share a row. Of waves in several directions each output has its own, with a
    line for each direction. InputError if no picture has such a suffix.
    """
    from matplotlib.figure import Figure

    shown = range(len(response.outputs))
    several = len(response.directions) > 1
    units = [v.unit for v in response.outputs]
    groups = [[j for j in shown if units[j] == unit] for unit in dict.fromkeys(units)]
    groups = [[j] for j in shown] if several else groups
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
