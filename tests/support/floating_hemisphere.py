"""A floating hemisphere of panels and its motions in waves, by the package."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics import Hull, HydrodynamicsConfig, make_hulls, solve_hulls

RHO, G = 1000.0, 9.81


def hemisphere(*, panels: int, radius: float = 1.0) -> tuple[Hull, HydrodynamicsConfig]:
    """Its centre of gravity is the sphere's centre; water is deep."""
    config = HydrodynamicsConfig.model_validate(
        {
            "water": {"density": RHO, "gravity": G},
            "bodies": {
                "ball": {
                    "shape": {"sphere": {"radius": radius}},
                    "center_of_gravity": [0.0, 0.0],
                    "panels": panels,
                }
            },
        }
    )
    (hull,) = make_hulls(config, Path(), progress=lambda _: None)
    return hull, config


def free_motions(hull: Hull, config: HydrodynamicsConfig, omega: np.ndarray) -> np.ndarray:
    """Surge and heave of a floating hemisphere per wave amplitude, (nω, 1, 3) [m/m]."""
    found = solve_hulls([hull], water=config.water, omega=omega, progress=lambda _: None)
    w = omega[:, None, None]
    mass = RHO * hull.hydrostatics.volume * np.eye(3)
    inertia = -(w**2) * (mass + found.added_mass) - 1j * w * found.radiation_damping
    dynamic = (inertia + found.hydrostatic_stiffness)[:, :2, :2]
    moved = np.linalg.solve(dynamic, found.excitation[:, :2, None])[:, :, 0]
    return np.pad(moved, ((0, 0), (0, 1)))[:, None, :]
