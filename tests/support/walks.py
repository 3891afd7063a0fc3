"""Ways of a value through the files of the product, traced, and those that the docs show."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import networkx as nx

import m4e_adapters
import m4e_fmi
import m4e_fmus
from m4e_fmi.files.document import Section

PACKAGES = tuple(
    str(Path(package.__file__).parent) for package in (m4e_fmi, m4e_adapters, m4e_fmus)
)
DOCS = Path(m4e_fmi.__file__).parents[1] / "docs" / "architecture.md"
Seen = Callable[[FrameType, str, object], None]
Wanted = Callable[[object], bool]


def elements(value: object, depth: int = 3) -> Iterator[object]:
    """A value, and those in it where it is a collection, or a section of a file."""
    yield value
    value = vars(value) if isinstance(value, Section) else value
    parts = [*value, *value.values()] if isinstance(value, dict) else value
    if isinstance(parts, list | tuple | set) and depth > 0:
        for part in parts:
            yield from elements(part, depth - 1)


def has(frame: FrameType, event: str, result: object, wanted: Wanted) -> bool:
    """True where a function has something `wanted` in its hands, or returns it."""
    values = [*frame.f_locals.values(), result if event == "return" else None]
    return any(wanted(one) for value in values for one in elements(value))


@contextmanager
def traced(seen: Seen) -> Iterator[None]:
    """Within this, calls of functions of the product, and their ends, are seen."""

    def trace(frame: FrameType, event: str, result: object) -> None:
        if event in ("call", "return") and frame.f_code.co_filename.startswith(PACKAGES):
            seen(frame, event, result)

    sys.setprofile(trace)
    try:
        yield
    finally:
        sys.setprofile(None)


def stack(frame: FrameType | None) -> Iterator[FrameType]:
    """A call and those that led to it, of functions of the product."""
    while frame:
        if frame.f_code.co_filename.startswith(PACKAGES):
            yield frame
        frame = frame.f_back


def file(frame: FrameType) -> str:
    """The file of a function, as the docs have it."""
    return Path(frame.f_code.co_filename).relative_to(DOCS.parents[1]).as_posix()


class Ways:
    """From which file to which something `wanted` is handed, by calls and returns."""

    def __init__(self, wanted: Wanted) -> None:
        self.graph: nx.DiGraph[str] = nx.DiGraph()
        self._wanted = wanted

    def seen(self, frame: FrameType, event: str, result: object) -> None:
        """Note what a call or its end hands on."""
        if not has(frame, event, result, self._wanted):
            return
        caller = next(stack(frame.f_back), None)
        if caller and event == "return" and any(map(self._wanted, elements(result))):
            self.graph.add_edge(file(frame), file(caller))
        if caller and has(caller, "", None, self._wanted):
            self.graph.add_edge(file(caller), file(frame))

    def shortest(self, first: str, last: str) -> list[list[str]]:
        """All shortest ways from one file to another."""
        return list(nx.all_shortest_paths(self.graph, first, last))


def documented(title: str) -> list[str]:
    """The files of a walk in the docs, in order."""
    section = DOCS.read_text("utf-8").split(f"\n## {title}\n")[1].split("\n## ")[0]
    return re.findall(r"\n\d+\. `([^`]+)`", section)
