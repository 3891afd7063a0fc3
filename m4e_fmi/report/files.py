"""The results file, picture and animation of one simulation, written together."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.locks import claimed
from m4e_fmi.results.results_file import check_export, export, stream_of, write_netcdf
from m4e_fmi.results.row_header import Column, Section

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation


def write_simulation(simulation: Simulation, path: Path) -> list[Path]:
    """Write a simulation to `path`, as a run's results; returns the files that are there now.

    netCDF; for `.csv` and `.parquet` both that and a netCDF file beside it. RunError if a run
    writes to these files.
    """
    check_export(path)
    stream = stream_of(path)
    with claimed(stream):
        _write_netcdf(simulation, stream)
        export(stream, path)
    return list(dict.fromkeys((stream, path)))


def _write_netcdf(simulation: Simulation, path: Path) -> None:
    program, time, values = simulation.program, simulation.time, simulation.values
    columns = tuple(Column(n, v.unit, v.description) for n, v in simulation.variables.items())
    given = simulation.start_values.items()
    attributes = {
        "title": program.name,
        "Conventions": "CF-1.11",
        "method": simulation.method,
        "tolerance": "none" if simulation.tolerance is None else f"{simulation.tolerance:g}",
        "start_values": "\n".join(f"{name} = {value}" for name, value in given),
    }
    rows = np.array([values[column.name] for column in columns]).T
    section = Section(file_stem(program.name), columns)  # a path for netCDF
    write_netcdf(path, [section], attributes, len(time), [(time[:, np.newaxis], rows)])
