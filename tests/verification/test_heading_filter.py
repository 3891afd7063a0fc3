"""A barge that yaws slowly under a filter of the heading: coefficients and added mass follow it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.results.results_file import Results

MODEL = """\
name: barge
dimensions: 3
gravity: 9.81
bodies: {{hull: {{mass: neutral, inertia: [1.2e5, 3.5e5, 4.0e5], added_mass: true}}}}
joints: {{sea: {{type: floating, child: hull, initial: {{z: -0.5, psi: {start!r}}}}}}}
loads:
  springs:
    type: body_force
    body: hull
    force: ["-4e4*body.hull.x - 2e4*body.hull.vx", "-4e4*body.hull.y - 2e4*body.hull.vy", 0]
    moment: [0, 0, "-2e4*(body.hull.psi - {end!r}) - 4e5*body.hull.omega_z"]
"""
SYSTEM = """\
name: barge
components:
  barge: {{model: barge.model.yaml}}
  hydro:
    kind: hydrodynamics
    dimensions: 3
    heading: {heading}
{filter}
    bodies:
      hull:
        shape: {{box: {{length: 8, width: 4, draft: 1.5}}}}
        center_of_gravity: [0, 0, -0.5]
        panels: 100
        drag: {{heave: 1e5, roll: 1e7, pitch: 1e7}}
    frequencies: {{count: 16}}
    radiation: {{order: 8}}
    waves: {{spectrum: regular, height: 0.02, period: 5, direction: {direction}, ramp_time: 0}}
connections:
  - barge.body.hull <-> hydro.hull
  - hydro.added_mass -> barge.added_mass
simulation: {{stop_time: {stop}, step_size: 0.05, algorithm: corrector}}
"""
END = 60.0  # deg
TRANSLATIONS, ROTATIONS = ("x", "y", "z"), ("omega_x", "omega", "omega_z")


def results(
    folder: Path, *, start: float, heading: float, filter_time: float | None = None,
    world: float = 0.0, stop: float = 250.0,
) -> Results:  # fmt: skip
    """From the yaw `start` to 60 deg, all turned by `world` [deg]."""
    folder.mkdir()
    yaws = {"start": math.radians(start + world), "end": math.radians(END + world)}
    (folder / "barge.model.yaml").write_text(MODEL.format(**yaws), "utf-8")
    line = "" if filter_time is None else f"    heading_filter: {filter_time}"
    system = SYSTEM.format(heading=heading + world, filter=line, direction=world, stop=stop)
    path = folder / "system.yaml"
    path.write_text(system, "utf-8")
    prepared = prepare(load_system(path), build_directory=path.parent)
    return run(prepared, results=folder / "r.nc", certify=False).results()


def motion(found: Results, names: tuple[str, ...]) -> np.ndarray:
    return np.array([found[f"barge.body.hull.{name}"].values for name in names])


def added_mass(found: Results) -> np.ndarray:
    """(n, 6, 6) in world axes."""
    places = [f"hydro.added_mass[{i},{j}]" for i in range(1, 7) for j in range(1, 7)]
    return np.array([found[place].values for place in places]).T.reshape(-1, 6, 6)


@pytest.mark.verifies(
    "a barge in waves that has yawed by 60°, its heading filtered",
    analytic="symmetry: the barge with that heading from the start", tolerance="1e-4 of the motion",
)  # fmt: skip
def test_a_heading_that_followed_is_one_that_was_given(tmp_path: Path) -> None:
    turned = results(tmp_path / "turned", start=0.0, heading=0.0, filter_time=10.0)
    given = results(tmp_path / "given", start=END, heading=END)
    assert np.degrees(np.ptp(turned["barge.body.hull.psi"].values)) > 59.0
    for names in (TRANSLATIONS, ROTATIONS):
        found, expected = (motion(r, names)[:, -400:] for r in (turned, given))
        size = np.ptp(expected, axis=1).max()
        assert size > 1e-3
        # in waves the filtered heading sways by 1/(ωT) = 8 % of the yaw: terms of second order
        assert np.abs(found - expected).max() < 1e-4 * size


@pytest.mark.verifies(
    "a barge that yaws with its heading filtered, in a world turned by 37° about Z",
    analytic="symmetry: the same barge, not turned", tolerance="1e-10",
)  # fmt: skip
def test_a_turned_world_has_the_turned_motion(tmp_path: Path) -> None:
    plain = results(tmp_path / "plain", start=0.0, heading=0.0, filter_time=10.0, stop=40.0)
    aside = results(
        tmp_path / "aside", start=0.0, heading=0.0, filter_time=10.0, world=37.0, stop=40.0
    )
    c, s = math.cos(math.radians(37.0)), math.sin(math.radians(37.0))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for names in (TRANSLATIONS, ROTATIONS):
        expected = turn @ motion(plain, names)
        np.testing.assert_allclose(
            motion(aside, names), expected, rtol=0, atol=1e-10 * np.abs(expected).max()
        )
    both, before = np.kron(np.eye(2), turn), added_mass(plain)
    expected = both @ before @ both.T
    assert np.abs(before[-1] - before[0]).max() > 0.1 * np.abs(before).max()
    np.testing.assert_allclose(
        added_mass(aside), expected, rtol=0, atol=1e-10 * np.abs(expected).max()
    )
