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


def test_one_water_is_silent(tmp_path: Path) -> None:
    """Its defaults of gravity, 9.81 and 9.80665, are the same."""
    assert told(tmp_path) == []


def test_waters_that_differ_are_told(tmp_path: Path) -> None:
    """Each of the three values; a default has the line of its section."""
    depth, gravity = told(tmp_path, mooring="depth: 80, gravity: 1.62")
    assert depth == (
        "hydro.water.depth is 40 (line 6), mooring.water.depth is 80 (line 10) m: components in "
        "one water need the same"
    )
    assert "gravity is 9.81 (line 6), mooring.water.gravity is 1.62 (line 10) m/s2" in gravity
    (density,) = told(tmp_path, mooring="depth: 40, density: 1.025")
    assert "density is 1025 (line 6), mooring.water.density is 1.025 (line 10) kg/m3" in density
    (deep,) = told(tmp_path, hydro="depth: deep")
    assert "hydro.water.depth is deep" in deep


def test_the_gravity_of_a_model_is_compared_with_that_of_its_water(tmp_path: Path) -> None:
    """Also one that a start value sets."""
    (line,) = told(tmp_path, gravity="9.7")
    assert "gravity of buoy's model is 9.7, hydro.water.gravity is 9.81 (line 6) m/s2" in line
    assert told(tmp_path, gravity="g") == []
    (line,) = told(tmp_path, gravity="g", start="g: 9.6")
    assert "gravity of buoy's model is 9.6" in line


SEAS = """\
name: seas
components:
  hydro:
    kind: hydrodynamics
    water: &water {{depth: 40}}
    waves: &sea {{spectrum: jonswap, significant_height: 2, peak_period: 7, seed: 3}}
    bodies: {{float: {{shape: {{sphere: {{radius: 3}}}}, center_of_gravity: [0, -1]}}}}
    start: {{{start}}}
  gauge:
    kind: sea
    water: *water
    waves: {waves}
    points: {{p: [20, 0]}}
connections: []
simulation: {{stop_time: 1, step_size: 0.1}}
"""


def seas_told(folder: Path, waves: str, start: str = "") -> list[str]:
    (folder / "seas.yaml").write_text(SEAS.format(waves=waves, start=start))
    return differing(load_system(folder / "seas.yaml"), {}, Wiring((), (), (), ()))


def test_one_sea_written_once_is_silent(tmp_path: Path) -> None:
    """By an anchor, or the same words."""
    assert seas_told(tmp_path, "*sea") == []
    same = "{spectrum: jonswap, significant_height: 2, peak_period: 7, seed: 3, direction: 0}"
    assert seas_told(tmp_path, same) == []


def test_seas_that_differ_are_told(tmp_path: Path) -> None:
    """Another seed, one more system, none; one that a start value changes."""
    seed = "{spectrum: jonswap, significant_height: 2, peak_period: 7, seed: 4}"
    for other in (seed, "[*sea, {spectrum: regular, height: 1, period: 12}]", "{spectrum: still}"):
        (line,) = seas_told(tmp_path, other)
        assert line.startswith(
            "the waves of hydro (line 6) and of gauge (line 12) differ: components in one sea need"
        )
    (line,) = seas_told(tmp_path, "*sea", start="wave.significant_height: 3")
    assert line == (
        "the start values of waves of hydro (line 6) and of gauge (line 12) differ: components in "
        "one sea need the same: set them in all of them"
    )


LINES = """\
  mooring:
    kind: mooring
    water: *water
    waves: {waves}
    line_types: {{c: {{diameter: 0.1, mass_per_length: 50, axial_stiffness: 1e8,
      axial_damping_ratio: 1, drag_coefficient: 1, added_mass_coefficient: 1}}}}
    anchors: {{a: [-50, -40]}}
    fairleads: [f]
    lines: {{l: {{type: c, from: a, to: f, unstretched_length: 70, segments: 4}}}}
connections: []
"""


@pytest.mark.parametrize(("waves", "count"), [("*sea", 0), ("none", 0), ("{spectrum: still}", 2)])
def test_lines_belong_to_the_sea_or_say_that_they_do_not(
    tmp_path: Path, waves: str, count: int
) -> None:
    text = SEAS.format(waves="*sea", start="").replace(
        "connections: []\n", LINES.format(waves=waves)
    )
    (tmp_path / "seas.yaml").write_text(text)
    found = differing(load_system(tmp_path / "seas.yaml"), {}, Wiring((), (), (), ()))
    assert len(found) == count
    assert all("of mooring (line 17) differ: components in one sea need" in line for line in found)


@pytest.mark.parametrize(("speed", "count"), [("2", 0), ("1", 1), ("", 1)])
def test_currents_that_differ_are_told(tmp_path: Path, speed: str, count: int) -> None:
    """Another speed, or none."""
    text = SEAS.format(waves="*sea", start="")
    text = text.replace("    bodies:", "    current: {speed: 2}\n    bodies:")
    if speed:
        text = text.replace("    points:", f"    current: {{speed: {speed}}}\n    points:")
    (tmp_path / "seas.yaml").write_text(text)
    found = differing(load_system(tmp_path / "seas.yaml"), {}, Wiring((), (), (), ()))
    assert [line[:33] for line in found] == ["the current of hydro (line 7) and"] * count


@pytest.mark.parametrize(
    ("drag", "count"),
    [
        ("{}", 0),
        ("{heave: 1e4}", 0),
        ("{surge: 1e4, water: still}", 0),
        ("{surge: 1e4}", 1),
        ("{linear: {surge: 1e4}}", 1),
    ],
)
def test_a_hull_that_feels_no_current_needs_none(tmp_path: Path, drag: str, count: int) -> None:
    """Beside another component in a current; with horizontal drag it would feel it."""
    text = SEAS.format(waves="*sea", start="")
    text = text.replace("    points:", "    current: {speed: 1}\n    points:")
    text = text.replace("[0, -1]}", f"[0, -1], drag: {drag}}}")
    (tmp_path / "seas.yaml").write_text(text)
    found = differing(load_system(tmp_path / "seas.yaml"), {}, Wiring((), (), (), ()))
    assert [line[:21] for line in found] == ["the current of hydro "] * count
