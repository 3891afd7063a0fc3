"""Of each example that couples FMUs, each connection, and each variable in it, is left out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from m4e_fmi.cosim import load_system, prepare

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("name", ["flexible_pendulum", "moored_buoy", "sphere_decay"])
def test_each_is_told(name: str, tmp_path: Path) -> None:
    system = load_system(EXAMPLES / name / "system.yaml")
    prepared = prepare(system, build_directory=tmp_path)
    assert prepared.warnings == ()
    links = (*prepared.wiring.links, *prepared.wiring.initial_links)
    for connections in (system.connections, tuple(f"{k.source} -> {k.target}" for k in links)):
        for left_out in connections:
            rest = tuple(c for c in connections if c != left_out)
            part = replace(system, connections=rest)
            found = prepare(part, build_directory=tmp_path).warnings
            print(left_out, *found, sep="\n    ")
            assert len(found) == 1
