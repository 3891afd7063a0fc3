"""Texts of a report of a study: figures, warnings, numerics, what makes it again, as HTML."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from m4e_fmi.report.text.summaries import LOSSY
from m4e_fmi.report.web.markup import cards, facts, folded, lines, paragraph, table
from m4e_fmi.study.given.grid import Axis
from m4e_fmi.study.report.annual import of_all_states
from m4e_fmi.study.report.result import StudyResult
from m4e_fmi.study.shown.over_states import Averaged, shown_unit
from m4e_fmi.study.start_up import left_out

MOST_TOLD = 20
"""Failed runs that are named."""
MOST_CARDS = 6


def figures(result: StudyResult) -> str:
    """The comment of the study, and the largest values of its quantities as cards.

    First those over all states, such as the energy of a year.
    """
    found = list[tuple[str, str, str]]()
    for name, told, unit, values in of_all_states(result):
        found += _card(result, f"{told}, {name}", values, unit)
    for name in result.quantities:
        found += _card(result, f"largest {name}", result.designs(name), result.units[name])
    comment = result.attribute("comment")
    return (paragraph(comment) if comment else "") + cards(found[:MOST_CARDS])


def _card(
    result: StudyResult, name: str, values: Averaged, unit: str
) -> Iterator[tuple[str, str, str]]:
    """The largest of `values` in their `unit`, and of which design it is; none without a value."""
    if not np.isfinite(values.mean).any():
        return
    place = np.unravel_index(np.nanargmax(values.mean), values.mean.shape)
    scale, shown = shown_unit(values, unit)
    axes = zip(values.axes, map(int, place), strict=True)
    detail = ", ".join(result.point(one, k) for one, k in axes if len(one) > 1)
    yield name, f"{values.scaled(scale).cell(tuple(map(int, place)))} {shown}".rstrip(), detail


def warnings(result: StudyResult) -> str:
    """All doubts about the results in one box, or a line that there are none."""
    failed, error = result.failed, _coupling(result)
    told = [line.removeprefix("warning: ") for line in result.record.warnings]
    if error and np.nanmax(result.numbers["coupling_error"]) > LOSSY:
        told.append(f"Coupling error {error}")
    if len(failed):
        told.insert(0, f"{len(failed):,} of {result.grid.count:,} runs failed.")
    if told:
        return f'<div class="doubts">{lines(told)}{_failures(result)}</div>'
    accuracy = f"; largest coupling error {error}" if error else ""
    return paragraph(f"No run failed; no warnings{accuracy}.", "good")


def numerics(result: StudyResult) -> str:
    """Runs, what was varied and wanted, start-up, times."""
    parts = [facts(_facts(result))]
    if notes := lines(result.record.notes):
        parts.append(f"<h3>How the runs were made</h3>{notes}")
    return "\n".join(parts)


def _facts(result: StudyResult) -> dict[str, str]:
    record, failed = result.record, len(result.failed)
    wanted = ", ".join(f"{name} ({one})" for name, one in record.wanted.items())
    return {
        "Study": result.attribute("title"),
        "Runs": f"{result.grid.count:,}: {record.made:,} made, {record.kept:,} kept from before; "
        f"{failed or 'none'} failed",
        "Varied": "; ".join(_varied(one, result) for one in result.grid.axes),
        "Wanted": wanted,
        "Statistics leave out": (
            left_out(result.numbers["start_up"], result.attribute("start_up")) if wanted else ""
        ),
        "Statistics of rows": result.attribute("rows") if wanted else "",
        "Largest coupling error": _coupling(result),
        "Time of the runs": _times(result.numbers["wall_time"]),
        "Made": result.attribute("created"),
    }


def _varied(one: Axis, result: StudyResult) -> str:
    """A dimension in words."""
    if len(one.varied) > 1:
        return f"{one.name}: {len(one):,} points of {', '.join(v.name for v in one.varied)}"
    labels, (unit, _) = one.labels, result.labels[one.varied[0].name]
    span = labels[0] if len(one) == 1 else f"{labels[0]} to {labels[-1]}"
    many = f", {len(one):,} {'seeds' if one.repeats else 'values'}" if len(one) > 1 else ""
    return f"{one.name}: {f'{span} {unit}'.strip()}{many}"


def _coupling(result: StudyResult) -> str:
    errors = result.numbers["coupling_error"].reshape(-1)
    if np.isnan(errors).all():
        return ""
    run = int(np.nanargmax(errors))
    at = f", at {result.record.coupling_at}" if result.record.coupling_at else ""
    return f"{100 * errors[run]:.2g} % of range{at}, in the run of {result.label(run)}"


def _times(seconds: np.ndarray) -> str:
    known = seconds[np.isfinite(seconds)]
    if not len(known):
        return ""
    return (
        f"{known.sum():.4g} s in all, {known.mean():.3g} s each, {known.max():.3g} s at most, "
        "in one processor"
    )


def _failures(result: StudyResult) -> str:
    """Failed runs with their reasons."""
    failed = result.failed
    if not len(failed):
        return ""
    reasons = result.failure.reshape(-1)
    rows = [(result.label(int(run)), str(reasons[run])) for run in failed[:MOST_TOLD]]
    text = table("Runs without a result, and why", ("run", "reason"), rows, texts=2)
    if len(failed) > MOST_TOLD:
        text += paragraph(f"{len(failed) - MOST_TOLD:,} more: the table of numbers has all.")
    return text


def reproduction(result: StudyResult, command: str) -> str:
    """Command, versions, files with their SHA-256, and the text of the study."""
    record = result.record
    parts = [
        facts(
            {
                "Command": command,
                "Results": result.path.name,
                "System or model": record.inputs[0].name if record.inputs else "",
                "Made": result.attribute("created"),
            }
        ),
        "<h3>Versions</h3>" + facts(record.versions),
        "<h3>Input files</h3>",
        facts({one.name: f"SHA-256 {one.sha256}" for one in record.inputs}),
        folded("Text of the study", result.attribute("study")),
    ]
    parts += [folded(one.name, one.text) for one in record.inputs if one.text is not None]
    return "\n".join(parts)
