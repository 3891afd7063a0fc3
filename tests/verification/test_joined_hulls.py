"""Two hulls in one water, joined by a hinge or a ball joint, in oblique waves: a turned world."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.results.results_file import Results

MODEL = """\
name: pair
dimensions: 3
gravity: 9.81
bodies:
  fore: {{mass: neutral, inertia: [1.0e5, 1.6e5, 2.0e5], added_mass: true}}
  aft: {{mass: neutral, inertia: [1.0e5, 1.6e5, 2.0e5], added_mass: true}}
joints:
  sea: {{type: floating, child: fore, initial: {{x: {x!r}, y: {y!r}, z: -0.4, psi: {psi!r}}}}}
  link: {{type: {joint}, parent: fore, child: aft, parent_to_joint: [-4, 0, 0],
         joint_to_child: [-4, 0, 0]{more}}}
"""
SYSTEM = """\
name: pair
components:
  pair: {{model: pair.model.yaml}}
  hydro:
    kind: hydrodynamics
    dimensions: 3
    heading: {heading}
    bodies:
      fore:
        shape: {{box: {{length: 6, width: 4, draft: 1.2, center_x: 4}}}}
        center_of_gravity: [4, 0, -0.4]
        panels: 100
        drag: {{surge: 1e4, sway: 1e4, heave: 1e4, roll: 1e5, pitch: 1e5, yaw: 1e5}}
      aft:
        shape: {{box: {{length: 6, width: 4, draft: 1.2, center_x: -4}}}}
        center_of_gravity: [-4, 0, -0.4]
        panels: 100
        drag: {{surge: 1e4, sway: 1e4, heave: 1e4, roll: 1e5, pitch: 1e5, yaw: 1e5}}
    frequencies: {{count: 16}}
    radiation: {{order: 8}}
    waves: {{spectrum: regular, height: 0.2, period: 5, direction: {direction}, ramp_time: 5}}
connections:
  - pair.body.fore <-> hydro.fore
  - pair.body.aft <-> hydro.aft
  - hydro.added_mass -> pair.added_mass
simulation: {{stop_time: 10, step_size: 0.05, algorithm: corrector}}
"""
VECTORS = (("x", "y", "z"), ("vx", "vy", "vz"), ("omega_x", "omega", "omega_z"))


def rotation(degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def results(folder: Path, joint: str, degrees: float) -> Results:
    folder.mkdir()
    x, y, _ = (rotation(degrees) @ [4.0, 0.0, 0.0]).tolist()
    yaw = math.radians(degrees)
    more = ", axis: [0, 1, 0]" if joint == "revolute" else f", initial: {{psi: {yaw!r}}}"
    (folder / "pair.model.yaml").write_text(
        MODEL.format(x=x, y=y, psi=yaw, joint=joint, more=more), "utf-8"
    )
    path = folder / "system.yaml"
    path.write_text(SYSTEM.format(heading=degrees, direction=30 + degrees), "utf-8")
    prepared = prepare(load_system(path), build_directory=path.parent)
    return run(prepared, results=folder / "r.nc", certify=False).results()


@pytest.mark.verifies(
    "two hulls in one water, joined by a hinge or a ball joint, in a world turned by 37° about Z",
    analytic="symmetry: the same hulls, not turned", tolerance="1e-10",
)  # fmt: skip
@pytest.mark.parametrize("joint", ["revolute", "spherical"])
def test_joined_hulls_in_a_turned_world(joint: str, tmp_path: Path) -> None:
    plain, aside = (results(tmp_path / f"{d}", joint, float(d)) for d in (0, 37))
    for body in ("fore", "aft"):
        for names in VECTORS:
            before, after = (
                np.array([r[f"pair.body.{body}.{name}"].values for name in names])
                for r in (plain, aside)
            )
            assert np.ptp(before, axis=1).min() > 1e-3
            assert np.abs(after - rotation(37.0) @ before).max() < 1e-10
