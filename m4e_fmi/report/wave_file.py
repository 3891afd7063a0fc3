"""Responses to waves as netCDF files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.files.writing import netcdf, written

if TYPE_CHECKING:
    from m4e_fmi.analysis.response import SeaResponse, WaveResponse

CONVENTION = "y = mean + amplitude cos(omega t - phase), crest at x = y = 0 at t = 0"


def write_waves(response: WaveResponse, path: str | Path) -> Path:
    """Write a response to `path`: dimensions direction and period, variables by output.

    Of an output ``x`` there are ``x.amplitude`` per m, ``x.phase``, ``x.mean`` and
    ``x.third_harmonic``.
    """
    with written(path) as part, netcdf(part) as file:
        file.title = response.point.program.name
        file.wave_height = response.height
        file.phase_convention = CONVENTION
        file.notes = "\n".join(response.notes)
        for name, unit, values in (
            ("direction", "rad", response.directions),
            ("period", "s", response.periods),
        ):
            file.createDimension(name, len(values))
            variable = file.createVariable(name, "f8", (name,))
            variable.units = unit
            variable[:] = values
        for j, v in enumerate(response.outputs):
            values = response.values[:, :, j]
            for name, unit, data in (
                ("amplitude", f"({v.unit})/m", np.abs(values)),
                ("phase", "rad", response.phases[:, :, j]),
                ("mean", v.unit, response.means[:, :, j]),
                ("third_harmonic", "1", response.third[:, :, j]),
            ):
                variable = file.createVariable(f"{v.name}.{name}", "f8", ("direction", "period"))
                variable.units, variable.long_name = unit, f"{v.description}: {name}"
                variable[:] = data
    return Path(path)


def write_sea(response: SeaResponse, path: str | Path) -> Path:
    """Write a response to a sea to `path`: the waves of the sea, and statistics by output.

    Of an output ``x`` there are ``x.mean``, ``x.standard_deviation``, ``x.zero_crossing_period``,
    and for each wave ``x.amplitude`` per m and ``x.phase``.
    """
    sea = response.sea
    with written(path) as part, netcdf(part) as file:
        file.title = response.point.program.name
        file.significant_height, file.wave_direction = sea.significant_height, sea.direction
        file.phase_convention = CONVENTION
        file.notes = "\n".join(response.notes)
        file.createDimension("omega", len(sea.omega))
        for name, unit, data in (
            ("omega", "rad/s", sea.omega),
            ("wave_amplitude", "m", sea.amplitudes),
        ):
            variable = file.createVariable(name, "f8", ("omega",))
            variable.units = unit
            variable[:] = data
        for j, v in enumerate(response.outputs):
            values = response.values[:, j]
            for name, unit, dimensions, data in (
                ("mean", v.unit, (), response.means[j]),
                ("standard_deviation", v.unit, (), response.deviations[j]),
                ("zero_crossing_period", "s", (), response.zero_crossing_period(v.name)),
                ("amplitude", f"({v.unit})/m", ("omega",), np.abs(values)),
                ("phase", "rad", ("omega",), np.angle(values)),
            ):
                variable = file.createVariable(f"{v.name}.{name}", "f8", dimensions)
                variable.units, variable.long_name = unit, f"{v.description}: {name}"
                variable[...] = data
    return Path(path)
