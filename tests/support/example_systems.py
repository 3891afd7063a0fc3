"""Systems of examples/ for comparison: their kinds, and what is left of them without some parts."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim import System, load_system

EXAMPLES = Path(__file__).parents[2] / "examples"


def example_files(*patterns: str) -> list[str]:
    """All files of examples/ that match one of the patterns, by their paths in it."""
    found = {path for pattern in patterns for path in EXAMPLES.rglob(pattern)}
    return sorted(path.relative_to(EXAMPLES).as_posix() for path in found)


@contextmanager
def hydraulic_kinds(site: Path) -> Iterator[None]:
    """The kinds of examples/hydraulic_pto, as if its package were installed in `site`."""
    info = site / "hydraulic_pto-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: hydraulic_pto\nVersion: 1.0\n")
    points = "\n".join(
        f"[m4e_fmi.{group}]\n" + "".join(f"{a} = {b}\n" for a, b in names.items())
        for group, names in {
            "adapters": {"hydraulic_pto": "hydraulic_pto"},
            "fmus": {
                "hydraulic_pto": "hydraulic_pto.program_fmu:KIND",
                "hydraulic_pto_scipy": "hydraulic_pto.python_fmu:KIND",
            },
        }.items()
    )
    (info / "entry_points.txt").write_text(points)
    added = [str(site), str(EXAMPLES / "hydraulic_pto")]
    sys.path += added
    yield
    for path in added:
        sys.path.remove(path)


def example_system(name: str, *, without: str = "") -> System:
    """The system in the file `name` of examples/, without one component and its connections."""
    found = load_system(EXAMPLES / name)
    if not without:
        return found
    return replace(
        found,
        name=f"{found.name}_alone",
        components=tuple(c for c in found.components if c.name != without),
        connections=tuple(t for t in found.connections if f"{without}." not in t),
    )
