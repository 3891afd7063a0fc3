"""A validation in words: a line for each group of checks, then what was found."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from m4e_fmi.shown import one_line

if TYPE_CHECKING:
    from m4e_fmi.fmu import Finding, Group, Report

_WIDTH = 100


def validation_text(report: Report) -> str:
    """The summary first, then errors and warnings with their basis, then notes, a line each."""
    errors, warnings, notes = (
        len(report.of_severity(severity)) for severity in ("error", "warning", "note")
    )
    counts = f"{_count(errors, 'error')}, {_count(warnings, 'warning')}, {_count(notes, 'note')}"
    seconds = sum(group.seconds for group in report.groups)
    lines = [f"{report.path}: {counts} ({seconds:.1f} s of checks)"]
    width = max((len(group.name) for group in report.groups), default=0)
    lines += [f"  {group.name:<{width}}  {_outcome(group)}" for group in report.groups]
    for group in report.groups:
        if group.failed:
            text = f"{group.name}: this check failed to run (internal): {group.failed}"
            lines += ["", *textwrap.wrap(text, _WIDTH, subsequent_indent="  ")]
            lines.append("  → a defect of m4e_fmi, not of the FMU: please report it")
    for finding in report.of_severity("error", "warning"):
        lines += ["", *_block(finding)]
    if notes:
        lines.append("")
    lines += [f"note {f.id}: {one_line(f.message)}" for f in report.of_severity("note")]
    return "\n".join(lines)


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def _outcome(group: Group) -> str:
    if group.skipped:
        return f"- {one_line(group.skipped)}"
    found = [
        _count(group.count(severity), severity)
        for severity in ("error", "warning")
        if group.count(severity)
    ]
    found += ["failed to run (internal)"] * bool(group.failed)
    return ", ".join(found) or "passed"


def _block(finding: Finding) -> list[str]:
    head = f"{finding.severity} {finding.id}: {finding.message}"
    lines = textwrap.wrap(head, _WIDTH, subsequent_indent="  ")
    if finding.basis:
        lines += textwrap.wrap(
            finding.basis, _WIDTH, initial_indent="  → ", subsequent_indent="    "
        )
    lines += [f"  the FMU: {one_line(text)}" for text in finding.words]
    return lines
