"""The results file, picture and animation of one simulation, written together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.doctor import versions
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.locks import claimed
from m4e_fmi.report.animation.scene import Scene
from m4e_fmi.report.animation.scene_text import carried
from m4e_fmi.report.run_report.record import InputFile, Record, carried_record
from m4e_fmi.results.results_file import check_export, export, stream_of, write_netcdf
from m4e_fmi.results.row_file import ResultColumn, RowSection

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation


def write_simulation(
    simulation: Simulation,
    path: str | Path,
    *,
    scene: Scene | None = None,
    inputs: Sequence[InputFile] = (),
    ended: str = "",
) -> list[Path]:
    """Write a simulation to `path`, as a run's results; returns the files that are there now.

    They carry the `scene`, which says what an animation of them shows, and the `inputs` and
    versions that a report tells of, and how the simulation has `ended` if it did so early.

    netCDF; for `.csv` both that and a netCDF file beside it. RunError if a run
    writes to these files.
    """
    path = Path(path)
    check_export(path)
    stream = stream_of(path)
    program, time, values = simulation.program, simulation.time, simulation.values
    given = simulation.start_values.items()
    attributes = {
        "title": program.name,
        "Conventions": "CF-1.11",
        "method": simulation.method,
        "tolerance": "none" if simulation.tolerance is None else f"{simulation.tolerance:g}",
        "start_values": "\n".join(f"{name} = {value}" for name, value in given),
        **({"ended": ended} if ended else {}),
        **carried(scene),
        **carried_record(Record(inputs=tuple(inputs), versions=versions())),
    }
    sections = _sections(simulation)
    rows = [np.array([values[name] for name in names]).T for _, names in sections]
    only = [section for section, _ in sections]
    with claimed(stream):
        write_netcdf(stream, only, attributes, len(time), [(time[:, np.newaxis], *rows)])
        export(stream, path)
    return list(dict.fromkeys((stream, path)))


def _sections(simulation: Simulation) -> list[tuple[RowSection, list[str]]]:
    """Sections of the results, and the names of their variables in the simulation.

    Each part of a program has its own, as components of a run have; all else is under the program.
    """
    program = simulation.program
    parts = {part.name for part in program.parts}
    rest = file_stem(program.name)  # a path for netCDF
    columns: dict[str, list[ResultColumn]] = {}
    names: dict[str, list[str]] = {}
    for name, v in simulation.variables.items():
        part, _, own = name.partition(".")
        section, own = (part, own) if part in parts else (rest, name)
        columns.setdefault(section, []).append(ResultColumn(own, v.unit, v.description))
        names.setdefault(section, []).append(name)
    return [(RowSection(name, tuple(found)), names[name]) for name, found in columns.items()]
