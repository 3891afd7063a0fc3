"""Moorings described in a system file: free points, seabed, strengths, winches."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.lines_in_waves import mooring_of, started

from m4e_adapters.moordyn.bathymetry import FILE, bathymetry
from m4e_adapters.moordyn.mooring import Failure
from m4e_fmi.errors import InputError

DENSITY, GRAVITY = 1025.0, 9.80665
HANGING = """\
dimensions: 3
water: {density: 1025, depth: 100, gravity: 9.80665}
line_types:
  rope: {diameter: 0.05, mass_per_length: 4, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
         drag_coefficient: 1.2, added_mass_coefficient: 1, breaking_strength: 5.0e+5}
anchors: {deep: [0, 0, -100]}
points:
  clump: {position: [40, 3, -60], mass: 3000, volume: 0.4, force: [0, 800, 0]}
  buoy: {position: [0, 0, -60], mass: 500, volume: 3, drag_area: 2, added_mass_coefficient: 0.5}
fairleads: {bow: [40, 3, -5]}
lines:
  tether: {type: rope, from: deep, to: buoy, unstretched_length: 40, segments: 8}
  pendant: {type: rope, from: clump, to: bow, unstretched_length: 30, segments: 6, breaks: true}
  joint: {type: rope, from: clump, to: buoy, unstretched_length: 90, segments: 6, winch: true}
"""
ROPE_WEIGHT = (4 - DENSITY * np.pi * 0.05**2 / 4) * GRAVITY


def test_free_points_start_at_rest_with_their_weight_buoyancy_and_force() -> None:
    """All that hangs on the fairlead and the anchor, from the weights of its parts."""
    made = mooring_of(HANGING)
    lines = started(replace(made, winches=()))
    (force,) = lines.force
    clump = (DENSITY * 0.4 - 3000) * GRAVITY
    buoy = (DENSITY * 3 - 500) * GRAVITY
    assert not lines.warnings
    assert made.points == {"clump": 3, "buoy": 4}
    anchor = np.array(lines.node_position(0, 1)) - np.array(lines.node_position(0, 0))
    stretch = np.linalg.norm(anchor) - 5
    pull = 1e8 / 5 * stretch * anchor / np.linalg.norm(anchor)  # without half a segment's weight
    pull[2] -= 2.5 * ROPE_WEIGHT
    whole = np.array([0, 800, clump + buoy - 160 * ROPE_WEIGHT])
    assert np.array(force) + pull == pytest.approx(whole, abs=1e-5 * buoy)
    lines.close()


def test_strengths_breaks_and_winches_are_of_the_lines_that_have_them() -> None:
    made = mooring_of(HANGING)
    assert made.failures == (Failure(((1, 1),), tension=5e5),)
    assert made.winches == (2,)
    assert made.strengths == dict.fromkeys(made.lines, 5e5)
    assert made.anchors == {"deep": 1}


def test_drag_of_a_free_point_shortens_the_internal_step() -> None:
    """Its decay rate ρ CdA V over its mass is within the bound of RK2: at most 2."""
    made = mooring_of(HANGING.replace("drag_area: 2,", "drag_area: 2000,"))
    mass = 500 + DENSITY * 3 * 0.5 + 2 * (5 + 15) / 2 * 4
    assert made.time_step < 2 / (DENSITY * 2000 * 5 / mass)
    assert mooring_of(HANGING).time_step > made.time_step


def test_a_segment_between_free_points_bounds_the_internal_step() -> None:
    """The whole of a line of one segment moves if a point at its end does."""
    anchored = HANGING.replace("segments: 8", "segments: 1").replace("segments: 6", "segments: 1")
    made = mooring_of(anchored)
    omega = 2 / 30 * np.sqrt(1e8 / 4)  # of the shortest line
    assert made.time_step < 2 / omega


def test_friction_is_that_of_moordyn() -> None:
    made = mooring_of(HANGING + "seabed: {friction: 0.6, friction_damping: 300}\n")
    assert {"0.6 frictioncoefficient", "300.0 fricdamp"} < set(made.text.splitlines())


def test_a_profile_of_the_seabed_is_a_grid(tmp_path: Path) -> None:
    bed = bathymetry([(100.0, 40.0), (-100.0, 60.0)], folder=tmp_path)
    assert [bed.at(x, 7.0) for x in (-200, 0, 50)] == [60, 50, 45]
    (tmp_path / "bed.csv").write_text("x [m],y [m],depth [m]\n0,0,10\n0,2,20\n4,0,30\n4,2,60\n")
    grid = bathymetry("bed.csv", folder=tmp_path)
    assert grid.at(2.0, 1.0) == pytest.approx((10 + 20 + 30 + 60) / 4, rel=1e-12)
    assert grid.file.decode().splitlines()[:4] == ["2 2", "0.0 4.0", "0.0 2.0", "0.0 0.0 -10.0"]


def test_a_seabed_that_is_not_flat_is_in_a_file_of_moordyn() -> None:
    bed = "seabed: {bathymetry: [[-300, 80], [300, 140]]}\n"
    made = mooring_of(HANGING + bed)
    assert f"{FILE} SeafloorFile" in made.text.splitlines()
    assert made.files.keys() == {FILE}
    assert (made.bed, made.net) == (-140, None)
    with pytest.raises(InputError, match="deep at z = -120 m lies below the seabed, there at -110"):
        mooring_of(HANGING.replace("[0, 0, -100]", "[0, 0, -120]") + bed)


@pytest.mark.parametrize(
    "rows",
    [
        "[[0, 1], [0, 1]]",
        "[[0, 1, 50]]",
        "[[0, 0, 50], [1, 0, 50], [0, 1, 50]]",
        "[[0, 50], [1, 0, 60]]",
        "[[0, 50], [1, 60], [1, 60]]",
    ],
)
def test_rows_of_no_grid_are_refused(rows: str) -> None:
    with pytest.raises(InputError, match="are not those of a grid"):
        mooring_of(HANGING + f"seabed: {{bathymetry: {rows}}}\n")


def test_a_line_lies_on_a_slope() -> None:
    """As deep in the bed as its spring lets its weight in water sink."""
    lines = started(
        mooring_of(
            "water: {density: 1025, depth: 50}\n"
            "seabed: {bathymetry: [[0, 50], [300, 40]]}\n"
            "line_types:\n"
            "  chain: {diameter: 0.1, mass_per_length: 110, axial_stiffness: 1.0e+9,\n"
            "          axial_damping_ratio: 1, drag_coefficient: 1.2, added_mass_coefficient: 1}\n"
            "anchors: {a: [0, -50]}\n"
            "fairleads: {f: [275, 0]}\n"
            "lines: {l: {type: chain, from: a, to: f, unstretched_length: 300, segments: 20}}\n"
        )
    )
    assert not lines.warnings
    sunk = (110 - DENSITY * np.pi * 0.1**2 / 4) * GRAVITY / (3e6 * 0.1)
    for node in range(1, 15):
        x, _, z = lines.node_position(0, node)
        assert -50 + x / 30 - z == pytest.approx(sunk, rel=0.01)
    lines.close()
