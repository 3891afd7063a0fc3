"""The report of a result file of a study: `report_of_study`."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.files.writing import check_suffix, written
from m4e_fmi.report.run_report.of_run import SUFFIX, report_of_run
from m4e_fmi.report.web.markup import paragraph
from m4e_fmi.report.web.shell import HERE, Page, PageSection, page_text, text_of
from m4e_fmi.results.results_file import is_of_study
from m4e_fmi.study.report.annual import annual, contributions
from m4e_fmi.study.report.content import content_of
from m4e_fmi.study.report.result import StudyResult, load_study_result
from m4e_fmi.study.report.summary import figures, numerics, reproduction, warnings

OWN = "m4e_fmi.study.report"
SCRIPTS = ("dims.js", "maps.js", "scatter.js", "numbers.js", "runs.js", "study_report.js")


def report_of_study(results: str | Path, path: str | Path, *, command: str = "") -> Path:
    """Write the report of the result file of a study (.nc) to `path` (.html).

    The page needs nothing else. `command` is the command line of the study. InputError for a file
    that is missing, damaged, or no result of a study; RunError if the report cannot be written.
    """
    path = Path(path)
    check_suffix(path, (".html",), "a report")
    text = page_text(_page(load_study_result(Path(results)), command))
    with written(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def _page(result: StudyResult, command: str) -> Page:
    contributed = contributions(result)
    content = content_of(result, contributed)
    sections = [PageSection("warnings", "Warnings", warnings(result))]
    if result.record.wanted:
        body = figures(result) + text_of(OWN, "maps.html")
        sections.insert(0, PageSection("results", "Results", body))
    if contributed:
        body = annual(result) + text_of(OWN, "maps.html")
        sections.append(PageSection("states", "Over all states", body))
    if result.record.wanted:
        sections.append(PageSection("scatter", "Scatter of runs", text_of(OWN, "scatter.html")))
    kind = "exactly (Float64)" if content.exact else "rounded to seven digits (Float32)"
    told = paragraph(f"The page has all numbers {kind}.", "note")
    sections.append(PageSection("numbers", "Numbers", text_of(OWN, "numbers.html") + told))
    if result.record.series and not result.series:
        told = "Series are in the result file only: each run has rows at times of its own."
        sections.append(PageSection("histories", "Time histories", paragraph(told)))
    if result.series:
        sections.append(PageSection("histories", "Time histories", _runs(result)))
        sections.append(PageSection("spectra", "Spectra", text_of(HERE, "spectra.html")))
    sections.append(PageSection("numerics", "Numerics", numerics(result), folded=True))
    made_of = reproduction(result, command)
    sections.append(PageSection("inputs", "Reproduction", made_of, folded=True))
    return Page(
        title=result.attribute("title") or result.path.stem,
        subtitle=f"Study of {result.grid.count:,} runs, report of m4e_fmi",
        sections=sections,
        data=content.data,
        styles=[text_of(OWN, "study_report.css")],
        scripts=[text_of(OWN, name) for name in SCRIPTS],
        blocks=content.blocks,
    )


def _runs(result: StudyResult) -> str:
    """Plots of whole series, and of which runs the page has them."""
    found = result.series
    assert found is not None
    told = f"Series of {len(found.runs):,} runs are in this page."
    if len(found.runs) < found.all_runs:
        told = (
            f"Series of {len(found.runs):,} of {found.all_runs:,} runs are in this page, at even "
            "distances; the result file has all."
        )
    html = text_of(OWN, "runs.html").replace("@histories@", text_of(HERE, "histories.html"))
    return html + paragraph(told, "note")


def write_report(results: str | Path, path: str | Path | None = None) -> Path:
    """Write the report of the results of a run, a simulation or a study; returns its path.

    `results` is their netCDF file, also of a run that goes on, was killed or has failed. `path` is
    the page (.html), by default beside the results with ``.report.html`` in place of their suffix.
    InputError for a file of another kind, one that is damaged, or one that has no rows; RunError
    if the page cannot be written.
    """
    file = as_path(results)
    page = file.with_suffix(SUFFIX) if path is None else Path(path)
    report = report_of_study if is_of_study(file) else report_of_run
    return report(file, page)
