"""The summary of a report of a study, and what it takes to make it again, as HTML."""

from __future__ import annotations

import numpy as np

from m4e_fmi.report.web.markup import facts, folded, lines, paragraph, table
from m4e_fmi.study.given.grid import Axis
from m4e_fmi.study.report.result import StudyResult
from m4e_fmi.study.start_up import left_out

MOST_TOLD = 20
"""Failed runs that the summary names."""


def summary(result: StudyResult, printed: str) -> str:
    """Runs, failures with their reasons, warnings, coupling error; `printed` by the command."""
    parts = [paragraph(text)] if (text := result.attribute("comment")) else []
    failed = result.failed
    if len(failed):
        parts.append(paragraph(f"{len(failed):,} of {result.grid.count:,} runs failed.", "problem"))
    parts += [facts(_facts(result)), _failures(result)]
    if warnings := lines(line.removeprefix("warning: ") for line in result.record.warnings):
        parts.append(f"<h3>Warnings</h3>{warnings}")
    if notes := lines(result.record.notes):
        parts.append(f"<h3>How the runs were made</h3>{notes}")
    if printed:
        parts.append(folded("As printed by the study", printed))
    return "\n".join(filter(None, parts))


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
    return f"{errors[run]:.1e} of range{at}, in the run of {result.grid.label(run)}"


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
    rows = [(result.grid.label(int(run)), str(reasons[run])) for run in failed[:MOST_TOLD]]
    text = table("Runs without a result, and why", ("run", "reason"), rows, texts=2)
    if len(failed) > MOST_TOLD:
        text += paragraph(f"{len(failed) - MOST_TOLD:,} more: the table of numbers has all.")
    return f"<h3>Failed runs</h3>{text}"


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
