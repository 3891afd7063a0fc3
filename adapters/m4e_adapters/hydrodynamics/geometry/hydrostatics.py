"""Hydrostatics of a wetted surface: exact integrals over its (triangulated) panels.

Buoyancy only: the weight of the dry body belongs to whoever holds its mass, and makes no moment
about its centre of gravity G. With S the waterplane, V the displaced volume, B its centre, and
lengths from G:

    K_33 = ρ g A_wp      K_34 = K_43 = ρ g ∫y dS      K_35 = K_53 = −ρ g ∫x dS
    K_44 = ρ g [∫y² dS + V z_B]      K_55 = ρ g [∫x² dS + V z_B]      K_45 = K_54 = −ρ g ∫x y dS
    K_46 = −ρ g V x_B      K_56 = −ρ g V y_B      K_64 = K_65 = K_66 = 0

in the motions surge, sway, heave, roll, pitch, yaw about G and world axes. Pitch turns +Z towards
+X about +Y, so the bow at +X goes down: that is the sign of K_35. The moment of the buoyancy about
G, ρ g V (y_B, −x_B, 0), turns with the hull in yaw: that is K_46 and K_56, which vanish with the
weight's where B is below G. In the plane surge, heave and pitch are left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import places_in_space, point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels


@dataclass(frozen=True)
class Hydrostatics:
    """Displacement and waterplane of a hull in its reference pose.

    `volume` [m3], centre of buoyancy (x_B, y_B, z_B) [m], `waterplane` ∫(1, x, x²) dS [m2, m3, m4]
    and `across` ∫(y, x y, y²) dS [m3, m4, m4].
    """

    volume: float
    center_of_buoyancy: tuple[float, float, float]
    waterplane: tuple[float, float, float]
    across: tuple[float, float, float]

    def stiffness(self, center: Sequence[float], density: float, gravity: float) -> np.ndarray:
        """Hydrostatic stiffness (m, m) [N/m, N/rad, N.m/m, N.m/rad]: force = −K·displacement.

        About `center` [m], in water of `density` [kg/m3] under `gravity` [m/s2]; m = 3 motions of
        the plane about (x_G, z_G), or 6 of space about (x_G, y_G, z_G).
        """
        x_g, y_g, z_g = point_in_space(center)
        x_b, y_b, z_b = self.center_of_buoyancy
        area, first, second = self.waterplane
        aside, product, square = self.across
        result = np.zeros((6, 6))
        result[2, 2] = area
        result[2, 3] = result[3, 2] = aside - y_g * area
        result[2, 4] = result[4, 2] = -(first - x_g * area)
        result[3, 3] = square - 2 * y_g * aside + y_g**2 * area
        result[3, 4] = result[4, 3] = -(product - x_g * aside - y_g * first + x_g * y_g * area)
        result[4, 4] = second - 2 * x_g * first + x_g**2 * area
        result[3, 3] += self.volume * (z_b - z_g)
        result[4, 4] += self.volume * (z_b - z_g)
        result[3, 5] = -self.volume * (x_b - x_g)
        result[4, 5] = -self.volume * (y_b - y_g)
        kept = places_in_space(len(center))
        return density * gravity * result[np.ix_(kept, kept)]

    def metacentric_height(self, center: Sequence[float]) -> float:
        """GM [m] about `center`: pitch stiffness of a free body over its weight.

        The waterplane's moment counts about its own middle, since heave follows freely.
        """
        area, first, second = self.waterplane
        inertia = second - first**2 / area if area > 0 else 0.0
        return inertia / self.volume + self.center_of_buoyancy[-1] - center[-1]

    def transverse_metacentric_height(self, center: Sequence[float]) -> float:
        """The same in roll [m]."""
        area = self.waterplane[0]
        aside, _, square = self.across
        inertia = square - aside**2 / area if area > 0 else 0.0
        return inertia / self.volume + self.center_of_buoyancy[-1] - center[-1]

    def buoyancy(self, center: Sequence[float], density: float, gravity: float) -> np.ndarray:
        """Force and moment about `center` of the water in the reference pose, (m,) [N, N.m].

        m = 3 motions of the plane, or 6 of space.
        """
        x_g, y_g, _ = point_in_space(center)
        x_b, y_b, _ = self.center_of_buoyancy
        force = density * gravity * self.volume
        result = np.array([0.0, 0.0, force, (y_b - y_g) * force, -(x_b - x_g) * force, 0.0])
        return result[places_in_space(len(center))]


def hydrostatics_of(panels: Panels) -> Hydrostatics:
    """Hydrostatics of a surface that is closed but for its waterline at z = 0."""
    return hydrostatics_of_triangles(panels.triangles)


def hydrostatics_of_triangles(triangles: np.ndarray) -> Hydrostatics:
    """The same for the `triangles` (n, 3, 3) [m] of a surface.

    The volume is the sum of the tetrahedra that the triangles make with the origin; those of the
    missing waterplane are empty because the origin lies in it.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = 0.5 * np.cross(b - a, c - a)  # vector areas, into the water
    tetrahedra = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = float(tetrahedra.sum())
    moments = np.einsum("i,ij->j", tetrahedra, a + b + c) / 4.0
    below = -area[:, 2]  # what each triangle covers of the waterplane
    x, y = triangles[:, :, 0], triangles[:, :, 1]

    def mean_product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
        return ((p * q).sum(axis=1) + p.sum(axis=1) * q.sum(axis=1)) / 12.0

    def covered(mean: np.ndarray | float) -> float:
        return float((below * mean).sum())

    center = moments / volume if volume else moments
    return Hydrostatics(
        volume,
        point_in_space(center),
        waterplane=(covered(1.0), covered(x.mean(axis=1)), covered(mean_product(x, x))),
        across=(covered(y.mean(axis=1)), covered(mean_product(x, y)), covered(mean_product(y, y))),
    )
