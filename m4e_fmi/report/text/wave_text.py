"""Hydrodynamic coefficients and responses to waves, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.text.point_text import note_lines
from m4e_fmi.shown import columns
from m4e_fmi.units import POWER

if TYPE_CHECKING:
    from m4e_fmi.analysis.hydrodynamic_data import HydrodynamicData
    from m4e_fmi.analysis.response import SeaResponse, WaveResponse
    from m4e_fmi.program import Variable


def hydro_text(data: HydrodynamicData) -> str:
    """Sources, a row for each motion, the memory, its cost, findings."""
    count = len(data.omega)
    lines = [
        f"{data.title}: {len(data.motions)} motions, {count} frequencies from "
        f"{data.omega[0]:.4g} to {data.omega[-1]:.4g} rad/s",
        *(f"  {note}" for note in data.notes),
        "",
        *_motions(data),
        "",
        *_memories(data),
        "",
        "consistency",
    ]
    for name, text, warns in data.findings:
        lines.append(f"  {'warning: ' if warns else ''}{name}: {text}")
    return "\n".join(lines)


def hydro_json(data: HydrodynamicData) -> dict[str, object]:
    """All numbers: SI, directions in deg, matrices by force and motion."""
    return {
        "title": data.title,
        "motions": [m.name for m in data.motions],
        "omega": data.omega.tolist(),
        "added_mass": data.added_mass.tolist(),
        "radiation_damping": data.damping.tolist(),
        "added_mass_inf": data.added_mass_inf.tolist(),
        "hydrostatic_stiffness": data.stiffness.tolist(),
        "directions": data.directions.tolist(),
        "excitation_real": np.real(data.excitation).tolist(),
        "excitation_imaginary": np.imag(data.excitation).tolist(),
        "memories": [
            {
                "motions": [data.motions[k].name for k in memory.motions],
                "poles": memory.poles,
                "states": memory.states,
                "error": memory.error,
                "damping_error": memory.damping_error,
            }
            for memory in data.memories
        ],
        "states": data.states,
        "operations": data.operations,
        "findings": [
            {"name": name, "text": text, "warning": warns} for name, text, warns in data.findings
        ],
        "notes": list(data.notes),
    }


def _motions(data: HydrodynamicData) -> list[str]:
    rows: list[Sequence[str]] = [
        ("motion", "A∞", "A at first", "largest B", "at", "stiffness", "largest |X|", "at"),
        ("[kg, kg.m2, N, N.m, m, rad, s]", "", "", "", "[rad/s]", "", "", "[rad/s]"),
    ]
    for k, motion in enumerate(data.motions):
        damping, force = data.damping[:, k, k], np.abs(data.excitation[:, :, k]).max(axis=1)
        most, top = int(damping.argmax()), int(force.argmax())
        numbers = (
            data.added_mass_inf[k, k], data.added_mass[0, k, k], damping[most], data.omega[most],
            data.stiffness[k, k], force[top], data.omega[top],
        )  # fmt: skip
        rows.append((motion.name, *(f"{number:.4g}" for number in numbers)))
    return columns("<>>>>>>>", *rows)


def _memories(data: HydrodynamicData) -> Iterator[str]:
    if not data.memories:
        yield "  no memory: the forces of radiation could not be fitted, or there are none"
        return
    yield from columns(
        "<>>>>",
        ("memory of", "order", "states", "error", "of damping"),
        *(
            (
                ", ".join(data.motions[k].name for k in memory.motions),
                str(memory.poles),
                str(memory.states),
                f"{100 * memory.error:.2g} %",
                f"{100 * memory.damping_error:.2g} %",
            )
            for memory in data.memories
        ),
    )
    yield (
        f"  cost: {data.states} states, {data.operations} operations for all forces at a time, in "
        "the waves of the component"
    )


PER_TABLE = 4
SMALL = 1e-3
"""Of the largest value of its unit; smaller ones have no relative difference."""


def wave_text(response: WaveResponse) -> str:
    """Amplitudes and phases of outputs by period, a table for each direction."""
    name = response.point.program.name
    waves = f"waves of {response.height:g} m" if response.height else "small waves"
    lines = [
        f"{name}: response to {waves}, per m of amplitude; phases are behind the crest at x = y = 0"
    ]
    harmonic = [j for j, v in enumerate(response.outputs) if v.unit != POWER]
    for d, angle in enumerate(np.degrees(response.directions).tolist()):
        for k in range(0, len(harmonic), PER_TABLE):
            lines += ["", f"waves to {round(angle, 9):g} deg"]
            lines += _harmonics(response, d, harmonic[k : k + PER_TABLE])
        if response.height:
            lines += _means(response, d)
    return "\n".join([*lines, *note_lines(response.notes)])


def sea_text(response: SeaResponse) -> str:
    """Means, standard deviations and zero-crossing periods of outputs."""
    sea = response.sea
    angle = round(float(np.degrees(sea.direction)), 9)
    lines = [
        f"{response.point.program.name}: response to a sea of significant height "
        f"{sea.significant_height:.4g} m and energy period {sea.energy_period:.4g} s "
        f"to {angle:g} deg, linearised for it",
        "",
    ]
    rows = [("", "mean", "deviation", "crossings", "")]
    for v, mean, deviation in zip(
        response.outputs, response.means, response.deviations, strict=True
    ):
        period = response.zero_crossing_period(v.name)
        shown = "" if v.unit == POWER or not np.isfinite(period) else f"{period:.4g} s"
        rows.append((v.name, f"{mean:.6g}", f"{deviation:.6g}", shown, v.unit))
    lines += columns("<>>><", *rows)
    return "\n".join([*lines, *note_lines(response.notes)])


def wave_json(response: WaveResponse) -> dict[str, object]:
    """All numbers of a response: angles in rad, units by output."""
    return {
        "periods": response.periods.tolist(),
        "directions": response.directions.tolist(),
        "height": response.height,
        "notes": list(response.notes),
        "outputs": {
            v.name: {
                "unit": v.unit,
                "amplitude_per_m": _plain(np.abs(response.values[:, :, j])),
                "phase": _plain(response.phases[:, :, j]),
                "mean": _plain(response.means[:, :, j]),
                "third_harmonic": response.third[:, :, j].tolist(),
            }
            for j, v in enumerate(response.outputs)
        },
    }


def sea_json(response: SeaResponse) -> dict[str, object]:
    """All statistics of a response."""
    return {
        "significant_height": response.sea.significant_height,
        "energy_period": response.sea.energy_period,
        "direction": response.sea.direction,
        "notes": list(response.notes),
        "outputs": {
            v.name: {
                "unit": v.unit,
                "mean": mean,
                "standard_deviation": deviation,
                "zero_crossing_period": _number(response.zero_crossing_period(v.name)),
            }
            for v, mean, deviation in zip(
                response.outputs,
                response.means.tolist(),
                response.deviations.tolist(),
                strict=True,
            )
        },
    }


def _plain(values: np.ndarray) -> list[list[float | None]]:
    """`values` (d, k), in any unit, as lists; None for nan, which JSON does not have."""
    return [[_number(x) for x in row] for row in values.tolist()]


def _number(x: float) -> float | None:
    return x if np.isfinite(x) else None


def _harmonics(response: WaveResponse, d: int, outputs: Sequence[int]) -> list[str]:
    """Rows of one direction, with amplitude and phase [deg] of `outputs`, a dash where none."""
    heads, units, phases = ["period"], ["[s]"], np.degrees(response.phases[d])
    for v in (response.outputs[j] for j in outputs):
        heads += [_short(v), ""]
        units += [f"[({v.unit})/m]" if "/" in v.unit else f"[{v.unit}/m]", "[deg]"]
    rows = [heads, units]
    for k, period in enumerate(response.periods):
        rows.append([f"{period:.4g}"])
        for j in outputs:
            lag = f"{phases[k, j]:.1f}" if np.isfinite(phases[k, j]) else "-"
            rows[-1] += [f"{abs(response.values[d, k, j]):.5g}", lag]
    return columns(">" * len(heads), *rows)


def _means(response: WaveResponse, d: int) -> list[str]:
    """Rows of one direction, with the means of powers."""
    powers = [j for j, v in enumerate(response.outputs) if v.unit == POWER]
    if not powers:
        return []
    rows = [
        ("period", *(_short(response.outputs[j]) for j in powers)),
        ("[s]", *("mean [W]" for _ in powers)),
    ]
    for k, period in enumerate(response.periods):
        rows.append((f"{period:.4g}", *(f"{response.means[d, k, j]:.6g}" for j in powers)))
    return ["", *columns(">" * (1 + len(powers)), *rows)]


def _short(v: Variable) -> str:
    return v.name if len(v.name) <= 22 else f"…{v.name[-21:]}"
