"""A planar body in water of space and the reverse, connected variable by variable: head waves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import Results

PLANAR = """\
name: buoy
bodies: {float: {mass: neutral, inertia: 2.0e5, added_mass: true}}
joints: {sea: {type: floating, child: float, initial: {z: -0.5}}}
"""
SPATIAL = PLANAR.replace("name: buoy", "name: buoy\ndimensions: 3").replace(
    "2.0e5", "[2.0e5, 2.0e5, 3.0e5]"
)
WATER = """\
    bodies:
      float:
        shape: {{box: {{length: 8, width: 8, draft: 1.5}}}}
        center_of_gravity: {center}
        panels: 48
    frequencies: {{count: 16}}
    radiation: {{order: 8}}
    waves: {{spectrum: regular, height: 0.3, period: 5, ramp_time: 5}}
"""
WATERS = {
    2: WATER.format(center="[0, -0.5]"),
    3: "    dimensions: 3\n" + WATER.format(center="[0, 0, -0.5]"),
}
MOTION, FORCE = ("x", "z", "theta", "vx", "vz", "omega"), ("force_x", "force_z", "moment_y")
PLACES = {2: (1, 2, 3), 3: (1, 3, 5)}
"""Surge, heave and pitch among the rows of the added mass."""


def one_by_one(body: int, water: int) -> list[str]:
    """Connections of surge, heave and pitch between a body and water of these dimensions."""
    links = [f"hydro.float.{name} -> buoy.body.float.{name}" for name in FORCE]
    links += [f"buoy.body.float.{name} -> hydro.float.{name}" for name in MOTION]
    pairs = list(zip(PLACES[water], PLACES[body], strict=True))
    for i, to_i in pairs:
        links += [
            f"hydro.added_mass[{i},{j}] -> buoy.added_mass[{to_i},{to_j}]" for j, to_j in pairs
        ]
    return [*links, "hydro.float.neutral_mass -> buoy.body.float.neutral_mass"]


def written(folder: Path, body: int, water: int, connections: list[str]) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "buoy.model.yaml").write_text({2: PLANAR, 3: SPATIAL}[body], "utf-8")
    lines = "".join(f'  - "{connection}"\n' for connection in connections)
    path = folder / "system.yaml"
    path.write_text(
        "name: buoy\ncomponents:\n  buoy: {model: buoy.model.yaml}\n"
        f"  hydro:\n    kind: hydrodynamics\n{WATERS[water]}"
        f"connections:\n{lines}simulation: {{stop_time: 10, step_size: 0.02}}\n",
        "utf-8",
    )
    return path


def results(folder: Path, body: int, water: int, connections: list[str]) -> Results:
    path = written(folder, body, water, connections)
    prepared = prepare(load_system(path), build_directory=path.parent)
    return run(prepared, results=folder / "r.nc", certify=False).results()


@pytest.mark.verifies(
    "a planar body in water of space, and a body of space in planar water, in head waves",
    independent="the planar body in planar water", tolerance="1e-7 of the range",
)  # fmt: skip
def test_head_waves(tmp_path: Path) -> None:
    whole = ["buoy.float <-> hydro.float", "hydro.added_mass -> buoy.added_mass"]
    plain = results(tmp_path / "plain", 2, 2, whole)
    for body, water in ((2, 3), (3, 2)):
        mixed = results(tmp_path / f"{body}{water}", body, water, one_by_one(body, water))
        for name in ("x", "z", "theta"):
            expected = np.asarray(plain[f"buoy.body.float.{name}"])
            found = np.asarray(mixed[f"buoy.body.float.{name}"])
            assert np.ptp(expected) > 0.01
            worst = np.abs(found - expected).max() / np.ptp(expected)
            assert worst < 1e-7, (body, water, name, worst)


def test_the_added_mass_of_other_dimensions_is_refused_with_the_way(tmp_path: Path) -> None:
    path = written(tmp_path, 2, 3, ["hydro.added_mass -> buoy.added_mass"])
    with pytest.raises(InputError) as error:
        prepare(load_system(path), build_directory=path.parent)
    assert "hydro.added_mass[1,1] -> buoy.added_mass[1,1]" in str(error.value)
    assert "hydro.added_mass[1,3] -> buoy.added_mass[1,2]" in str(error.value)
