"""Several bodies in one water: overlaps, narrow gaps, walls on which they slide, fixed ones."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import mesh_writers
from support.hulls import checked_program, configured, doubts, hull, hulls, silent

from m4e_adapters.hydrodynamics.build import frequency_table
from m4e_adapters.hydrodynamics.config import Box, Cylinder, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.panels import joined
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, cylinder_panels
from m4e_fmi.errors import InputError

BOX = {"length": 6.0, "width": 4.0, "draft": 2.0}


def boxes(apart: float, panels: int = 100) -> list[str]:
    """Problems and warnings of two boxes, 6 m long, whose middles are so far [m] apart."""
    body = {"center_of_gravity": [0, -1], "panels": panels}
    shapes = {name: {"box": {**BOX, "center_x": x}} for name, x in (("a", 0.0), ("b", apart))}
    told = doubts({"bodies": {name: {"shape": s, **body} for name, s in shapes.items()}})
    return [text for text in told if "centre of gravity" not in text]


def test_the_panels_that_a_warning_asks_for_are_enough() -> None:
    """Panels of 1.2 m: in gaps of 0.2 m they make damping that is negative by several times its
    largest value; from half a side to 2.5, a warning tells that they are inaccurate."""
    assert boxes(20.0) == boxes(9.2) == []
    (text,) = boxes(6.5)
    assert text.startswith("warning: the gap between bodies 'a' and 'b' is about 0.5 m wide")
    (text,) = boxes(8.0)
    needed = re.search(r"use about (\d+) and (\d+) panels, so that the gap has 2.5 of", text)
    assert needed
    assert needed[1] == needed[2]
    more = round(1.5 * int(needed[1]))  # edges have whole numbers of panels
    assert boxes(8.0, panels=more) == []


@pytest.mark.parametrize(
    ("radius", "said"), [(1.0, []), (3.7, ["the gap"]), (5.0, ["overlap"]), (7.0, ["overlap"])]
)
def test_a_body_in_the_opening_of_another_does_not_overlap(radius: float, said: list[str]) -> None:
    """A spar in a ring of 4 to 6 m: closed by its mirror image, the ring is not filled."""
    shapes = {
        "ring": {"revolved": {"profile": [[6, -2], [6, 0]], "hole": 4}},
        "spar": {"cylinder": {"radius": radius, "draft": 10}},
    }
    body = {"center_of_gravity": [0, -1.5], "panels": 400}
    found = doubts({"bodies": {name: {"shape": s, **body} for name, s in shapes.items()}})
    assert len(found) == len(said)
    assert all(part in text for part, text in zip(said, found, strict=True))


CORE, RING = (
    "revolved: {profile: [[2, -3], [2, 4]]}",
    "revolved: {profile: [[5, -3], [5, 4]], hole: 2}",
)
SPAR = "revolved: {profile: [[2, -9], [2, -3], [2, 4]]}"


def sliding(core: str, ring: str, panels: int = 100) -> str:
    return f"""\
water: {{density: 1000}}
bodies:
  ring: {{shape: {{{ring}}}, center_of_gravity: [0, -1], panels: 100}}
  core: {{shape: {{{core}}}, center_of_gravity: [0, -1], panels: {panels}, slides_on: ring}}
