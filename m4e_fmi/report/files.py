"""Writing what a simulation gave."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.file_names import file_stem
from m4e_fmi.results import check_export, export, stream_of
from m4e_fmi.writing import netcdf, written

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation


def write_simulation(simulation: Simulation, path: Path) -> list[Path]:
    """Write a simulation to `path`, as a run's results; returns the files that are there now.

    netCDF; for `.csv` and `.parquet` both that and a netCDF file beside it.
    """
    check_export(path)
    stream = stream_of(path)
    _write_netcdf(simulation, stream)
    export(stream, path)
    return list(dict.fromkeys((stream, path)))


def _write_netcdf(simulation: Simulation, path: Path) -> None:
    with written(path) as part, netcdf(part) as file:
        file.setncatts({"title": simulation.program.name, "Conventions": "CF-1.11"})
        file.createDimension("time", len(simulation.time))
        time = file.createVariable("time", "f8", ("time",))
        time.setncatts({"units": "s", "long_name": "simulated time"})
        time[:] = simulation.time
        group = file.createGroup(file_stem(simulation.program.name))  # a path for netCDF
        columns = []
        for name, variable in simulation.variables.items():
            columns.append(group.createVariable(name, "f8", ("time",)))
            columns[-1].setncatts({"units": variable.unit, "long_name": variable.description})
        file.set_auto_maskandscale(False)  # nothing is missing, nothing is packed
        for name, column in zip(simulation.variables, columns, strict=True):
            column[:] = simulation.values[name]  # after all declarations: half the time
