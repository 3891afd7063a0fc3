"""Bodies that slide on each other: dry walls, holes through bodies of revolution, refusals."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Box, HydrodynamicsConfig, Sphere
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.contact import SlidingError, common_walls
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, hulls_and_problems, make_hulls
from m4e_adapters.hydrodynamics.geometry.panels import Panels, joined
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, sphere_panels
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document

CORE, RING = (
    "revolved: {profile: [[2, -3], [2, 4]]}",
    "revolved: {profile: [[5, -3], [5, 4]], hole: 2}",
)
SPAR = "revolved: {profile: [[2, -9], [2, -3], [2, 4]]}"


def two_bodies(core: str, ring: str, slides: str = "slides_on: ring") -> HydrodynamicsConfig:
    return Document.parse(f"""
water: {{density: 1000}}
bodies:
  ring: {{shape: {{{ring}}}, center_of_gravity: [0, -1], panels: 100}}
  core: {{shape: {{{core}}}, center_of_gravity: [0, -1], panels: 100, {slides}}}
""").validate(HydrodynamicsConfig)


def hulls_of(core: str, ring: str) -> tuple[Hull, ...]:
    return make_hulls(two_bodies(core, ring), Path(), progress=lambda _: None)


def written(panels: Panels, path: Path) -> None:
    """`panels` as a WAMIT .gdf file."""
    lines = ["test", "1.0 9.81", "0 0", str(len(panels.faces))]
    lines += [" ".join(f"{x:.9g}" for x in corner) for face in panels.corners for corner in face]
    path.write_text("\n".join(lines) + "\n")


def area(hull: Hull) -> float:
    corners = hull.panels.corners
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return 0.5 * float(np.linalg.norm(across, axis=1).sum())


def test_the_common_wall_is_dry() -> None:
    ring, core = hulls_of(SPAR, RING)
    outside, bottom = 2 * math.pi * 5 * 3, math.pi * (5**2 - 2**2)
    assert area(ring) == pytest.approx(outside + bottom, rel=0.02)
    assert area(core) == pytest.approx(2 * math.pi * 2 * 6 + math.pi * 2**2, rel=0.02)
    # buoyancy, waterplane and lids are those of whole hulls
    assert ring.hydrostatics.volume == pytest.approx(math.pi * (5**2 - 2**2) * 3)
    assert ring.hydrostatics.waterplane[0] == pytest.approx(math.pi * (5**2 - 2**2))
    assert core.hydrostatics.volume == pytest.approx(math.pi * 2**2 * 9)
    assert None not in (ring.lid, core.lid)
    assert len(ring.closed.faces) > len(ring.panels.faces)


def test_slender_panels_of_a_wall_end_with_it() -> None:
    """The spar's next panel begins where the wall ends, whose panels have sharp triangles."""
    ring = "revolved: {profile: [[5, -3], [10, -2], [10, 5]], hole: 3}"
    config = Document.parse(f"""
water: {{density: 1000}}
bodies:
  ring: {{shape: {{{ring}}}, center_of_gravity: [0, -1], panels: 400}}
  spar:
    shape: {{revolved: {{profile: [[15, -10], [3, -9.9], [3, -5], [3, -3], [3, 10]]}}}}
    center_of_gravity: [0, -1]
    panels: 1400
    slides_on: ring
""").validate(HydrodynamicsConfig)
    _, spar = make_hulls(config, Path(), progress=lambda _: None)
    assert spar.dry is not None
    assert spar.dry.corners[:, :, 2].min() == pytest.approx(-3.0)
    assert spar.panels.corners[:, :, 2].max() == pytest.approx(-3.0)


def test_two_parts_that_move_together_are_one_body() -> None:
    """A cylinder cut into a core and a ring: the sums of their coefficients are the cylinder's.

    Its bottom has other panels than theirs: forces of 100 panels are known to 2 %.
    """
    parts = hulls_of(CORE, RING)
    whole = Document.parse("""
water: {density: 1000}
bodies:
  whole:
    shape: {revolved: {profile: [[2, -3], [5, -3], [5, 4]]}}
    center_of_gravity: [0, -1]
    panels: 100
""").validate(HydrodynamicsConfig)
    (one,) = make_hulls(whole, Path(), progress=lambda _: None)
    omega = np.array([0.8, 1.4])
    two, single = (
        solve_hulls(hulls, water=whole.water, omega=omega, progress=lambda _: None)
        for hulls in (parts, (one,))
    )
    together = np.tile(np.eye(3), (2, 1))  # both centres are at one place
    for name in ("added_mass", "radiation_damping", "added_mass_inf", "hydrostatic_stiffness"):
        ours = together.T @ getattr(two, name) @ together
        expected = getattr(single, name)
        assert ours == pytest.approx(expected, abs=0.02 * np.abs(expected).max())
    assert two.excitation @ together == pytest.approx(single.excitation, rel=0.02)


