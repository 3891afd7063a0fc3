"""The report of any result file, by what it holds: `write_report`."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.report.run_report.of_run import SUFFIX, report_of_run
from m4e_fmi.results.results_file import dimensions_of
from m4e_fmi.study.report.of_study import report_of_study
from m4e_fmi.study.report.result import OF_RUNS


def write_report(results: str | Path, path: str | Path | None = None) -> Path:
    """Write the report of the results of a run, a simulation or a study; returns its path.

    `results` is their netCDF file, also of a run that goes on, was killed or has failed. `path` is
    the page (.html), by default beside the results with ``.report.html`` in place of their suffix.
    InputError for a file of another kind, one that is damaged, or one that has no rows; RunError
    if the page cannot be written.
    """
    file = as_path(results)
    page = file.with_suffix(SUFFIX) if path is None else Path(path)
    found = dimensions_of(file)
    if all(dimensions == ("time",) for dimensions in found.values()):
        return report_of_run(file, page)
    if all(name in found for name in OF_RUNS):  # every study has these
        return report_of_study(file, page)
    over = ", ".join(dict.fromkeys(name for names in found.values() for name in names))
    message = f"has numbers over {over or 'no dimension'}: it is of no run, simulation or study"
    remedy = "give what `m4e-fmi run`, `m4e-fmi simulate` or `m4e-fmi study` has written"
    raise InputError.single(message, remedy, str(file))
