"""Triangles cut by a plane: areas, volumes and sides against closed forms."""

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Box
from m4e_adapters.hydrodynamics.geometry.clipping import below
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of_triangles
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
ROUNDING = 1e-13


def area(triangles: np.ndarray) -> np.ndarray:
    """Vector area (3,) [m2] of `triangles` (n, 3, 3) [m]."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return 0.5 * np.cross(b - a, c - a).sum(axis=0)


@pytest.mark.parametrize("turned", [0, 1, 2])
@pytest.mark.parametrize(
    ("heights", "part", "pieces"),
    [
        ((-1.0, -1.0, -1.0), 1.0, 1),
        ((1.0, 1.0, 1.0), 0.0, 0),
        ((-1.0, 1.0, 1.0), 1 / 4, 1),
        ((-1.0, 3.0, 1.0), 1 / 8, 1),
        ((1.0, -1.0, -1.0), 3 / 4, 2),
        ((1.0, -3.0, -1.0), 7 / 8, 2),
        ((0.0, 0.0, 0.0), 0.0, 0),  # in the plane
        ((0.0, 0.0, -1.0), 1.0, 1),  # an edge in it
        ((0.0, -1.0, -1.0), 1.0, 2),  # a corner on it: the second piece is empty
        ((0.0, 1.0, 1.0), 0.0, 0),  # a corner on it
    ],
)
def test_one_triangle(heights: tuple[float, ...], part: float, pieces: int, turned: int) -> None:
    triangle = np.roll(CORNERS, turned, axis=0)[None]
    found = below(triangle, np.roll(heights, turned)[None])
    assert len(found) == pieces
    np.testing.assert_allclose(area(found), [0.0, 0.0, 0.5 * part], atol=ROUNDING)


def test_the_two_sides_of_a_plane_make_the_whole() -> None:
    """Their vector areas add up to that of the surface, and none reaches over the plane."""
    box = box_panels(Box(length=4.0, width=2.0, draft=1.0), 60).triangles
    random = np.random.default_rng(1)
    for _ in range(20):
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        cut = below(box, box @ normal + 0.1)
        rest = below(box, -(box @ normal + 0.1))
        np.testing.assert_allclose(area(cut) + area(rest), area(box), atol=1e-12)
        assert (cut @ normal).max() <= -0.1 + ROUNDING
        assert len(cut) + len(rest) > len(box)


def test_a_corner_of_a_cube_is_a_tetrahedron() -> None:
    """The plane x + y + z = s cuts s³/6 off a unit cube's corner, for s up to 1."""
    cube = box_panels(Box(length=1.0, width=1.0, draft=1.0), 24).triangles
    lid = np.array(
        [[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0]],
         [[-0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]]]
    )  # fmt: skip
    cube = np.concatenate([cube, lid]) + np.array([0.5, 0.5, 1.0])
    s = 0.7
    up = np.ones(3) / np.sqrt(3.0)
    along = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    frame = np.stack([along, np.cross(up, along), up])  # the plane's own axes, in which it is z = 0
    shift = np.array([0.0, 0.0, s / np.sqrt(3.0)])
    turned = cube @ frame.T - shift
    found = hydrostatics_of_triangles(below(turned, turned[:, :, 2]))
    assert found.volume == pytest.approx(s**3 / 6, rel=1e-12)
    assert found.waterplane[0] == pytest.approx(np.sqrt(3) / 2 * s**2, rel=1e-12)
    centre = frame.T @ (np.array(found.center_of_buoyancy) + shift)
    np.testing.assert_allclose(centre, s / 4, rtol=1e-12)
