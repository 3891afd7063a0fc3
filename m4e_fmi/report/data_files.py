"""Hydrodynamic coefficients and responses to waves as netCDF files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.files.writing import netcdf, written

if TYPE_CHECKING:
    from m4e_fmi.analysis.hydrodynamic_data import HydrodynamicData
    from m4e_fmi.analysis.response import SeaResponse, WaveResponse

FORCES = "force = Re[excitation a exp(-i omega t)] of a wave Re[a exp(-i omega t)] at x = y = 0"
PHASES = "y = mean + amplitude cos(omega t - phase), crest at x = y = 0 at t = 0"

Variable = tuple[str, str, str, tuple[str, ...], ArrayLike]
"""Name, unit, description, dimensions, values; without a unit or a description where it is ""."""


def write_hydro(data: HydrodynamicData, path: str | Path) -> Path:
    """Write coefficients, memory and fit to `path`, matrices by force and motion, in SI units."""
    pair, excited = ("force", "motion"), ("omega", "direction", "force")
    names = np.array([m.name for m in data.motions], dtype=object)
    variables: list[Variable] = [
        ("omega", "rad/s", "", ("omega",), data.omega),
        ("fit_omega", "rad/s", "", ("fit_omega",), data.fit_omega),
        ("time", "s", "", ("time",), data.time),
        ("direction", "deg", "", ("direction",), data.directions),
        *((axis, "", "", (axis,), names) for axis in pair),
        ("added_mass", "", "", ("omega", *pair), data.added_mass),
        ("radiation_damping", "", "", ("omega", *pair), data.damping),
        ("added_mass_inf", "", "", pair, data.added_mass_inf),
        ("hydrostatic_stiffness", "", "", pair, data.stiffness),
        ("fit_added_mass", "", "", ("fit_omega", *pair), data.fit_added_mass),
        ("fit_radiation_damping", "", "", ("fit_omega", *pair), data.fit_damping),
        ("radiation_irf", "", "", ("time", *pair), data.memory),
        ("fit_radiation_irf", "", "", ("time", *pair), data.fit_memory),
        ("excitation_real", "", "", excited, np.real(data.excitation)),
        ("excitation_imaginary", "", "", excited, np.imag(data.excitation)),
    ]
    attributes = {
        "title": data.title,
        "phase_convention": FORCES,
        "notes": "\n".join(data.notes),
        "findings": "\n".join(f"{name}: {text}" for name, text, _ in data.findings),
    }
    return _write(path, attributes, variables)


def write_waves(response: WaveResponse, path: str | Path) -> Path:
    """Write a response to `path`: dimensions direction and period, variables by output.

    Of an output ``x`` there are ``x.amplitude`` per m, ``x.phase``, ``x.mean`` and
    ``x.third_harmonic``.
    """
    variables: list[Variable] = [
        ("direction", "rad", "", ("direction",), response.directions),
        ("period", "s", "", ("period",), response.periods),
    ]
    for j, v in enumerate(response.outputs):
        variables += [
            (f"{v.name}.{name}", unit, f"{v.description}: {name}", ("direction", "period"), values)
            for name, unit, values in (
                ("amplitude", f"({v.unit})/m", np.abs(response.values[:, :, j])),
                ("phase", "rad", response.phases[:, :, j]),
                ("mean", v.unit, response.means[:, :, j]),
                ("third_harmonic", "1", response.third[:, :, j]),
            )
        ]
    attributes = {
        "title": response.point.program.name,
        "wave_height": response.height,
        "phase_convention": PHASES,
        "notes": "\n".join(response.notes),
    }
    return _write(path, attributes, variables)


def write_sea(response: SeaResponse, path: str | Path) -> Path:
    """Write a response to a sea to `path`: the waves of the sea, and statistics by output.

    Of an output ``x`` there are ``x.mean``, ``x.standard_deviation``, ``x.zero_crossing_period``,
    and for each wave ``x.amplitude`` per m and ``x.phase``.
    """
    sea = response.sea
    variables: list[Variable] = [
        ("omega", "rad/s", "", ("omega",), sea.omega),
        ("wave_amplitude", "m", "", ("omega",), sea.amplitudes),
    ]
    for j, v in enumerate(response.outputs):
        values = response.values[:, j]
        variables += [
            (f"{v.name}.{name}", unit, f"{v.description}: {name}", dimensions, data)
            for name, unit, dimensions, data in (
                ("mean", v.unit, (), response.means[j]),
                ("standard_deviation", v.unit, (), response.deviations[j]),
                ("zero_crossing_period", "s", (), response.zero_crossing_period(v.name)),
                ("amplitude", f"({v.unit})/m", ("omega",), np.abs(values)),
                ("phase", "rad", ("omega",), np.angle(values)),
            )
        ]
    attributes = {
        "title": response.point.program.name,
        "significant_height": sea.significant_height,
        "wave_direction": sea.direction,
        "phase_convention": PHASES,
        "notes": "\n".join(response.notes),
    }
    return _write(path, attributes, variables)


def _write(
    path: str | Path, attributes: Mapping[str, object], variables: Iterable[Variable]
) -> Path:
    """Write variables, of which those named like a dimension give its length."""
    with written(path) as part, netcdf(part) as file:
        file.setncatts(attributes)
        for name, unit, text, dimensions, values in variables:
            if dimensions == (name,):
                file.createDimension(name, len(np.asarray(values)))
            kind = str if np.asarray(values).dtype == object else "f8"
            variable = file.createVariable(name, kind, dimensions, zlib=len(dimensions) > 1)
            variable.setncatts({k: t for k, t in (("units", unit), ("long_name", text)) if t})
            variable[...] = values
    return Path(path)
