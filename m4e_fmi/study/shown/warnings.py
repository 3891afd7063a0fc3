"""Warnings of many runs, told by kind."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

MOST_TOLD = 10
"""Kinds of warnings that are told; also failures, and tables of one quantity."""
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


def warning_lines(warnings: Mapping[str, int]) -> Iterator[str]:
    """A line for each kind of warning, whatever its numbers, with the number of runs."""
    kinds: dict[str, tuple[str, int]] = {}
    for line, count in warnings.items():
        kind = _NUMBER.sub("#", line)
        first, before = kinds.get(kind, (line, 0))
        kinds[kind] = first, before + count
    for line, count in list(kinds.values())[:MOST_TOLD]:
        yield f"warning: {line} ({count} run{'s' * (count != 1)})"
    if len(kinds) > MOST_TOLD:
        yield f"… {len(kinds) - MOST_TOLD} more kinds of warnings"