"""


def area(made: Hull) -> float:
    corners = made.panels.corners
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return 0.5 * float(np.linalg.norm(across, axis=1).sum())


def test_the_common_wall_is_dry() -> None:
    ring, core = hulls(sliding(SPAR, RING))
    outside, bottom = 2 * math.pi * 5 * 3, math.pi * (5**2 - 2**2)
    assert area(ring) == pytest.approx(outside + bottom, rel=0.02)
    assert area(core) == pytest.approx(2 * math.pi * 2 * 6 + math.pi * 2**2, rel=0.02)
    # buoyancy, waterplane and lids are those of whole hulls
    assert ring.hydrostatics.volume == pytest.approx(math.pi * (5**2 - 2**2) * 3)
    assert ring.hydrostatics.waterplane[0] == pytest.approx(math.pi * (5**2 - 2**2))
    assert core.hydrostatics.volume == pytest.approx(math.pi * 2**2 * 9)
    assert None not in (ring.lid, core.lid)
    assert len(ring.closed.faces) > len(ring.panels.faces)


def solved(made: tuple[Hull, ...], water: Water, *omega: float):
    return solve_hulls(made, water=water, omega=np.array(omega), progress=silent)


def test_two_parts_that_move_together_are_one_body() -> None:
    """A cylinder cut into a core and a ring: the sums of their coefficients are the cylinder's.

    Its bottom has other panels than theirs: forces of 100 panels are known to 2 %.
    """
    water, parts = Water(density=1000), hulls(sliding(CORE, RING))
    one = hull({"revolved": {"profile": [[2, -3], [5, -3], [5, 4]]}}, panels=100)
    two, single = (solved(made, water, 0.8, 1.4) for made in (parts, (one,)))
    together = np.tile(np.eye(3), (2, 1))  # both centres are at one place
    for name in ("added_mass", "radiation_damping", "added_mass_inf", "hydrostatic_stiffness"):
        ours = together.T @ getattr(two, name) @ together
        expected = getattr(single, name)
        assert ours == pytest.approx(expected, abs=0.02 * np.abs(expected).max())
    assert two.excitation @ together == pytest.approx(single.excitation, rel=0.02)


def test_bodies_that_overlap_beside_their_wall_are_refused(tmp_path: Path) -> None:
    """A box, and a mesh of another one beside it and a third within it."""
    beside = box_panels(Box(**BOX, center_x=6.0), 100)
    within = box_panels(Box(length=2.0, width=2.0, draft=1.0, center_x=-1.0), 100)
    body = {"center_of_gravity": [0, -1]}
    bodies: dict[str, Any] = {
        "box": {"shape": {"box": BOX}, "panels": 100, **body},
        "two": {"shape": {"mesh": "two.gdf"}, "slides_on": "box", **body},
    }
    (tmp_path / "two.gdf").write_text(mesh_writers.gdf(joined(beside, within)))
    found = doubts({"bodies": bodies}, tmp_path)
    assert [text for text in found if "bodies 'two' and 'box' overlap" in text]
    bodies["box"]["shape"]["box"] = {**BOX, "center_x": -0.01}  # the wall is still in common
    (tmp_path / "two.gdf").write_text(mesh_writers.gdf(beside))
    assert all(made.dry is not None for made in hulls({"bodies": bodies}, tmp_path))


DEPTH = 8.0
WATER = {"density": 1000, "depth": DEPTH}
FLOAT: dict[str, Any] = {
    "shape": {"cylinder": {"radius": 2, "draft": 2}}, "center_of_gravity": [0, -1], "panels": 60,
}  # fmt: skip
PILE: dict[str, Any] = {
    "shape": {"cylinder": {"radius": 2, "draft": DEPTH, "center_x": 6}}, "fixed": True, "panels": 60
}  # fmt: skip


def on_bed(**bodies: dict[str, Any]) -> dict[str, Any]:
    return {"water": WATER, "bodies": bodies}


def flow(*made: Hull):
    return solved(made, Water.model_validate(WATER), 1.2)


def test_a_fixed_body_has_no_variables_and_no_frequencies() -> None:
    alone, beside = (checked_program(on_bed(**b)) for b in ({"f": FLOAT}, {"p": PILE, "f": FLOAT}))
    for kind in ("inputs", "outputs", "states"):
        names = [v.name for v in getattr(beside, kind)]
        assert names == [v.name for v in getattr(alone, kind)]
    assert not any(v.name.startswith("p.") for v in beside.parameters)
    small = {**PILE, "shape": {"cylinder": {"radius": 0.5, "draft": DEPTH, "center_x": 6}}}
    one, two = (
        frequency_table(configured(given), hulls(given))
        for given in (on_bed(f=FLOAT), on_bed(p=small, f=FLOAT))
    )
    np.testing.assert_array_equal(two, one)


def test_a_fixed_body_acts_as_one_of_two_that_move() -> None:
    """Its rows and columns are left out of the coefficients of both, and nothing else changes."""
    pile, moving = hulls(on_bed(pile=PILE, float=FLOAT))
    assert (pile.fixed, moving.fixed) == (True, False)
    found = flow(pile, moving)
    assert found.bodies == ("float",)
    both = flow(replace(pile, fixed=False, center=(6.0, -4.0)), moving)
    for name in ("added_mass", "radiation_damping"):
        expected = getattr(both, name)[:, 3:, 3:]
        tolerance = 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, name), expected, atol=tolerance)
    np.testing.assert_allclose(found.excitation, both.excitation[:, 3:], rtol=1e-9)
    alone = flow(*hulls(on_bed(float=FLOAT)))
    change = np.abs(found.excitation - alone.excitation)[:, :2] / np.abs(alone.excitation)[:, :2]
    assert change.max() > 0.1
    # in space directions reach as far as the obstacle; mirror symmetry in y = 0 is kept
    given = {**on_bed(float={**FLOAT, "center_of_gravity": [0, 0, -1]}, pile=PILE), "dimensions": 3}
    space = flow(*hulls(given))
    np.testing.assert_array_equal(space.added_mass[0][[0, 2, 4]][:, [1, 3, 5]], 0.0)
    np.testing.assert_allclose(space.excitation[0, [0, 2, 4]], found.excitation[0], rtol=1e-4)


@pytest.mark.parametrize("bottom", [True, False])
def test_a_mesh_may_be_open_on_the_bed_if_it_is_fixed(tmp_path: Path, bottom: bool) -> None:
    """It makes the same flow as the shape, and other bodies are seen to be outside of it."""
    panels = cylinder_panels(Cylinder(radius=2, draft=DEPTH, center_x=6), 60)
    if not bottom:
        panels = panels.selected(panels.centers[:, 2] > -DEPTH + 1e-6)
    (tmp_path / "pile.gdf").write_text(mesh_writers.gdf(panels))
    body = {"shape": {"mesh": "pile.gdf"}, "fixed": True}
    made = hulls(on_bed(pile=body, float=FLOAT), tmp_path)
    expected = flow(*hulls(on_bed(pile=PILE, float=FLOAT)))
    np.testing.assert_allclose(flow(*made).excitation, expected.excitation, rtol=1e-5)
    assert made[0].hydrostatics.volume == pytest.approx(np.pi * 4 * DEPTH, rel=1e-6)
    within = {**FLOAT, "shape": {"sphere": {"radius": 0.5, "center_x": 6, "center_z": -4}}}
    found = doubts(on_bed(pile=body, ball=within), tmp_path)
    assert any("'pile' and 'ball' overlap" in text for text in found)
    with pytest.raises(InputError, match="not watertight" if not bottom else "the sea bed is at"):
        hulls(on_bed(p={"shape": {"mesh": "pile.gdf"}, "center_of_gravity": [6, -2]}), tmp_path)
