"""Outputs of the mooring FMU that are computed when they are read: at rest, by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from support.fmu_instances import Instance

from m4e_fmi.cosim.results.system_scene import scene_without_build
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu
from m4e_fmi.report.animation.scene import Followed
from m4e_fmus import mooring

Load = Callable[..., Instance]
DEPTH, WEIGHT, STRENGTH = 50.0, 1000.0, 6.0e5
DENSITY, GRAVITY = 1025.0, 9.80665
MASS = WEIGHT / GRAVITY + DENSITY * math.pi * 0.1**2 / 4
CHAIN = f"""\
water: {{density: {DENSITY}, depth: {DEPTH}, gravity: {GRAVITY}}}
line_types:
  chain: {{diameter: 0.1, mass_per_length: {MASS!r}, axial_stiffness: 1.0e+10,
          axial_damping_ratio: 1, drag_coefficient: 1.2, added_mass_coefficient: 1,
          breaking_strength: {STRENGTH}}}
  soft: {{diameter: 0.1, mass_per_length: {MASS!r}, axial_stiffness: 1.0e+8,
         axial_damping_ratio: 1, drag_coefficient: 1.2, added_mass_coefficient: 1,
         breaking_strength: {STRENGTH}}}
"""
TWO = """\
dimensions: 3
anchors: {shared: [-200, 0, -50], other: [200, 0, -50]}
fairleads: {bow: [0, 3, 0]}
points: {clump: {position: [100, 2, -40], mass: 500, volume: 0.1}}
lines:
  one: {type: chain, from: shared, to: bow, unstretched_length: 214, segments: 60}
  two: {type: chain, from: shared, to: bow, unstretched_length: 207.5, segments: 40}
  three: {type: chain, from: other, to: clump, unstretched_length: 110, segments: 20}
  four: {type: chain, from: clump, to: bow, unstretched_length: 115, segments: 20}
