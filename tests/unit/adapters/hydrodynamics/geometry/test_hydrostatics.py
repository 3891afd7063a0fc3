"""Hydrostatics of meshes against closed forms: exact for flat panels, and for curved ones in what
the shapes keep exactly (displacement and waterplane area)."""

import numpy as np
import pytest
from support.hulls import hull

from m4e_adapters.hydrodynamics.config import Box, Sphere
from m4e_adapters.hydrodynamics.geometry.hydrostatics import (
    hydrostatics_of,
)
from m4e_adapters.hydrodynamics.geometry.shapes import (
    box_panels,
    sphere_hydrostatics,
    sphere_panels,
)

RHO, G = 1025.0, 9.81
ROUNDING = 1e-10


def stiffness(shape: dict, center: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    water = hull(shape, center=center, panels=400).hydrostatics
    return water.stiffness(center, RHO, G), water.buoyancy(center, RHO, G)


@pytest.mark.parametrize("z", [0.0, -2.0, 2.0, -5.0, -8.0])
def test_a_sphere_has_no_stiffness_in_pitch_about_its_centre(z: float) -> None:
    """Water presses through its centre. Its panels alone say something else: by 1/panels."""
    shape = Sphere(radius=5.0, center_z=z, center_x=3.0)
    k, buoyancy = stiffness({"sphere": shape.model_dump()}, (3.0, z))
    largest = RHO * G * 4 / 3 * np.pi * 5.0**4
    np.testing.assert_allclose(k[2], 0.0, atol=ROUNDING * largest)
    assert buoyancy[2] == pytest.approx(0.0, abs=ROUNDING * largest)
    exact, panels = sphere_hydrostatics(shape), hydrostatics_of(sphere_panels(shape, 3000))
    assert exact.volume == pytest.approx(panels.volume, rel=ROUNDING)
    np.testing.assert_allclose(exact.waterplane, panels.waterplane, rtol=1e-6, atol=1e-9)
    centers = exact.center_of_buoyancy, panels.center_of_buoyancy
    np.testing.assert_allclose(*centers, rtol=1e-3, atol=1e-9)


def test_stiffness_is_the_change_of_buoyancy_of_a_moved_box() -> None:
    """A box aside of its centre of gravity: slender upright columns, to first order in angles."""
    center, n = np.array([0.5, -0.4, 0.3]), 400
    shape = Box(length=4.0, width=2.0, draft=1.0, center_x=0.2, center_y=0.7)
    hydrostatics = hydrostatics_of(box_panels(shape, 48))
    x = 0.2 + 4.0 * ((np.arange(n) + 0.5) / n - 0.5)
    y = 0.7 + 2.0 * ((np.arange(n) + 0.5) / n - 0.5)
    arms = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1) - center[:2]
    area = 8.0 / n**2

    def wrench(heave: float, roll: float, pitch: float, yaw: float) -> np.ndarray:
        """Of columns from the bottom at z = -1 to the water, each turned about the centre."""
        ax, ay = arms[..., 0], arms[..., 1]
        depth = 1.0 - heave - roll * ay + pitch * ax
        middle = -1.0 + depth / 2 - center[2]
        lift = RHO * G * area * depth
        across, along = ay + yaw * ax - roll * middle, ax - yaw * ay + pitch * middle
        return np.array([0, 0, lift.sum(), (across * lift).sum(), -(along * lift).sum(), 0])

    scale, step = RHO * G * 8.0, 1e-4
    buoyancy = hydrostatics.buoyancy(center.tolist(), RHO, G)
    np.testing.assert_allclose(buoyancy, wrench(0, 0, 0, 0), atol=1e-9 * scale)
    stiffness = hydrostatics.stiffness(center.tolist(), RHO, G)
    for k in range(4):
        after, before = (wrench(*(sign * step * np.eye(4)[k])) for sign in (1, -1))
        # columns resolve the second moments to 1/(12 n²)
        change = (before - after) / (2 * step)
        np.testing.assert_allclose(stiffness[:, 2 + k], change, atol=1e-5 * scale)
    # in the plane: surge, heave and pitch of the same
    plane, lift = (
        hydrostatics.stiffness((0.5, 0.3), RHO, G),
        hydrostatics.buoyancy((0.5, 0.3), RHO, G),
    )
    np.testing.assert_allclose(plane, stiffness[np.ix_([0, 2, 4], [0, 2, 4])], atol=1e-9 * scale)
    np.testing.assert_allclose(lift, buoyancy[[0, 2, 4]], atol=1e-9 * scale)
