"""The barge of the examples, on lines in oblique waves: the same motion in a turned world."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.results.results_file import Results

EXAMPLE = Path(__file__).parents[2] / "examples" / "moored_barge"
DEGREES = 37.0
ANCHORS = {"ahead": (190, 0), "left": (-110, 160), "right": (-110, -160)}


def turned(degrees: float, x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return c * x - s * y, s * x + c * y


def results(folder: Path, degrees: float) -> Results:
    """Of 10 s of the example with few panels, hull, waves and anchors turned about Z."""
    folder.mkdir()
    model = (EXAMPLE / "barge.model.yaml").read_text("utf-8")
    start = "initial: {z: -0.5}"
    assert start in model
    yaw = math.radians(degrees)
    (folder / "barge.model.yaml").write_text(
        model.replace(start, f"initial: {{z: -0.5, psi: {yaw!r}}}"), "utf-8"
    )
    places = []
    for name, (x, y) in ANCHORS.items():
        right, left = turned(degrees, x, y)
        places.append(f"{name}: [{right!r}, {left!r}, -50]")
    text = (EXAMPLE / "system.yaml").read_text("utf-8")
    for old, new in (
        ("panels: 440", "panels: 100"),
        ("direction: 30", f"direction: {30 + degrees}"),
        ("    dimensions: 3\n    water: {density: 1025, depth: 50, gravity: 9.81}\n    bodies",
         f"    dimensions: 3\n    heading: {degrees}\n    frequencies: {{count: 12}}\n"
         "    water: {density: 1025, depth: 50, gravity: 9.81}\n    bodies"),
    ):  # fmt: skip
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    lines = [f"    anchors: {{{', '.join(places)}}}" if "anchors:" in line else line
             for line in text.splitlines()]  # fmt: skip
    path = folder / "system.yaml"
    path.write_text("\n".join(lines), "utf-8")
    system = load_system(path).changed(stop_time=10.0)
    prepared = prepare(system, build_directory=folder)
    return run(prepared, results=folder / "r.nc", certify=False).results()


@pytest.mark.verifies(
    "a barge in oblique waves on MoorDyn's lines, in a world turned by 37° about Z",
    analytic="symmetry: the same system, not turned",
    tolerance="1e-6",
)
def test_a_turned_world_has_the_turned_motion(tmp_path: Path) -> None:
    straight, other = results(tmp_path / "straight", 0.0), results(tmp_path / "turned", DEGREES)
    for names in (("x", "y", "z"), ("vx", "vy", "vz"), ("omega_x", "omega", "omega_z")):
        before, after = (
            np.array([found[f"barge.body.hull.{name}"].values for name in names])
            for found in (straight, other)
        )
        x, y = turned(DEGREES, before[0], before[1])
        assert np.ptp(before[0]) > 1e-3  # it moves in all ways
        assert np.ptp(before[1]) > 1e-3
        difference = np.abs(np.array([x, y, before[2]]) - after).max()
        assert difference < 1e-6 * max(1.0, np.abs(before).max())
