"""Load of the water's pressure on a hull at its true pose, in still water and in waves.

    F = −∫ p n dA     M = −∫ r × p n dA     p = ρ g max(0, h)

over the hull's surface, r from the centre of gravity, n out of the body. The head h is −z in still
water, which exerts no horizontal force on a closed surface and no moment about Z; in waves it is
that of `incident_waves`. The hydrostatic part is that of still water at the same
pose, the Froude-Krylov part is the rest: all that the undisturbed waves add, the change of the
wetted surface included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .clipped_surface import ClippedSurface
from .incident_waves import IncidentWaves

UPWARDS = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 0.0])  # what still water exerts; others are rounding


@dataclass(frozen=True)
class Load:
    """Wrenches (6,) [N, N.m] about the centre of gravity, world frame, of still water and of waves.

    `wetted_volume` [m3] is what is below the instantaneous surface, `water_level` [m] the height of
    that at the centre of gravity's (x, y), `lowest` [m] that of the hull's lowest point.
    """

    hydrostatic: np.ndarray
    froude_krylov: np.ndarray
    wetted_volume: float
    water_level: float
    lowest: float


class HullLoad:
    """The load on one hull: `vertices` (nv, 3) [m] from the centre of gravity in body axes.

    `triangles` (nt, 3) have outward normals; `weight` ρ g [N/m3]; `waves` None: still water.
    """

    def __init__(
        self,
        vertices: Sequence[Sequence[float]],
        triangles: Sequence[Sequence[int]],
        *,
        weight: float,
        waves: IncidentWaves | None,
    ) -> None:
        self._surface = ClippedSurface(np.array(vertices), np.array(triangles))
        self._weight, self._waves = weight, waves

    def at(self, place: Sequence[float], angles: Sequence[float], time: float) -> Load:
        """The load with the centre of gravity at `place` (3,) [m], turned by `angles` (3,) [rad].

        These are phi, theta, psi: R = R_z(psi) R_y(theta) R_x(phi) from body to world axes.
        """
        turn = rotation(*angles)
        points = self._surface.vertices @ turn.T + place
        depth = -points[:, 2]
        still = self._in_world(turn, depth) * UPWARDS
        lowest = float(points[:, 2].min())
        if self._waves is None:
            volume = still[2] / self._weight
            return Load(still, np.zeros(6), volume, 0.0, lowest)
        head, elevation = self._waves.head(points, time)
        volume = self._in_world(turn, depth + elevation)[2] / self._weight
        level = self._waves.elevation(np.array([place]), time)[0]
        waves = self._in_world(turn, head) - still
        return Load(still, waves, float(volume), float(level), lowest)

    def _in_world(self, turn: np.ndarray, head: np.ndarray) -> np.ndarray:
        """Wrench (6,) [N, N.m] in world axes of `head` (nv,) [m], with `turn` (3, 3) to them."""
        return self._weight * (self._surface.wrench(head).reshape(2, 3) @ turn.T).ravel()


def rotation(phi: float, theta: float, psi: float) -> np.ndarray:
    """R_z(psi) R_y(theta) R_x(phi) (3, 3) [1] from body to world axes; angles in rad."""
    (a, b, c), (d, e, f) = np.cos([phi, theta, psi]), np.sin([phi, theta, psi])
    return np.array(
        [
            [c * b, c * e * d - f * a, c * e * a + f * d],
            [f * b, f * e * d + c * a, f * e * a - c * d],
            [-e, b * d, b * a],
        ]
    )
