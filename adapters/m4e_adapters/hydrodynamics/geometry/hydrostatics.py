"""Hydrostatics of a wetted surface: exact integrals over its (triangulated) panels.

Buoyancy only: the weight of the dry body belongs to whoever holds its mass, and makes no moment
about its centre of gravity G. With S the waterplane, V the displaced volume, B its centre:

    K_33 = ρ g A_wp      K_35 = K_53 = −ρ g ∫(x − x_G) dS
    K_55 = ρ g [∫(x − x_G)² dS + V (z_B − z_G)]

in the planar motions (surge, heave, pitch about G). Pitch turns +Z towards +X about +Y, so the bow
at +X goes down: that is the sign of K_35.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.geometry.panels import Panels


@dataclass(frozen=True)
class Hydrostatics:
    """`volume` [m3], centre of buoyancy (x_B, z_B) [m], waterplane ∫(1, x, x²) dS [m2, m3, m4]."""

    volume: float
    center_of_buoyancy: tuple[float, float]
    waterplane: tuple[float, float, float]

    def stiffness(self, center: tuple[float, float], density: float, gravity: float) -> np.ndarray:
        """Hydrostatic stiffness (3, 3) [N/m, N/rad, N.m/m, N.m/rad]: force = −K·displacement.

        About `center` (x_G, z_G) [m], in water of `density` [kg/m3] under `gravity` [m/s2].
        """
        x_g, z_g = center
        area, first, second = self.waterplane
        lever = first - x_g * area
        result = np.zeros((3, 3))
        result[1, 1] = area
        result[1, 2] = result[2, 1] = -lever
        result[2, 2] = second - 2 * x_g * first + x_g**2 * area
        result[2, 2] += self.volume * (self.center_of_buoyancy[1] - z_g)
        return density * gravity * result

    def metacentric_height(self, center: tuple[float, float]) -> float:
        """GM [m] about `center`: pitch stiffness of a free body over its weight.

        The waterplane's moment counts about its own middle, since heave follows freely.
        """
        area, first, second = self.waterplane
        inertia = second - first**2 / area if area > 0 else 0.0
        return inertia / self.volume + self.center_of_buoyancy[1] - center[1]

    def buoyancy(self, center: tuple[float, float], density: float, gravity: float) -> np.ndarray:
        """Force [N, N] and moment about `center` [N.m] of the water in the reference pose, (3,)."""
        force = density * gravity * self.volume
        return np.array([0.0, force, -(self.center_of_buoyancy[0] - center[0]) * force])


def hydrostatics_of(panels: Panels) -> Hydrostatics:
    """Hydrostatics of a surface that is closed but for its waterline at z = 0.

    The volume is the sum of the tetrahedra that the triangles make with the origin; those of the
    missing waterplane are empty because the origin lies in it.
    """
    triangles = panels.triangles
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = 0.5 * np.cross(b - a, c - a)  # vector areas, into the water
    tetrahedra = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = float(tetrahedra.sum())
    moments = np.einsum("i,ij->j", tetrahedra, a + b + c) / 4.0
    below = -area[:, 2]  # what each triangle covers of the waterplane
    x = triangles[:, :, 0]
    mean_square = (np.square(x).sum(axis=1) + np.square(x.sum(axis=1))) / 12.0
    area_wp, first, second = (float((below * f).sum()) for f in (1.0, x.mean(axis=1), mean_square))
    center = moments / volume if volume else moments
    return Hydrostatics(volume, (float(center[0]), float(center[2])), (area_wp, first, second))
