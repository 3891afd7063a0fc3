"""Stability of a whole hull at any angle: righting arms at constant displacement.

The hull is cut by the still-water level exactly, panel by panel. With B the centre of buoyancy and
G that of gravity, in axes with Z upwards, R = R_x(φ) for a heel φ:

    GZ(φ) = y_G − y_B,

the moment about the hull's own x axis that turns it back, over the weight. It is the rate by which
the potential energy grows with φ. In pitch the hull is turned by a quarter about Z before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from m4e_adapters.hydrodynamics.geometry.hydrostatics import (
    Hydrostatics,
    hydrostatics_of_triangles,
)
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_fmi.errors import InputError


def below(triangles: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """The parts of `triangles` (n, 3, 3) [m] that are below a plane, as triangles (k, 3, 3) [m].

    `heights` (n, 3) [m] are those of the corners above the plane. Corners keep their order, so that
    normals keep their side; a triangle that touches the plane with a corner or an edge only, or
    lies in it, is left out if no part of it is below.
    """
    under = heights < 0.0
    count = under.sum(axis=1)
    one, two = count == 1, count == 2
    # the corner that differs from the two others comes first
    first = np.where(one, np.argmax(under, axis=1), np.argmin(under, axis=1))
    order = (first[:, None] + np.arange(3)) % 3
    rows = np.arange(len(triangles))[:, None]
    a, b, c = np.moveaxis(triangles[rows, order], 1, 0)
    h = heights[rows, order]
    ab, ac = _crossing(a, b, h[:, 0], h[:, 1]), _crossing(a, c, h[:, 0], h[:, 2])

    def stacked(mask: np.ndarray, *corners: np.ndarray) -> np.ndarray:
        """The triangles of `corners`, each (n, 3) [m], where `mask` (n,), booleans, is true."""
        return np.stack([corner[mask] for corner in corners], axis=1)

    return np.concatenate(
        [
            triangles[count == 3],
            stacked(one, a, ab, ac),
            stacked(two, ab, b, c),
            stacked(two, ab, c, ac),
        ]
    )


def _crossing(p: np.ndarray, q: np.ndarray, h_p: np.ndarray, h_q: np.ndarray) -> np.ndarray:
    """Points (n, 3) [m] where the edges from `p` to `q` (n, 3) [m] pass the plane.

    `h_p` and `h_q` (n,) [m] are their heights above it. Edges that do not pass it give their start.
    """
    passes = (h_p < 0.0) != (h_q < 0.0)
    # from the lower end, whichever way the edge runs: neighbours meet in the same point
    low = np.where(h_p < h_q, h_p, h_q)
    high = np.where(h_p < h_q, h_q, h_p)
    lower = np.where((h_p < h_q)[:, None], p, q)
    upper = np.where((h_p < h_q)[:, None], q, p)
    part = np.where(passes, low / np.where(passes, low - high, 1.0), 0.0)
    return np.where(passes[:, None], lower + part[:, None] * (upper - lower), p)


HEEL, PITCH = "heel", "pitch"
"""Turns about the hull's x axis, and about its y axis."""


@dataclass(frozen=True)
class Afloat:
    """A hull in one pose: `hydrostatics` about its centre of gravity, Z up, in m.

    G is at the `height` [m] above the water; `opening` [m] is that of the lowest open edge, inf
    without.
    """

    hydrostatics: Hydrostatics
    height: float
    opening: float


@dataclass(frozen=True)
class Curve:
    """Righting arms `arms` (n,) [m] at `angles` (n,) [rad] of heel or pitch.

    There is no turn about the other axis. At the angle `flooded` [rad] water has entered an
    opening: the curve ends before; nan if that does not happen.
    """

    angles: np.ndarray
    arms: np.ndarray
    flooded: float = math.nan


class WholeHull:
    """A hull with its part above the water, and a centre of gravity `center` (x, y, z) [m].

    It displaces `volume` [m3].
    """

    def __init__(self, panels: Panels, center: tuple[float, float, float], volume: float) -> None:
        self.panels, self.center, self.volume = panels, center, volume
        triangles = panels.triangles - np.array(center)
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        sizes = np.linalg.norm(normals, axis=1)
        edges = [e for e, sides in panels.edges().items() if len(sides) == 1]
        points = panels.vertices[np.unique(np.array(edges, dtype=int))]
        self._triangles = triangles[sizes > 0.0]
        self._edges = points - np.array(center)
        whole = hydrostatics_of_triangles(self._triangles).volume
        if not edges and whole <= self.volume:
            raise InputError.single(
                f"the hull sinks: it has {whole:.5g} m3, {self.volume:.5g} m3 are to be displaced",
                "give more freeboard, or less mass",
            )

    def afloat(self, rotation: np.ndarray) -> Afloat:
        """The hull turned about G by `rotation` (3, 3) [1], at the height of its displacement."""
        turned = self._triangles @ rotation.T

        def lifted(height: float) -> Hydrostatics:
            """Hydrostatics with G at that height [m] above the water."""
            moved = turned + np.array([0.0, 0.0, height])
            return hydrostatics_of_triangles(below(moved, moved[:, :, 2]))

        low, high = -float(turned[:, :, 2].max()), -float(turned[:, :, 2].min())
        height = float(
            brentq(
                lambda h: lifted(h).volume - self.volume, low, high, xtol=1e-13 * self.panels.size
            )
        )

        open_at = (self._edges @ rotation[2]).min(initial=math.inf) + height
        return Afloat(lifted(height), height, float(open_at))

    def arms(self, angles: Sequence[float], *, about: str = HEEL) -> Curve:
        """Righting arms at `angles` [rad] of heel, or of pitch; up to where an opening floods."""
        before = turn((0.0, 0.0, -0.5 * math.pi)) if about == PITCH else np.eye(3)

        arms: list[float] = []
        for angle in angles:
            found = self.afloat(turn((angle, 0.0, 0.0)) @ before)
            if found.opening < 0.0:
                return Curve(np.array(angles[: len(arms)]), np.array(arms), angle)
            arms.append(-found.hydrostatics.center_of_buoyancy[1])
        return Curve(np.array(angles), np.array(arms))


def turn(vector: Sequence[float]) -> np.ndarray:
    """The rotation (3, 3) [1] by a rotation vector [rad]."""
    angle = math.sqrt(sum(x * x for x in vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (v / angle for v in vector)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