@pytest.mark.parametrize(
    ("core", "ring", "message"),
    [
        ("revolved: {profile: [[1.5, -3], [1.5, 4]]}", RING, "have no wall in common"),
        ("revolved: {profile: [[2, -5], [2, 4]]}", RING, "lie only partly on the wall"),
        ("revolved: {profile: [[2.6, -3], [2.6, 4]]}", RING, "have no wall in common"),
    ],
    ids=["a gap", "no edge at the end of the wall", "too wide"],
)
def test_bodies_that_do_not_slide_are_refused(core: str, ring: str, message: str) -> None:
    _, problems = hulls_and_problems(two_bodies(core, ring), Path(), progress=lambda _: None)
    assert [problem.keys for problem in problems] == [("bodies", "core", "slides_on")]
    assert message in problems[0].message
    assert "'core' and 'ring'" in problems[0].message


def test_bodies_that_overlap_beside_their_wall_are_refused(tmp_path: Path) -> None:
    """A box, and a mesh of another one beside it and a third within it."""
    size = {"length": 6.0, "width": 4.0, "draft": 2.0}
    beside = box_panels(Box(**size, center_x=6.0), 100)
    within = box_panels(Box(length=2.0, width=2.0, draft=1.0, center_x=-1.0), 100)
    written(joined(beside, within), tmp_path / "two.gdf")
    bodies = {
        "box": {"shape": {"box": size}, "panels": 100, "center_of_gravity": [0, -1]},
        "two": {
            "shape": {"mesh": "two.gdf"},
            "center_of_gravity": [0, -1],
            "slides_on": "box",
        },
    }
    config = HydrodynamicsConfig.model_validate({"bodies": bodies})
    _, problems = hulls_and_problems(config, tmp_path, progress=lambda _: None)
    assert ["bodies 'two' and 'box' overlap" in problem.message for problem in problems] == [True]
    bodies["box"]["shape"]["box"] = {**size, "center_x": -0.01}  # the wall is still in common
    written(beside, tmp_path / "two.gdf")
    hulls = make_hulls(
        HydrodynamicsConfig.model_validate({"bodies": bodies}), tmp_path, progress=lambda _: None
    )
    assert [hull.dry is not None for hull in hulls] == [True, True]


def test_a_wall_that_faces_all_ways_holds_the_bodies() -> None:
    ball = sphere_panels(Sphere(radius=2.0, center_z=-5.0), 100)
    with pytest.raises(SlidingError, match="faces all ways"):
        common_walls(ball, ball.reversed, whole=(ball, ball.reversed))


@pytest.mark.parametrize("other", ["core", "sleeve"])
def test_a_body_slides_on_another_one_of_the_file(other: str) -> None:
    with pytest.raises(InputError, match=f"slides on '{other}', which is no other body"):
        two_bodies(CORE, RING, f"slides_on: {other}")


def test_without_the_key_bodies_that_touch_are_refused() -> None:
    config = two_bodies(SPAR, RING, "fixed: false")
    _, problems = hulls_and_problems(config, Path(), progress=lambda _: None)
    assert "'ring' and 'core'" in problems[0].message


def test_a_ring_below_the_water_is_closed() -> None:
    (sunk,) = make_hulls(
        Document.parse("""
bodies:
  ring:
    shape: {revolved: {profile: [[3, -6], [5, -5], [5, -4]], hole: 2}}
    center_of_gravity: [0, -5]
""").validate(HydrodynamicsConfig),
        Path(),
        progress=lambda _: None,
    )
    frustum = math.pi / 3 * (3**2 + 3 * 5 + 5**2)
    assert sunk.hydrostatics.volume == pytest.approx(frustum + math.pi * 5**2 - math.pi * 2**2 * 2)
    assert sunk.hydrostatics.waterplane[0] == pytest.approx(0.0, abs=1e-9)


def test_a_profile_that_enters_its_hole_is_refused() -> None:
    with pytest.raises(InputError, match="a radius of 1 m, in the hole of 2 m"):
        two_bodies(CORE, "revolved: {profile: [[1, -3], [5, -2], [5, 4]], hole: 2}")
