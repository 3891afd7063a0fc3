"""Saved states: the same bits here, in another instance and in another process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from itertools import chain
from pathlib import Path

import pytest
from support.lines_in_waves import lines_of, mooring_of, started

from m4e_adapters.moordyn import Failure, Mooring
from m4e_adapters.moordyn.line_system import LineSystem

TESTS = Path(__file__).parents[3]
TEXT = """\
dimensions: 3
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
anchors: {left: [-150, 0, -60], right: [150, 20, -60]}
fairleads: {f: [-5, 0, -3]}
lines:
  one: {type: chain, from: left, to: f, unstretched_length: 165, segments: 6}
  two: {type: chain, from: right, to: f, unstretched_length: 180, segments: 6}
"""
STEP = 0.05
PARTS = 10  # steps until the second line parts


def mooring() -> Mooring:
    """Two lines: the first has a winch, the second parts after `PARTS` steps."""
    failure = Failure(((1, 1),), time=PARTS * STEP)
    return replace(mooring_of(TEXT), winches=(0,), failures=(failure,))


def hauled(lines: LineSystem, first: int, count: int) -> list[str]:
    """All that is returned of steps in which the first line is hauled in at 0.2 m/s."""
    found = []
    for k in range(first, first + count):
        winch = (165.0 - 0.2 * k * STEP, -0.2)
        lines.advance(k * STEP, STEP, [(-5.0, 0.1 * k * STEP, -3.0)], [(0.0, 0.1, 0.0)], winch)
        values = [*lines.force[0], *chain(*lines.tensions())]
        found.append(" ".join(value.hex() for value in values))
    return found


def packed(saved: dict) -> str:
    """A saved state as text."""
    return json.dumps(saved, default=lambda content: {"hex": content.hex()})


def unpacked(text: str) -> dict:
    """The saved state of such a text."""
    return json.loads(
        text, object_hook=lambda data: bytes.fromhex(data["hex"]) if set(data) == {"hex"} else data
    )


def begun() -> LineSystem:
    """The lines at their start."""
    lines = lines_of(mooring())
    lines.start([(-5.0, 0.0, -3.0)], [(0.0, 0.0, 0.0)], winch=(165.0,))
    return lines


def test_states_go_on_with_the_same_bits_anywhere() -> None:
    lines = begun()
    hauled(lines, 0, 5)
    early = packed(lines.save())
    middle = hauled(lines, 5, 10)
    late = packed(lines.save())
    last = hauled(lines, 15, 5)
    for saved, first, expected in ((early, 5, middle), (late, 15, last), (early, 5, middle)):
        lines.restore(unpacked(saved))
        assert hauled(lines, first, len(expected)) == expected
    lines.close()
    for saved, first, expected in ((early, 5, middle), (late, 15, last)):
        program = (
            "import sys; from unit.adapters.moordyn.test_rewind import *; "
            f"lines = lines_of(mooring()); lines.restore(unpacked(sys.stdin.read())); "
            f"print(*hauled(lines, {first}, {len(expected)}), sep='\\n')"
        )
        run = subprocess.run(
            [sys.executable, "-c", program],
            input=saved, capture_output=True, text=True, check=False, cwd=TESTS,
            env={**os.environ, "PYTHONPATH": str(TESTS)},
        )  # fmt: skip
        assert run.stdout.splitlines() == expected, run.stderr


def test_restoring_takes_no_memory() -> None:
    resource = pytest.importorskip("resource")
    lines = started(mooring_of(TEXT))
    saved = lines.save()

    def restored(count: int) -> int:
        for _ in range(count):
            lines.restore(saved)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = restored(2000)
    assert restored(20000) - before < 200  # KiB: a hundredth of a state each would be 700
    lines.close()