"""
SOFT = TWO.replace("type: chain", "type: soft")


@pytest.fixture
def start(load: Load, tmp_path: Path) -> Callable[[str], Instance]:
    def made(text: str) -> Instance:
        config = Document.parse(CHAIN + text).validate(mooring.KIND.config)
        source = mooring.KIND.build(config, name="m", folder=tmp_path, progress=lambda _: None)
        return load("python", build_fmu(source, tmp_path / "m.fmu")).initialise()

    return made


def vector(fmu: Instance, name: str) -> np.ndarray:
    return np.array(fmu.get([f"{name.format(axis)}" for axis in "xyz"]))


def test_anchors_points_and_strengths(start: Callable[[str], Instance]) -> None:
    """An anchor has the pull of all its lines; what floats nowhere is carried by the ends."""
    fmu = start(TWO)
    (bow, shared, other) = (vector(fmu, f"{n}.force_{{}}") for n in ("bow", "shared", "other"))
    assert (bow + shared + other)[:2] == pytest.approx([0, 0], abs=1e-4 * abs(bow[2]))
    tensions = np.array(fmu.get([f"{n}.{end}_tension" for n in ("one", "two", "three")
                                 for end in ("anchor", "fairlead")])).reshape(3, 2)  # fmt: skip
    factors = fmu.get([f"{n}.safety_factor" for n in ("one", "two", "three")])
    assert factors == pytest.approx(STRENGTH / tensions.max(axis=1), rel=1e-12)
    ends = [vector(fmu, name) for name in ("three.node_{}[21]", "four.node_{}[1]", "clump.{}")]
    assert np.ptp(ends, axis=0) == pytest.approx(0, abs=1e-9)
    (uplift, none) = fmu.get(["shared.uplift_angle", "other.uplift_angle"])
    assert uplift == pytest.approx(math.atan2(shared[2], math.hypot(*shared[:2])), rel=1e-12)
    assert uplift > 0 == none


def test_tension_within_a_line_is_that_of_its_segments(start: Callable[[str], Instance]) -> None:
    """At the ends MoorDyn's FairTen and AnchTen: half a segment's weight less than on the body."""
    fmu = start(TWO)
    (whole,) = fmu.get(["two.fairlead_tension"])
    inner = np.array(fmu.get([f"two.tension[{k}]" for k in range(1, 42)]))
    at = np.array([vector(fmu, f"two.node_{{}}[{k}]") for k in (40, 41)])
    sine = (at[1] - at[0])[2] / np.linalg.norm(at[1] - at[0])
    half = 207.5 / 40 / 2 * WEIGHT
    assert math.sqrt(whole**2 - half**2 * (1 - sine**2)) - half * sine == pytest.approx(
        inner[-1], rel=1e-4
    )
    assert (np.diff(inner) > 0).all()


@pytest.mark.parametrize("segments", [20, 40])
def test_touchdown_is_that_of_a_catenary(start: Callable[[str], Instance], segments: int) -> None:
    """Of an inextensible one: s = √(z² + 2 z a) is off the bed, x = a arcosh(1 + z/a).

    Within half a segment: lumped masses lie or do not.
    """
    length, span = 300.0, 275.0

    def beyond(a: float) -> float:
        hanging = math.sqrt(DEPTH**2 + 2 * DEPTH * a)
        return length - hanging + a * math.acosh(1 + DEPTH / a) - span

    a = brentq(beyond, 1.0, 1000.0)
    fmu = start(
        "anchors: {a: [0, -50]}\n"
        f"fairleads: {{f: [{span}, 0]}}\n"
        f"lines: {{l: {{type: chain, from: a, to: f, unstretched_length: {length}, "
        f"segments: {segments}}}}}\n"
    )
    (found,) = fmu.get(["l.touchdown"])
    piece = length / segments
    assert found == pytest.approx(length - math.sqrt(DEPTH**2 + 2 * DEPTH * a), abs=0.5 * piece)


def test_a_line_breaks_at_its_strength(start: Callable[[str], Instance]) -> None:
    """The fairlead is pulled away slowly; the other line goes on with all of the load."""
    text = SOFT.replace("unstretched_length: 207.5", "unstretched_length: 206.5")
    fmu = start(text.replace("segments: 40}", "segments: 40, breaks: true}"))
    tensions, step, speed = ["one.fairlead_tension", "two.fairlead_tension"], 0.02, 0.1
    before = now = fmu.get(tensions)
    for k in range(400):
        fmu.set({"bow.x": speed * step * k, "bow.vx": speed})
        fmu.step(step * k, step)
        before, now = now, fmu.get(tensions)
        if now[1] == 0.0:
            break
        (factor,) = fmu.get(["two.safety_factor"])
        assert factor >= 1.0
    assert 0.98 * STRENGTH < before[1] < STRENGTH
    assert now[0] == pytest.approx(before[0], rel=0.01)
    assert any("parted at t = " in text and "two of 6" in text for _, text in fmu.heard())


def test_a_winch_hauls_its_line(start: Callable[[str], Instance]) -> None:
    """As one of that length, but for a slow swing across that is left of the hauling."""
    fmu, speed = start(SOFT.replace("segments: 40}", "segments: 40, winch: true}")), -0.025
    for k in range(200):
        fmu.set({"two.length": 207.5 + speed * 0.1 * k, "two.length_rate": speed})
        fmu.step(0.1 * k, 0.1)
    fmu.set({"two.length": 207.0, "two.length_rate": 0.0})
    for k in range(200, 800):
        fmu.step(0.1 * k, 0.1)
    short = start(SOFT.replace("unstretched_length: 207.5", "unstretched_length: 207"))
    names = ["two.fairlead_tension", "two.node_z[20]", "two.anchor_tension"]
    assert fmu.get(names) == pytest.approx(short.get(names), rel=0.01)


def test_free_points_are_in_the_scene(tmp_path: Path) -> None:
    """A sphere of the point's volume, and the ends of lines, follow its place."""
    section = "".join(f"    {line}\n" for line in (CHAIN + TWO).splitlines())
    (tmp_path / "system.yaml").write_text(
        f"name: s\ncomponents:\n  m:\n    kind: mooring\n{section}"
        "simulation: {stop_time: 1, step_size: 0.1}\n"
    )
    scene = scene_without_build(load_system(tmp_path / "system.yaml"))
    assert scene is not None
    (body,) = scene.bodies
    place = tuple(Followed(f"m.clump.{axis}") for axis in "xyz")
    assert body.motion == (*place, 0, 0, 0)
    radii = np.linalg.norm(body.surfaces[0].vertices, axis=1)
    assert radii == pytest.approx((0.1 * 3 / (4 * math.pi)) ** (1 / 3))
    ends = {cable.name: cable.ends for cable in scene.cables}
    assert ends["m.three"] == ((200, 0, -50), place)
    assert ends["m.four"] == (place, (0, 3, 0))
