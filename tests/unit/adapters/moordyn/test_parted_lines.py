"""Lines that part: the forces of the others, and a scenario that breaks one at a tension."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.lines_in_waves import mooring_of, started

from m4e_adapters.moordyn import Failure
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_fmi.cosim import load, run

LINES = """\
water: {density: 1025, depth: 300}
solver: {time_step: 1.0e-3}
line_types:
  chain: {diameter: 0.09, mass_per_length: 50, axial_stiffness: 2.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.3, added_mass_coefficient: 1}
anchors: {left: [-180, -50], right: [180, -50]}
fairleads: {f: [-4, -2]}
lines:
  one: {type: chain, from: left, to: f, unstretched_length: 195, segments: 10}
"""
OTHER = "  two: {type: chain, from: right, to: f, unstretched_length: 205, segments: 10}\n"
SYSTEM = """\
name: moored
components:
  mooring:
    kind: mooring
{}
scenario:
  towed: {{at: 0, ramp: {{mooring.f.x: 2 m}}, within: 4 s}}
  parted: {{when: mooring.one.fairlead_tension > 120 kN, set: {{mooring.one.parted: 1}}}}
simulation: {{stop_time: 5, step_size: 0.1, algorithm: jacobi}}
"""


def test_a_line_parts_and_falls_and_the_other_goes_on() -> None:
    made = replace(mooring_of(LINES + OTHER), failures=(Failure(((1, 1),)),))
    both, alone = started(made), started(mooring_of(LINES))
    before = both.save()
    pull = both.end_force(1, 1)
    both.part(0)
    assert both.force[0] == pytest.approx(alone.force[0], rel=1e-9)
    assert both.tensions()[1][0] == 0.0
    assert pull[2] < 0.0
    assert both.tensions()[1][1] > 1e3
    towed(both, 0, 20)
    towed(alone, 0, 20)
    assert both.force[0] == pytest.approx(alone.force[0], rel=1e-6)
    assert both.node_position(1, 10)[2] < -10.0  # it was at -2 m, two seconds ago
    kept = both.save()
    expected = towed(both, 20, 10)
    both.restore(before)
    assert both.end_force(1, 1) == pull
    both.restore(kept)
    assert towed(both, 20, 10) == expected
    other = started(made)
    other.restore(kept)
    assert towed(other, 20, 10) == expected
    for lines in (both, alone, other):
        lines.close()


def towed(lines: LineSystem, first: int, count: int) -> list:
    """Forces and tensions of steps of 0.1 s with the fairlead on its way along X at 0.2 m/s."""
    found = []
    for k in range(first, first + count):
        lines.advance(0.1 * k, 0.1, [(-4.0 + 0.02 * k, -2.0)], [(0.2, 0.0)])
        found.append((lines.force, lines.tensions()))
    return found


def test_lines_part_at_a_time_and_at_a_tension() -> None:
    made = mooring_of(LINES + OTHER)
    ends = ((0, 1),), ((1, 1),)
    lines = started(
        replace(made, failures=(Failure(ends[0], time=0.5), Failure(ends[1], tension=1e9)))
    )
    towed(lines, 0, 4)
    assert lines.parted == []
    towed(lines, 4, 1)
    assert lines.parted == [0]
    lines.close()
    torn = started(replace(made, failures=(Failure(ends[0], tension=1e3),)))
    assert torn.parted == [0]
    torn.close()


def test_a_line_breaks_at_a_tension(tmp_path: Path) -> None:
    keys = "".join(f"    {line}\n" for line in (LINES + OTHER).splitlines())
    path = tmp_path / "moored.yaml"
    path.write_text(SYSTEM.format(keys), encoding="utf-8")
    outcome = run(path, results=tmp_path / "moored.nc", build_directory=tmp_path)
    found = load(tmp_path / "moored.nc")
    parted = found["scenario.parted"].values.astype(bool)
    tension = found["mooring.one.fairlead_tension"].values
    first = int(np.argmax(parted))
    assert 1 < first < len(parted) - 10
    assert (tension[:first] > 0.0).all()
    assert (tension[:first] < 120e3).all()
    assert (tension[first:] == 0.0).all()
    assert (found["mooring.one.anchor_tension"].values[first:] > 0.0).all()
    assert (found["mooring.two.fairlead_tension"].values[first:] > 1e3).all()
    begun = f"parted: from t = {found.time[first]:.9g} s on"
    assert outcome.scenario[1] == f"{begun}: mooring.one.parted = 1"
    assert not any("parted" in str(message) for message in outcome.messages)


CURRENT = "current: {speed: 2}\n"


def test_the_water_goes_on_where_a_line_parts() -> None:
    """The line that stays feels the same current as before, and the fairlead's own velocity."""
    both = started(replace(mooring_of(LINES + OTHER + CURRENT), failures=(Failure(((1, 1),)),)))
    alone = started(mooring_of(LINES + CURRENT))
    for lines in (both, alone):
        for k in range(10):
            x = -4.0 + 0.02 * k**2
            lines.advance(0.1 * k, 0.1, [(x, -2.0)], [(0.2 + 0.4 * k, 0.0)])
    stays = both.end_force(0, 1)
    both.part(0)
    assert both.end_force(0, 1) == pytest.approx(stays, rel=1e-6)
    assert both.force[0] == pytest.approx(alone.force[0], rel=1e-6)
    both.close()
    alone.close()


def test_ends_part_once() -> None:
    """A group takes along only those of its lines that are still where they were."""
    ends = ((0, 1),), ((0, 1), (1, 1))
    lines = started(replace(mooring_of(LINES + OTHER), failures=tuple(map(Failure, ends))))
    lines.part(0)
    towed(lines, 0, 30)
    before = lines.node_position(1, 10)
    lines.part(1)
    assert lines.node_position(1, 10) == pytest.approx(before, abs=1e-9)
    assert lines.node_position(0, 10) != pytest.approx(before, abs=1.0)
    lines.close()


def test_a_step_of_nothing_pulls_at_nothing() -> None:
    """A fairlead that is not quite where it ought to be does not jump there."""
    lines = started(mooring_of(LINES + OTHER))
    towed(lines, 0, 10)
    expected = lines.force[0]
    lines.advance(1.0, 1e-9, [(-3.8 + 1e-6, -2.0)], [(0.2, 0.0)])
    assert lines.force[0] == pytest.approx(expected, abs=1e-2 * lines.tensions()[0][0])
    lines.close()
