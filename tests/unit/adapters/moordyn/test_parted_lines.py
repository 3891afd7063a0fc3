"""Lines that part: the forces of the others, and a scenario that breaks one at a tension."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.lines_in_waves import mooring_of, started

from m4e_fmi.cosim import load, run

LINES = """\
water: {density: 1025, depth: 300}
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


def test_forces_without_a_line_are_those_of_the_others() -> None:
    both = started(mooring_of(LINES + OTHER), parting=[(0, 1, 0), (1, 1, 0)])
    alone = started(mooring_of(LINES))
    force, fairlead, anchor = both.without({1: 1.0})
    assert force[0] == pytest.approx(alone.force[0], rel=1e-9)
    assert fairlead == [both.fairlead_tension[0], 0.0]
    assert anchor == [both.anchor_tension[0], 0.0]
    assert both.without({}) == (both.force, both.fairlead_tension, both.anchor_tension)
    saved = both.save()
    both.advance(0.0, 0.1, [(-4.0, -2.0)], [(1.0, 0.0)])
    moved = both.without({1: 1.0})
    both.restore(saved)
    assert both.without({1: 1.0}) == (force, fairlead, anchor) != moved
    both.close()
    alone.close()


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
    assert (found["mooring.two.fairlead_tension"].values[first:] > 1e3).all()
    begun = f"parted: from t = {found.time[first]:.9g} s on"
    assert outcome.scenario[1] == f"{begun}: mooring.one.parted = 1"
    assert not any("parted" in str(message) for message in outcome.messages)
