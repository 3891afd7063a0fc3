"""One line system: forces at the start, saved states, independence, silence, failures."""

import math
import os
import sys
from pathlib import Path

import pytest
from support.lines_in_waves import ROPE, line_system, started

from m4e_adapters.moordyn import ready_mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.moordyn_system import MooringError

STIFFNESS, LENGTH = 1e9, 100.5
HALF_WEIGHT = 1e-3 * LENGTH / 2 * 9.80665
CHAIN = """\
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1, axial_drag_coefficient: 0.4}
anchors: {left: [-150, -60], right: [150, -60]}
fairleads: [f1, f2]
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
  l2: {type: chain, from: right, to: f2, unstretched_length: 165, segments: 6}
  l3: {type: chain, from: right, to: f2, unstretched_length: 166, segments: 5}
static_equilibrium: AT_REST
"""
SPATIAL = """\
dimensions: 3
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1, axial_drag_coefficient: 0.4}
anchors: {left: [-150, 0, -60]}
fairleads: {f1: [-5, 0, -3]}
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
"""
AT = [(-5.0, -3.0), (5.0, -3.0)]
REST = [(0.0, 0.0), (0.0, 0.0)]


def chain(at_rest: bool = True) -> LineSystem:
    """Lines that start at `AT`."""
    lines = line_system(CHAIN.replace("AT_REST", str(at_rest).lower()))
    lines.start(AT, REST)
    return lines


def motion(k: int, h: float) -> tuple[list, list]:
    """Fairleads at k·h and their mean velocity over the step, for a 5 s motion of 1 m."""

    def at(t: float) -> tuple[float, float]:
        return math.sin(1.25 * t), 0.5 * math.sin(1.25 * t)

    (x0, z0), (x1, z1) = at(k * h), at((k + 1) * h)
    return [(x + x0, z + z0) for x, z in AT], [((x1 - x0) / h, (z1 - z0) / h)] * 2


def run(lines: LineSystem, first: int, count: int, h: float = 0.05) -> list:
    found = []
    for k in range(first, first + count):
        lines.advance(k * h, h, *motion(k, h))
        found.append((lines.force, lines.tensions()))
    return found


def force_of_rope(
    start: tuple, given: tuple, velocity: tuple, more: str = ""
) -> tuple[float, float]:
    """At a start, or with a `velocity` 10 ms after the fairlead was `given` there."""
    lines = line_system(ROPE + more)
    lines.start([start], [velocity if start == given else (0.0, 0.0)])
    if any(velocity):
        lines.advance(0.0, 0.01, [given], [velocity])
    (force,) = lines.force
    lines.close()
    return force


@pytest.mark.parametrize(
    ("start", "given", "velocity", "more", "tolerance"),
    [
        # rounding of the stretched length, 1e-14 m, times the stiffness of 1e7 N/m, with a margin
        ((10.0, -100.00216), (10.0, -100.00216), (0.0, 0.0), "", 1e-5),
        # the last internal stage of RK2 lies 5 ms before the end: 1e7 N/m · 1 m/s · 5 ms; half of
        # the vanishing last part, 5e-12 s, at 1e7 N/s
        ((0.0, -101.0), (0.0, -101.0), (0.0, -1.0), "solver: {scheme: RK2}\n", 1e-4),
        # a position that jumps
        ((0.0, -101.0), (0.3, -101.0), (0.0, 0.5), "", 0.01),
    ],
    ids=["at the start", "at the end of a step", "after a jump"],
)
def test_the_force_is_that_of_the_place(
    start: tuple, given: tuple, velocity: tuple, more: str, tolerance: float
) -> None:
    found = force_of_rope(start, given, velocity, more)
    x, z = (p + (0.01 * v if any(velocity) else 0.0) for p, v in zip(given, velocity, strict=True))
    length = math.hypot(x, z)
    pull = STIFFNESS / LENGTH * (length - LENGTH)
    expected = (-pull * x / length, -pull * z / length - HALF_WEIGHT)
    assert found == pytest.approx(expected, abs=tolerance)


def test_motions_below_the_smallest_number_are_restored_as_none() -> None:
    """MoorDyn would restore 1e-310 m/s as −1e301."""
    lines, place = line_system(SPATIAL), (-5.0, 0.0, -3.0)
    lines.start([place], [(0.0, 0.0, 0.0)])
    lines.advance(0.0, 0.1, [place], [(0.1, 1e-310, 0.0)])
    saved = lines.save()
    with pytest.raises(MooringError, match="not one of these lines"):
        lines.restore(saved | {"system": saved["system"][:-8]})
    lines.advance(0.1, 0.1, [(-4.99, 0.0, -3.0)], [(0.1, 0.0, 0.0)])
    expected = lines.force[0]
    lines.restore(saved)
    lines.advance(0.1, 0.1, [(-4.99, 0.0, -3.0)], [(0.1, 0.0, 0.0)])
    lines.close()
    assert lines.force[0][::2] == expected[::2]
    assert abs(lines.force[0][1]) < 1e-200


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="None is immortal since Python 3.12")
def test_restoring_does_not_consume_none() -> None:
    lines = line_system(ROPE)
    lines.start([(0.0, -101.0)], [(0.0, 0.0)])
    saved = lines.save()
    before = sys.getrefcount(None)
    for _ in range(200):
        lines.restore(saved)
    lost = before - sys.getrefcount(None)
    lines.close()
    assert abs(lost) < 20  # other code holds and drops None too; each call lost one


def test_nothing_is_written_to_the_console_or_left_on_disk(capfd, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    print("before", flush=True)
    lines = chain()
    run(lines, 0, 2)
    assert len(list(tmp_path.iterdir())) == (os.name != "posix")  # Windows removes no open file
    lines.start(AT, REST)
    with pytest.raises(MooringError):
        lines.advance(0.0, 0.05, [(math.nan, 0.0)] * 2, REST)
    lines.close()
    print("after", flush=True)
    assert capfd.readouterr() == ("before\nafter\n", "")
    assert list(tmp_path.iterdir()) == []


def test_a_buoy_is_told_once_when_it_rises() -> None:
    path = Path(__file__).parents[3] / "data" / "moordyn" / "buoy_between_lines.txt"
    lines = started(ready_mooring(path, fairleads={}))
    lines.start([(100.0, -150.0)], [(0.0, 0.0)])  # pulled below
    assert not any("above the water" in text for text in lines.warnings)
    for k in range(40):
        lines.advance(0.5 * k, 0.5, [(100.0, -150.0 + 3.5 * k)], [(0.0, 7.0)])
    for k in range(40, 80):
        lines.advance(0.5 * k, 0.5, [(100.0, -10.0)], [(0.0, 0.0)])
    assert len(lines.news()) == 1
    assert lines.news() == []
    lines.close()
