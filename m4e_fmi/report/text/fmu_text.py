"""Contents and validation of FMUs, as text."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

from m4e_fmi.shown import one_line

if TYPE_CHECKING:
    from m4e_fmi.fmu import Finding, Group, Report

ORDER = (
    "structuralParameter",
    "parameter",
    "calculatedParameter",
    "input",
    "output",
    "local",
    "independent",
)
REALS = ("Real", "Float64")
"""Types that are not told."""


def fmu_text(path: str | Path) -> str:
    """Identity, kinds, capabilities, platforms and variables of an FMU.

    An output is followed by the inputs and states it depends on; ``← ?`` where it declares none.
    """
    from m4e_fmi.fmu import fmu_contents

    found = fmu_contents(path)
    variables = found["variables"]
    kinds = " and ".join(found["kinds"])
    lines = [
        f"{Path(path).name}: {found['modelName']}, FMI {found['fmiVersion']} {kinds}, "
        f"{len(variables)} variables",
        f"{found['size'] / 1e3:.0f} kB, {found['unpacked'] / 1e3:.0f} kB unpacked; platforms: "
        f"{', '.join(found['platforms']) or 'none'}{'; sources' if found['sources'] else ''}",
    ]
    if found["experiment"]:
        times = (f"{key} {value:g}" for key, value in found["experiment"].items())
        lines.append(f"default experiment: {', '.join(times)}")
    for kind, abilities in found["kinds"].items():
        told = (k if v is True else f"{k} {v}" for k, v in abilities.items())
        lines.append(f"{kind}: {', '.join(told)}")
    needs = {u["name"]: u["dependencies"] for u in found["structure"]["outputs"]}
    for causality in ORDER:
        chosen = [v for v in variables if v["causality"] == causality]
        if chosen:
            lines.append(f"{causality} ({len(chosen)})")
        lines += [_line(v, needs) for v in chosen]
    return "\n".join(lines)


def _line(variable: dict[str, Any], needs: dict[str, list[str] | None]) -> str:
    name = variable["name"]
    if variable.get("shape"):
        name += f"[{','.join(map(str, variable['shape']))}]"
    kind = variable["type"]
    unit = variable.get("unit", "-") if kind in REALS else kind
    if "items" in variable:
        unit += f" ({', '.join(variable['items'])})"
    line = f"  {name:<32} {unit:<10} {one_line(variable.get('description', ''))}"
    through = needs.get(name, [])
    if through is None:
        return f"{line}  ← ?"
    return line + (f"  ← {', '.join(through)}" if through else "")


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
