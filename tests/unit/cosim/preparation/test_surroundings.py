"""Water, waves and gravity that differ between components are told, with values and lines."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.described import described

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.cosim.preparation.surroundings import differing

MODEL = """\
name: buoy
gravity: {gravity}
parameters: {{g: {{value: 9.81, unit: m/s2}}}}
bodies: {{float: {{mass: 1e5, inertia: 1e6}}}}
joints: {{sea: {{type: floating, child: float}}}}
"""
SYSTEM = """\
name: moored
components:
  buoy: {{model: buoy.model.yaml, start: {{{start}}}}}
  hydro:
    kind: hydrodynamics
    water: {{{hydro}}}
    bodies: {{float: {{shape: {{sphere: {{radius: 3}}}}, center_of_gravity: [0, -1]}}}}
  mooring:
    kind: mooring
    water: {{{mooring}}}
    line_types:
      rope: {{diameter: 0.1, mass_per_length: 10, axial_stiffness: 1e7, axial_damping_ratio: 1,
        drag_coefficient: 1, added_mass_coefficient: 1}}
    anchors: {{a: [-50, -40]}}
    fairleads: [f]
    lines: {{l: {{type: rope, from: a, to: f, unstretched_length: 60, segments: 5}}}}
connections: []
simulation: {{stop_time: 1, step_size: 0.1}}
"""
LINK = Link(Port("hydro", "float.force_z"), Port("buoy", "body.float.force_z"), 0)
WIRING = Wiring((LINK,), (), (), ())
BUOY = described("buoy", ("g", "parameter", "m/s2"), ("body.float.force_z", "input", "N"))


def told(
    folder: Path,
    *,
    hydro: str = "depth: 40",
    mooring: str = "depth: 40",
    gravity: str = "9.80665",
    start: str = "",
) -> list[str]:
    (folder / "buoy.model.yaml").write_text(MODEL.format(gravity=gravity))
    (folder / "system.yaml").write_text(SYSTEM.format(hydro=hydro, mooring=mooring, start=start))
    system = load_system(folder / "system.yaml")
    return differing(system, {"buoy": BUOY}, WIRING)


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ({}, []),  # defaults of gravity, 9.81 and 9.80665, are the same
        (
            {"mooring": "depth: 80, gravity: 1.62"},
            [
                "hydro.water.depth is 40 (line 6), mooring.water.depth is 80 (line 10) m: "
                "components in one water need the same",
                "hydro.water.gravity is 9.81 (line 6), mooring.water.gravity is 1.62 (line 10) m/s",
            ],
        ),
        (
            {"mooring": "depth: 40, density: 1.025"},
            ["hydro.water.density is 1025 (line 6), mooring.water.density is 1.025 (line 10) kg/"],
        ),
        ({"hydro": "depth: deep"}, ["hydro.water.depth is deep"]),
        (
            {"gravity": "9.7"},
            ["gravity of buoy's model is 9.7, hydro.water.gravity is 9.81 (line 6) m/s2"],
        ),
        ({"gravity": "g"}, []),
        ({"gravity": "g", "start": "g: 9.6"}, ["gravity of buoy's model is 9.6"]),
    ],
)
def test_water_and_gravity(given: dict[str, str], found: list[str], tmp_path: Path) -> None:
    """A default has the line of its section."""
    lines = told(tmp_path, **given)
    assert len(lines) == len(found)
    for line, text in zip(lines, found, strict=True):
        assert text in line


SEAS = """\
name: seas
components:
  hydro:
    kind: hydrodynamics
    water: &water {depth: 40}
    waves: &sea {spectrum: jonswap, significant_height: 2, peak_period: 7, seed: 3}
    CURRENT
    bodies: {float: {shape: {sphere: {radius: 3}}, center_of_gravity: [0, -1], drag: DRAG}}
    start: {START}
  gauge:
    kind: sea
    water: *water
    waves: WAVES
    OTHER
    points: {p: [20, 0]}
LINES
connections: []
simulation: {stop_time: 1, step_size: 0.1}
"""
MOORING = """\
  mooring:
    kind: mooring
    water: *water
    waves: {}
    line_types: {{c: {{diameter: 0.1, mass_per_length: 50, axial_stiffness: 1e8,
      axial_damping_ratio: 1, drag_coefficient: 1, added_mass_coefficient: 1}}}}
    anchors: {{a: [-50, -40]}}
    fairleads: [f]
    lines: {{l: {{type: c, from: a, to: f, unstretched_length: 70, segments: 4}}}}
"""
ALIKE = {"WAVES": "*sea", "START": "", "LINES": "", "CURRENT": "", "OTHER": "", "DRAG": "{}"}
SAME = "{spectrum: jonswap, significant_height: 2, peak_period: 7, seed: 3, direction: 0}"
WAVES = "the waves of hydro (line 6) and of gauge (line 13) differ: components in one sea need"
CURRENT = "the current of hydro (line"


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ({}, []),  # one sea, by an anchor
        ({"WAVES": SAME}, []),
        ({"WAVES": SAME.replace("seed: 3", "seed: 4")}, [WAVES]),
        ({"WAVES": "[*sea, {spectrum: regular, height: 1, period: 12}]"}, [WAVES]),
        ({"WAVES": "{spectrum: still}"}, [WAVES]),
        ({"START": "wave.significant_height: 3"}, ["the start values of waves of hydro (line 6)"]),
        # lines belong to the sea or say that they do not
        *(({"LINES": MOORING.format(waves)}, []) for waves in ("*sea", "none")),
        (
            {"LINES": MOORING.format("{spectrum: still}")},
            ["of mooring (line 19) differ: components in one"] * 2,
        ),
        ({"CURRENT": "current: {speed: 2}", "OTHER": "current: {speed: 2}"}, []),
        ({"CURRENT": "current: {speed: 2}", "OTHER": "current: {speed: 1}"}, [CURRENT]),
        ({"CURRENT": "current: {speed: 2}"}, [CURRENT]),
        # a hull that feels no current needs none
        ({"OTHER": "current: {speed: 1}"}, []),
        ({"OTHER": "current: {speed: 1}", "DRAG": "{heave: 1e4}"}, []),
        ({"OTHER": "current: {speed: 1}", "DRAG": "{surge: 1e4, water: still}"}, []),
        ({"OTHER": "current: {speed: 1}", "DRAG": "{surge: 1e4}"}, [CURRENT]),
        ({"OTHER": "current: {speed: 1}", "DRAG": "{linear: {surge: 1e4}}"}, [CURRENT]),
    ],
)
def test_seas_and_currents(given: dict[str, str], found: list[str], tmp_path: Path) -> None:
    text = SEAS
    for name, value in {**ALIKE, **given}.items():
        text = text.replace(name, value)
    (tmp_path / "seas.yaml").write_text(text)
    lines = differing(load_system(tmp_path / "seas.yaml"), {}, Wiring((), (), (), ()))
    assert len(lines) == len(found)
    for line, expected in zip(lines, found, strict=True):
        assert expected in line
