"""Texts as they are shown: short ones of objects for `repr`, and none that acts on its reader.

A `repr` is a few lines with the contents, never all of them.
"""

from __future__ import annotations

import re
import reprlib
from collections.abc import Iterable, Sequence
from dataclasses import fields
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    import numpy as np

MOST_LINES = 20
WIDTH = 100

Kind = TypeVar("Kind")
_ACTING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters but tab and line feed
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # direction of writing
    "\u180e\u200b\u2060-\u2064\ufeff\ufff9-\ufffb\U000e0000-\U000e007f"  # of no width
    "\u2028\u2029\ud800-\udfff]"  # ends of lines, halves
)
_LINE_END = re.compile(r"\s*[\n\t]\s*")


def cleaned(text: str) -> str:
    """`text` with U+FFFD in place of each character that acts on a terminal or hides others."""
    return _ACTING.sub("\ufffd", text)


def one_line(text: str) -> str:
    """`text`, cleaned, with a blank in place of ends of lines and tabs."""
    return _LINE_END.sub(" ", cleaned(text)).strip()


class _Short(reprlib.Repr):
    """Shortened texts of values: the first of many, of arrays the shape, of objects a line."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 2
        self.maxdict = self.maxlist = self.maxtuple = self.maxset = self.maxfrozenset = 4
        self.maxstring = self.maxother = 60

    def repr_ndarray(self, array: np.ndarray, _: int) -> str:
        return f"<{'×'.join(map(str, array.shape))} array>"

    def repr_instance(self, x: object, level: int) -> str:
        first, *more = super().repr_instance(x, level).split("\n")
        return f"<{first} …>" if more else first


_SHORT = _Short()


def short(kind: type[Kind]) -> type[Kind]:
    """A dataclass whose repr has all its fields, each of them shortened, on one line."""

    def shown(self: Any) -> str:
        values = (f"{f.name}={_SHORT.repr(getattr(self, f.name))}" for f in fields(self) if f.repr)
        return f"{type(self).__name__}({', '.join(values)})"

    kind.__repr__ = shown  # pyrefly: ignore[method-assign]
    return kind


def listing(title: str, /, **groups: Iterable[Any]) -> str:
    """A title, and a line for each group with its size and the first of its members.

    Members are texts, or have a `name`. Empty groups are left out; of very many, the last.
    """
    lines = [title]
    for group, members in groups.items():
        names = [one if isinstance(one, str) else one.name for one in members]
        if names:
            lines.append(_line(f"  {group} ({len(names)}): ", names))
    if len(lines) > MOST_LINES:
        left = len(lines) - MOST_LINES + 1
        lines[MOST_LINES - 1 :] = [f"  … and {left} more"]
    return "\n".join(lines)


def _line(head: str, names: Sequence[str]) -> str:
    """A line with as many of the names as fit, the first one cut if need be."""
    line = head + names[0].split("\n")[0][:WIDTH]
    for name in names[1:]:
        if len(line) + len(name) + 5 > WIDTH:
            return f"{line}, …"
        line += f", {name}"
    return line


def first_of(names: Iterable[object], most: int) -> str:
    """The first names, and how many more there are."""
    found = [str(name) for name in names]
    more = f" and {len(found) - most} more" if len(found) > most else ""
    return ", ".join(found[:most]) + more


def columns(align: str, *rows: Sequence[str]) -> list[str]:
    """Rows of cells as lines of padded columns; `align` has "<" or ">" for each column."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    places = list(zip(align, widths, strict=True))
    return [
        "  " + "  ".join(f"{c:{a}{w}}" for c, (a, w) in zip(row, places, strict=True)).rstrip()
        for row in rows
    ]


def table(title: str, align: str, *rows: Sequence[str]) -> str:
    """A title, and `columns` below it; of very many rows the first."""
    lines = [title, *columns(align, *rows[: MOST_LINES - 2])]
    left = len(rows) - (MOST_LINES - 2)
    return "\n".join([*lines, f"  … and {left} more"] if left > 0 else lines)


def span(time: Sequence[float] | np.ndarray) -> str:
    """Number and time span of rows of results at times (n,) [s]."""
    if not len(time):
        return "no rows"
    return f"{len(time)} rows from {time[0]:g} to {time[-1]:g} s"


def views() -> Any:
    """The module that makes figures and animations; it is above those whose objects ask."""
    return import_module("m4e_fmi.notebook")
