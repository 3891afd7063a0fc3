"""The flap of WEC-Sim's OSWEC on its base (STL files of WEC-Sim, Apache-2.0) against its file.

The file was made with Capytaine 2.3.1, its "indirect" method, 3968 panels of the flap and 2672 of
the base. With these meshes and that method Capytaine 3.0 gives the file's added mass about the
hinge at 0.32 rad/s to 0.04 %, which is 0.02 % of the natural period. Here the files of the geometry
are used, with the "direct" method: 1042 triangles of the flap, and the 12 of the base divided.
The limit is 0.9 % below the file's period, its stated error 0.4 %. The file states none; its method
is of first order in the size of the panels.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.published_coefficients import FLAP_ARM, flap

from m4e_adapters.hydrodynamics import Coefficients, make_hull, solve_hulls
from m4e_adapters.hydrodynamics.config import Body, Water
from m4e_adapters.hydrodynamics.refinement import study

DATA = Path(__file__).parents[1] / "data" / "hydrodynamics"
OMEGA, HINGE, DEPTH = 0.32, -8.9, 10.9  # near the natural frequency; m
MASS, INERTIA, GRAVITY = 127000.0, 1.85e6, 9.81  # dry, about its centre of gravity
VOLUME, PITCH_STIFFNESS = 297.376, -1.9335e6  # of the file
STIFFNESS = PITCH_STIFFNESS + (1000 * VOLUME - MASS) * GRAVITY * FLAP_ARM


def solved(*, of_flap: int, of_base: int) -> tuple[int, Coefficients]:
    """Number of panels, and coefficients about the hinge, each panel divided into these parts²."""
    bodies = {
        "flap": (
            {
                "shape": {"mesh": "oswec_flap.stl", "mesh_origin": [0, -3.9]},
                "center_of_gravity": [0, HINGE],
            },
            of_flap,
        ),
        "base": (
            {"shape": {"mesh": "oswec_base.stl", "mesh_origin": [0, -DEPTH]}, "fixed": True},
            of_base,
        ),
    }
    hulls = [
        make_hull(name, Body.model_validate(body), DATA, depth=DEPTH, finer=finer, progress=print)
        for name, (body, finer) in bodies.items()
    ]
    assert hulls[1].bed is not None
    found = solve_hulls(
        hulls,
        water=Water(density=1000.0, depth=DEPTH),
        omega=np.array([OMEGA]),
        progress=lambda _: None,
    )
    return sum(len(hull.panels.faces) for hull in hulls), found


def published() -> float:
    """Added mass of the file about the hinge at 0.32 rad/s [kg.m2]."""
    c = flap()
    (a,) = c.added_mass[np.isclose(c.omega, OMEGA)]
    return float(a[2, 2] + FLAP_ARM * (a[0, 2] + a[2, 0]) + FLAP_ARM**2 * a[0, 0])


def period(added_mass: float) -> float:
    """Natural period [s] with that added mass about the hinge."""
    inertia = INERTIA + MASS * FLAP_ARM**2 + added_mass
    return 2 * math.pi * math.sqrt(inertia / STIFFNESS)


def test_the_natural_period_is_that_of_the_file() -> None:
    meshes = [solved(of_flap=1, of_base=4), solved(of_flap=2, of_base=8)]
    found = study([count for count, _ in meshes], [c for _, c in meshes])
    expected = period(published())
    for count, c in meshes:
        ours = period(c.added_mass[0, 2, 2])
        print(f"{count} panels: {ours:.3f} s, file {expected:.3f} s: {ours / expected - 1:+.3%}")
    limit, error = found.limit.added_mass[0, 2, 2], found.added_mass.remaining[2, 2]
    ours = period(limit)
    stated = period(limit + error) - ours
    print(f"limit {ours:.3f} s, stated error {stated:.3f} s: {ours / expected - 1:+.3%}")
    assert ours == pytest.approx(expected, rel=1.5e-2)
    assert stated < 1.5e-2 * expected
