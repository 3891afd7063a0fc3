"""Warnings of many runs, told by kind."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

MOST_TOLD = 10
"""Kinds of warnings that are told; also failures, and tables of one quantity."""
_BRACKETS = re.compile(r" \([^()]*\)$")
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


WARNING = "warning: "


def told_once(tell: Callable[[str], None]) -> Callable[[str], None]:
    """`tell`, but for lines with a warning of a kind that was told before, whatever its numbers."""
    known: set[str] = set()

    def tell_new(line: str) -> None:
        if WARNING in line:
            kind = _kind(line.replace(WARNING, "", 1))
            if kind in known:
                return
            known.add(kind)
        tell(line)

    return tell_new


def _kind(line: str) -> str:
    """A warning without its numbers, and without what is in brackets at its end."""
    return _NUMBER.sub("#", _BRACKETS.sub("", line))


def warning_lines(warnings: Mapping[str, int]) -> Iterator[str]:
    """A line for each kind of warning, whatever its numbers, with the number of runs."""
    kinds: dict[str, tuple[str, int]] = {}
    for line, count in warnings.items():
        kind = _kind(line)
        first, before = kinds.get(kind, (line, 0))
        kinds[kind] = first, before + count
    for line, count in list(kinds.values())[:MOST_TOLD]:
        yield f"{WARNING}{line} ({count} run{'s' * (count != 1)})"
    if len(kinds) > MOST_TOLD:
        yield f"… {len(kinds) - MOST_TOLD} more kinds of warnings"
