"""A comparison of two files with numbers over dimensions as text and as JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from m4e_fmi.shown import one_line

if TYPE_CHECKING:
    from m4e_fmi.analysis.comparison import CellComparison, CellDifference

LONGEST_NAME = 40
"""Characters of a name in the table."""


def cell_text(found: CellComparison) -> str:
    """Table of differences, with notes and the verdict."""
    width = min(LONGEST_NAME, max(len(name) for name in found.differences))
    share = f"of {found.relative_to}"
    lines = [
        f"{found.path.name} beside {found.reference.name} (the reference), cell by cell",
        "",
        f"  {'':<{width}} {'cells':>6} {'RMS':>11} {share:>12} {'largest':>11} {share:>12}  at",
        *(_row(one, width) for one in found.differences.values()),
    ]
    notes = [*found.notes]
    notes += [
        f"{one.name}: {one.left_out} cells left out, as one of the files has no number there"
        for one in found.differences.values()
        if one.left_out
    ]
    for names, where in ((found.only_here, found.path), (found.only_there, found.reference)):
        if names:
            notes.append(f"only in {where.name}: {', '.join(names)}")
    lines += ["", *(f"note: {one_line(note)}" for note in notes)] if notes else []
    if found.tolerance is not None:
        count, whole = len(found.beyond), len(found.differences)
        limit = f"{100.0 * found.tolerance:g} % of the {found.relative_to}"
        within = f"all {whole} variables are within {limit}"
        lines += ["", within if not count else f"{count} of {whole} variables beyond {limit}"]
    return "\n".join(lines)


def _row(one: CellDifference, width: int) -> str:
    name = one_line(one.name)
    name = name if len(name) <= width else f"{name[: width - 1]}…"
    shares = [
        f"{100.0 * share:.3g} %" if math.isfinite(share) else str(share)
        for share in (one.rms_share, one.largest_share)
    ]
    at = ", ".join(
        f"{key} {value:.6g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in one.largest_at.items()
    )
    return (
        f"  {name:<{width}} {one.values.size - one.left_out:6d} {one.rms:11.4g} {shares[0]:>12} "
        f"{one.largest:11.4g} {shares[1]:>12}  {one_line(at)}  {one.unit}"
    )


def cell_json(found: CellComparison) -> dict[str, object]:
    """All numbers; null for those that are not defined."""

    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "file": str(found.path),
        "reference": str(found.reference),
        "relative_to": found.relative_to,
        "tolerance": found.tolerance,
        "within": found.is_within if found.tolerance is not None else None,
        "variables": {
            name: {
                "unit": one.unit,
                "dimensions": list(one.dimensions),
                "cells": one.values.size - one.left_out,
                "left_out": one.left_out,
                "lacking": one.lacking,
                "rms": number(one.rms),
                "largest": number(one.largest),
                "largest_at": dict(one.largest_at),
                "rms_share": number(one.rms_share),
                "largest_share": number(one.largest_share),
            }
            for name, one in found.differences.items()
        },
        "only_here": list(found.only_here),
        "only_there": list(found.only_there),
        "notes": list(found.notes),
    }
