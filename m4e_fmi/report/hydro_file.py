"""Hydrodynamic coefficients and their fit as a netCDF file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.files.writing import netcdf, written

if TYPE_CHECKING:
    from m4e_fmi.analysis.hydrodynamic_data import HydrodynamicData

CONVENTION = "force = Re[excitation a exp(-i omega t)] of a wave Re[a exp(-i omega t)] at x = y = 0"


def write_hydro(data: HydrodynamicData, path: str | Path) -> Path:
    """Write coefficients, memory and fit to `path`, matrices by force and motion, in SI units."""
    with written(path) as part, netcdf(part) as file:
        file.title = data.title
        file.phase_convention = CONVENTION
        file.notes = "\n".join(data.notes)
        file.findings = "\n".join(f"{name}: {text}" for name, text, _ in data.findings)
        for name, unit, values in (
            ("omega", "rad/s", data.omega),
            ("fit_omega", "rad/s", data.fit_omega),
            ("time", "s", data.time),
            ("direction", "deg", data.directions),
        ):
            file.createDimension(name, len(values))
            variable = file.createVariable(name, "f8", (name,))
            variable.units = unit
            variable[:] = values
        names = np.array([m.name for m in data.motions], dtype=object)
        for axis in ("force", "motion"):
            file.createDimension(axis, len(names))
            file.createVariable(axis, str, (axis,))[:] = names
        pair = ("force", "motion")
        for name, dimensions, values in (
            ("added_mass", ("omega", *pair), data.added_mass),
            ("radiation_damping", ("omega", *pair), data.damping),
            ("added_mass_inf", pair, data.added_mass_inf),
            ("hydrostatic_stiffness", pair, data.stiffness),
            ("fit_added_mass", ("fit_omega", *pair), data.fit_added_mass),
            ("fit_radiation_damping", ("fit_omega", *pair), data.fit_damping),
            ("radiation_irf", ("time", *pair), data.memory),
            ("fit_radiation_irf", ("time", *pair), data.fit_memory),
            ("excitation_real", ("omega", "direction", "force"), np.real(data.excitation)),
            ("excitation_imaginary", ("omega", "direction", "force"), np.imag(data.excitation)),
        ):
            file.createVariable(name, "f8", dimensions, zlib=True)[...] = values
    return Path(path)
