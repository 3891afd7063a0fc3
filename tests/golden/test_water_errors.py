"""Systems whose water or moorings are wrong in space, word for word: water_errors.txt.

Each is a good system with one thing changed. `pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.drift_files import write_mean
from support.golden import check_messages, refused

from m4e_fmi.cosim import load_system, prepare

GOLDEN = Path(__file__).with_name("water_errors.txt")
SPACE = """\
name: barge
dimensions: 3
bodies: {hull: {mass: 5e4, inertia: [1e5, 3e5, 4e5], added_mass: true}}
joints: {sea: {type: floating, child: hull, initial: {z: -0.5}}}
points: {bow: {body: hull, at: [4, 0, 0]}}
"""
PLANE = """\
name: barge
bodies: {hull: {mass: 5e4, inertia: 3e5, added_mass: true}}
joints: {sea: {type: floating, child: hull, initial: {z: -0.5}}}
points: {bow: {body: hull, at: [4, 0]}}
"""
GOOD = """\
name: barge
components:
  barge: {model: space.model.yaml}
  hydro:
    kind: hydrodynamics
    dimensions: 3
    bodies:
      hull:
        shape: {box: {length: 8, width: 4, draft: 1.5, center_y: 0}}
        center_of_gravity: [0, 0, -0.5]
        panels: 100
        drag: {sway: 1e4}
    frequencies: {count: 16}
    radiation: {order: 8}
    waves: {spectrum: regular, height: 0.2, period: 5, direction: 30}
  mooring:
    kind: mooring
    dimensions: 3
    water: {depth: 50}
    line_types:
      chain:
        diameter: 0.05
        mass_per_length: 20
        axial_stiffness: 1e8
        axial_damping_ratio: 1.0
        drag_coefficient: 1.2
        added_mass_coefficient: 1
    anchors: {sea_bed: [80, 20, -50]}
    fairleads: [bow]
    lines: {l1: {type: chain, from: sea_bed, to: bow, unstretched_length: 95, segments: 10}}
connections:
  - barge.body.hull <-> hydro.hull
  - hydro.added_mass -> barge.added_mass
  - barge.point.bow <-> mooring.bow
simulation: {stop_time: 1, step_size: 0.1}
"""
WATER = "kind: hydrodynamics\n    dimensions: 3\n"
LINES = "kind: mooring\n    dimensions: 3\n"
FILTER = WATER + "    heading_filter: 20\n"
BOW = "  - barge.point.bow <-> mooring.bow\n"
HULL = "  - barge.body.hull <-> hydro.hull\n"
PANELS, DRIFT = "        panels: 100\n", "        drift: {file: hull.8}\n"
CASES: dict[str, dict[str, str]] = {
    "a planar body in water of space": {"space.model": "plane.model", BOW: ""},
    "a planar point on lines of space": {"space.model": "plane.model", HULL: ""},
    "added mass of space for a planar body": {"space.model": "plane.model", BOW: "", HULL: ""},
    "water of space without dimensions": {WATER: "kind: hydrodynamics\n"},
    "lines of space without dimensions": {LINES: "kind: mooring\n"},
    "a planar centre of gravity": {"center_of_gravity: [0, 0, -0.5]": "center_of_gravity: [0, -1]"},
    "an unknown spectrum": {"spectrum: regular, height: 0.2, period: 5": "spectrum: none"},
    "a planar anchor": {"[80, 20, -50]": "[80, -50]"},
    "a filter for two bodies": {
        WATER: FILTER,
        "    frequencies": "      other: {shape: {sphere: {radius: 2, center_x: 20}},"
        " center_of_gravity: [20, 0, -0.5]}\n    frequencies",
    },
    "a filter of no time": {WATER: FILTER.replace("20", "0")},
    "a heading that is no number": {WATER: WATER + "    heading: north\n"},
    "drag in a motion that is not": {"sway: 1e4": "y: 1e4"},
    "a hull above the water": {"draft: 1.5": "draft: -1.5"},
    "a direction as a word": {"direction: 30": "direction: north"},
    "drift for other directions": {PANELS: PANELS + DRIFT},
    "drift of sums": {PANELS: PANELS + DRIFT.replace("hull.8", "hull.12s")},
    "drift of no file": {PANELS: PANELS + DRIFT.replace("hull.8", "hul.8")},
    "drift about a planar point": {
        PANELS: PANELS + DRIFT.replace("hull.8", "hull.8, reference_point: [0, 1]")
    },
    "dimensions as a word": {WATER: "kind: hydrodynamics\n    dimensions: three\n"},
    "a turning matrix against its way": {
        "hydro.added_mass -> barge.added_mass": "barge.added_mass -> hydro.added_mass"
    },
    "a moment for a place": {HULL: "  - hydro.hull.moment_x -> barge.body.hull.y\n"},
    "a moment for a force": {HULL: "  - hydro.hull.moment_x -> barge.body.hull.force_y\n"},
}  # fmt: skip


def test_messages(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    (tmp_path / "space.model.yaml").write_text(SPACE, "utf-8")
    (tmp_path / "plane.model.yaml").write_text(PLANE, "utf-8")
    for name in ("hull.8", "hull.12s"):
        write_mean(
            tmp_path / name, lambda *_: 1.0, omega=(0.5, 1.0, 2.0), directions=(0.0, 90.0, 180.0)
        )

    def message(changes: dict[str, str]) -> str:
        return refused(
            tmp_path / "system.yaml",
            GOOD,
            changes,
            lambda p: prepare(load_system(p), build_directory=tmp_path),
        )

    check_messages(GOLDEN, CASES, message, request)


def test_the_system_itself_is_right(tmp_path: Path) -> None:
    (tmp_path / "space.model.yaml").write_text(SPACE, "utf-8")
    path = tmp_path / "system.yaml"
    path.write_text(GOOD, "utf-8")
    assert prepare(load_system(path), build_directory=path.parent).wiring.links
