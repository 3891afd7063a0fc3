"""The record of a study that its results carry for reports, in the attribute `record`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

from m4e_fmi.cosim.results.run_record import system_inputs
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.doctor import versions
from m4e_fmi.errors import InputError
from m4e_fmi.report.run_report.record import InputFile, input_file, read_record
from m4e_fmi.study.given.study import Study, Wanted
from m4e_fmi.study.record import Record
from m4e_fmi.study.shown.warnings import warning_lines

ATTRIBUTE = "record"
FORMAT = 2
REMEDY = "run the study again: its kept runs are not made anew"


@dataclass(frozen=True)
class StudyRecord:
    """All that the numbers of a study do not tell.

    `wanted` are quantities by name, `series` variables that are kept whole, `repeats` dimensions
    of other seeds; `coupling_at` is the place of the largest coupling error; `made` and `kept`
    count runs [1]. `inputs` are files, `versions` those of Python, packages and the platform.
    """

    format: int = FORMAT
    wanted: dict[str, Wanted] = field(default_factory=dict)
    series: tuple[str, ...] = ()
    repeats: tuple[str, ...] = ()
    coupling_at: str = ""
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    made: int = 0
    kept: int = 0
    inputs: tuple[InputFile, ...] = ()
    versions: dict[str, str] = field(default_factory=dict)


def carried_record(
    study: Study,
    records: Sequence[Record],
    *,
    inputs: Sequence[InputFile],
    kept: int,
    warnings: Mapping[str, int],
    notes: Sequence[str],
) -> dict[str, str]:
    """The attribute by which results carry the record of a study that has ended.

    `inputs` are the files that it was made of, as they were when it began.
    """
    known = [one for one in records if not math.isnan(one.coupling_error)]
    worst = max(known, key=lambda one: one.coupling_error, default=None)
    record = StudyRecord(
        wanted={one.name: one for one in study.wanted},
        series=study.series,
        repeats=tuple(axis.name for axis in study.grid.axes if axis.repeats),
        coupling_at=worst.coupling_at if worst else "",
        warnings=tuple(warning_lines(warnings)),
        notes=tuple(notes),
        made=study.grid.count - kept,
        kept=kept,
        inputs=tuple(inputs),
        versions=versions(),
    )
    return {ATTRIBUTE: json.dumps(asdict(record), separators=(",", ":"))}


def inputs_of(study: Study) -> tuple[InputFile, ...]:
    """Files that a study is made of, but its own, whose text is an attribute of the results."""
    if study.is_model:
        found = input_file(study.source, study.source.name)
        return (found,) if found else ()
    return system_inputs(load_system(study.source))


def record_of(attributes: Mapping[str, object], path: str) -> StudyRecord:
    """The record in the attributes of the results at `path`.

    InputError if there is none, or if it is damaged or of a newer m4e_fmi.
    """
    if ATTRIBUTE not in attributes:
        raise InputError.single("it is no result of a study, or an old one", REMEDY, path)
    return read_record(StudyRecord, str(attributes[ATTRIBUTE]), FORMAT, path, REMEDY)
