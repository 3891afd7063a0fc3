"""Writing what a simulation gave."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.report.figures import plot_simulation

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation


def write_simulation(simulation: Simulation, path: Path) -> list[Path]:
    """Write a simulation to `path` (netCDF, as a run's results) and a PNG beside it."""
    from netCDF4 import Dataset

    path.parent.mkdir(parents=True, exist_ok=True)
    with Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts({"title": simulation.program.name, "Conventions": "CF-1.11"})
        file.createDimension("time", len(simulation.time))
        time = file.createVariable("time", "f8", ("time",))
        time.setncatts({"units": "s", "long_name": "simulated time"})
        time[:] = simulation.time
        group = file.createGroup(simulation.program.name)
        for name, variable in simulation.variables.items():
            column = group.createVariable(name, "f8", ("time",))
            column.setncatts({"units": variable.unit, "long_name": variable.description})
            column[:] = simulation.values[name]
    return [path, plot_simulation(simulation, path.with_suffix(".png"))]
