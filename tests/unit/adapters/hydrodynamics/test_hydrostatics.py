"""Hydrostatics of meshes against closed forms: exact for flat panels, and for curved ones in what
the shapes keep exactly (displacement and waterplane area)."""

from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Body, Sphere
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import make_hull
from m4e_adapters.hydrodynamics.geometry.shapes import sphere_hydrostatics, sphere_panels

RHO, G = 1025.0, 9.81
ROUNDING = 1e-10


def stiffness(shape: dict, center: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    body = Body.model_validate({"shape": shape, "center_of_gravity": center, "panels": 400})
    hydrostatics = make_hull("b", body, Path(), progress=lambda _: None).hydrostatics
    return hydrostatics.stiffness(center, RHO, G), hydrostatics.buoyancy(center, RHO, G)


def test_box() -> None:
    length, width, draft, z_g = 20.0, 10.0, 4.0, 1.5
    shape = {"box": {"length": length, "width": width, "draft": draft}}
    k, buoyancy = stiffness(shape, (0.0, z_g))
    area, volume = length * width, length * width * draft
    pitch = width * length**3 / 12 + volume * (-draft / 2 - z_g)
    expected = RHO * G * np.diag([0.0, area, pitch])
    np.testing.assert_allclose(k, expected, rtol=ROUNDING, atol=ROUNDING * expected.max())
    np.testing.assert_allclose(buoyancy, [0, RHO * G * volume, 0], atol=ROUNDING * buoyancy[1])


def test_cylinder() -> None:
    radius, draft, z_g = 4.0, 3.0, -1.2
    k, buoyancy = stiffness({"cylinder": {"radius": radius, "draft": draft}}, (0.0, z_g))
    area = np.pi * radius**2
    assert k[1, 1] == pytest.approx(RHO * G * area, rel=ROUNDING)
    assert buoyancy[1] == pytest.approx(RHO * G * area * draft, rel=ROUNDING)
    # a regular n-gon of the circle's area exceeds its second moment by (2π/n)⁴/180; n ≥ 32 here
    moment = np.pi * radius**4 / 4
    pitch = RHO * G * (moment + area * draft * (-draft / 2 - z_g))
    assert k[2, 2] == pytest.approx(pitch, abs=RHO * G * moment * (2 * np.pi / 32) ** 4 / 180)


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


def test_the_lever_of_a_body_off_its_center_of_gravity() -> None:
    """Pitch lowers the bow (+X): a hull ahead of G is pushed up, and turned back, by it."""
    shape = {"box": {"length": 4.0, "width": 2.0, "draft": 1.0, "center_x": 3.0}}
    k, buoyancy = stiffness(shape, (1.0, 0.0))
    area, lever = 8.0, 2.0
    assert k[1, 2] == pytest.approx(-RHO * G * area * lever, rel=ROUNDING)
    assert k[2, 1] == pytest.approx(k[1, 2], rel=ROUNDING)
    second = 2.0 * 4.0**3 / 12 + area * lever**2
    assert k[2, 2] == pytest.approx(RHO * G * (second + 8.0 * -0.5), rel=ROUNDING)
    # M_y = r_z F_x - r_x F_z: buoyancy ahead of G turns +X up, against theta
    assert buoyancy[2] == pytest.approx(-lever * RHO * G * 8.0, rel=ROUNDING)


def test_stiffness_is_the_change_of_buoyancy_of_a_moved_box() -> None:
    """Finite motion of a box that stays cut on all four sides: exact integration by geometry."""
    length, width, draft = 4.0, 2.0, 1.0
    shape = {"box": {"length": length, "width": width, "draft": draft}}
    center = (0.5, 0.3)
    k, buoyancy = stiffness(shape, center)
    step = 1e-4
    x = (np.arange(4000) + 0.5) / 4000 * length - length / 2

    def wrench(heave: float, theta: float) -> np.ndarray:
        """Hydrostatic force of slender upright slices of the box, to first order in theta."""
        depth = draft - heave + theta * (x - center[0])  # R(θ): x lowers by θ x
        slice_force = RHO * G * width * (length / 4000) * depth
        middle = -draft + depth / 2  # of the immersed part, in the body
        arm_x = (x - center[0]) + theta * (middle - center[1])
        return np.array([0.0, slice_force.sum(), -(arm_x * slice_force).sum()])

    scale = RHO * G * 8.0
    np.testing.assert_allclose(wrench(0, 0), buoyancy, atol=1e-9 * scale)
    heave = -(wrench(step, 0) - wrench(-step, 0)) / (2 * step)
    pitch = -(wrench(0, step) - wrench(0, -step)) / (2 * step)
    # slices resolve ∫x² to 1/(12·4000²)
    np.testing.assert_allclose(heave[1:], k[1:, 1], atol=1e-6 * scale)
    np.testing.assert_allclose(pitch[1:], k[1:, 2], atol=1e-6 * scale)
