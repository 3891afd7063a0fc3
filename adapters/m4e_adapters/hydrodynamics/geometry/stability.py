"""Stability of a whole hull at any angle: pose at rest, righting arms at constant displacement.

The hull is cut by the still-water level exactly, panel by panel. With B the centre of buoyancy and
G that of gravity, in axes with Z upwards, R = R_x(φ) for a heel φ:

    GZ(φ) = y_G − y_B,

the moment about the hull's own x axis that turns it back, over the weight. It is the rate by which
the potential energy grows with φ. In pitch the hull is turned by a quarter about Z before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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


LEVEL = math.cos(math.radians(10.0))
"""Upward part of the normal of a panel that is a deck."""
FLAT = 0.2
"""Of all that faces upwards, part that is level where there is a deck."""
STEEPEST = math.radians(60.0)
"""Trim beyond which a hull is not followed."""
MOST_STEPS, LARGEST_STEP, AT_REST = 100, 0.2, 1e-10
"""Of the search for rest: number, angle [rad], lever over the size of the hull."""
UNSTABLE, NUDGE = 1e-6, 0.05
"""Metacentric height over size that counts as 0; angle [rad] out of a pose that is unstable."""
RESOLVED = 1e-4
"""Of angles [rad] at which deck or openings go under."""
HEEL, PITCH = "heel", "pitch"
"""Turns about the hull's x axis, and about its y axis."""


@dataclass(frozen=True)
class Afloat:
    """A hull in one pose: `hydrostatics` about its centre of gravity, Z up, in m.

    `deck` and `opening` [m] are the heights above the water of the lowest point of the deck, and of
    the lowest edge of an opening, nan without.
    """

    hydrostatics: Hydrostatics
    height: float
    deck: float
    opening: float


@dataclass(frozen=True)
class Curve:
    """Righting arms `arms` (n,) [m] at `angles` (n,) [rad] of heel or pitch.

    There is no turn about the other axis. `deck` [rad] is the angle at which the
    deck goes under, `flooded` [rad] that at which water enters an opening, where the curve ends;
    nan if neither happens.
    """

    angles: np.ndarray
    arms: np.ndarray
    deck: float
    flooded: float


class WholeHull:
    """A hull with its part above the water, and a centre of gravity `center` (x, y, z) [m].

    It displaces `volume` [m3].
    """

    def __init__(self, panels: Panels, center: tuple[float, float, float], volume: float) -> None:
        self.panels, self.center, self.volume = panels, center, volume
        triangles = panels.triangles - np.array(center)
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        sizes = np.linalg.norm(normals, axis=1)
        level = normals[:, 2] > LEVEL * np.maximum(sizes, 1e-300)
        dry = triangles[:, :, 2].min(axis=1) >= -center[2]
        edges = [e for e, sides in panels.edges().items() if len(sides) == 1]
        points = panels.vertices[np.unique(np.array(edges, dtype=int))]
        deck = level & dry & (sizes > 0.0)
        upward = normals[dry, 2]
        flat = normals[deck, 2].sum() > FLAT * upward[upward > 0.0].sum()  # a ball has no deck
        self._triangles = triangles[sizes > 0.0]
        self._deck = triangles[deck & flat].reshape(-1, 3)
        self._edges = points - np.array(center)
        whole = hydrostatics_of_triangles(self._triangles).volume
        if not edges and whole <= self.volume:
            raise InputError.single(
                f"the hull sinks: it has {whole:.5g} m3, {self.volume:.5g} m3 are to be displaced",
                "give more freeboard, or less mass",
            )

    @property
    def size(self) -> float:
        """Largest extent [m]."""
        return self.panels.size

    def afloat(self, rotation: np.ndarray) -> Afloat:
        """The hull turned about G by `rotation` (3, 3) [1], at the height of its displacement."""
        turned = self._triangles @ rotation.T

        def lifted(height: float) -> Hydrostatics:
            """Hydrostatics with G at that height [m] above the water."""
            moved = turned + np.array([0.0, 0.0, height])
            return hydrostatics_of_triangles(below(moved, moved[:, :, 2]))

        low, high = -float(turned[:, :, 2].max()), -float(turned[:, :, 2].min())
        height = float(
            brentq(lambda h: lifted(h).volume - self.volume, low, high, xtol=1e-13 * self.size)
        )

        def lowest(points: np.ndarray) -> float:
            """Height [m] above the water of the lowest of `points` (n, 3) [m]; nan of none."""
            return float((points @ rotation[2]).min()) + height if len(points) else math.nan

        return Afloat(lifted(height), height, lowest(self._deck), lowest(self._edges))

    def at_rest(self) -> tuple[Afloat, np.ndarray] | None:
        """The stable pose next to the reference pose, and its rotation (3, 3) [1].

        None if there is none within 60 deg.
        """
        rotation = np.eye(3)
        for _ in range(MOST_STEPS):
            found = self.afloat(rotation)
            x, y, _ = found.hydrostatics.center_of_buoyancy
            values, vectors = np.linalg.eigh(_turning(found))
            scale = self.volume * self.size
            if math.hypot(x, y) < AT_REST * self.size:
                if values[0] > -UNSTABLE * scale:
                    return found, rotation
                step = NUDGE * vectors[:, 0]
            else:
                # directions in which it is unstable are gone as well, with the moment
                slopes = np.maximum(np.abs(values), UNSTABLE * scale)
                step = vectors @ ((vectors.T @ (self.volume * np.array([y, -x]))) / slopes)
                step *= min(1.0, LARGEST_STEP / float(np.linalg.norm(step)))
            rotation = turn((step[0], step[1], 0.0)) @ rotation
            if rotation[2, 2] < math.cos(STEEPEST):
                return None
        return None

    def arms(self, angles: Sequence[float], *, about: str = HEEL) -> Curve:
        """Righting arms at `angles` [rad] of heel, or of pitch; up to where an opening floods."""
        before = turn((0.0, 0.0, -0.5 * math.pi)) if about == PITCH else np.eye(3)

        def pose(angle: float) -> Afloat:
            return self.afloat(turn((angle, 0.0, 0.0)) @ before)

        def first_below(of: Callable[[Afloat], float], last: float, angle: float) -> float:
            """The angle [rad] between `last` and `angle` at which a height becomes negative."""
            while abs(angle - last) > RESOLVED:
                middle = 0.5 * (last + angle)
                last, angle = (last, middle) if of(pose(middle)) < 0.0 else (middle, angle)
            return 0.5 * (last + angle)

        rows: list[tuple[float, float]] = []
        deck = flooded = math.nan
        last = 0.0
        for angle in angles:
            found = pose(angle)
            if found.opening < 0.0:
                flooded = first_below(lambda one: one.opening, last, angle)
                break
            if found.deck < 0.0 and math.isnan(deck):
                deck = first_below(lambda one: one.deck, last, angle)
            rows.append((angle, -found.hydrostatics.center_of_buoyancy[1]))
            last = angle
        table = np.array(rows).reshape(-1, 2).T
        return Curve(table[0], table[1], deck, flooded)


def turn(vector: Sequence[float]) -> np.ndarray:
    """The rotation (3, 3) [1] by a rotation vector [rad]."""
    angle = math.sqrt(sum(x * x for x in vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (v / angle for v in vector)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def heel_and_trim(rotation: np.ndarray) -> tuple[float, float]:
    """φ and θ [rad] of R_z(ψ) R_y(θ) R_x(φ) = `rotation` (3, 3) [1]."""
    return (
        math.atan2(rotation[2, 1], rotation[2, 2]),
        math.asin(min(1.0, max(-1.0, -float(rotation[2, 0])))),
    )


def _turning(found: Afloat) -> np.ndarray:
    """Stiffness (2, 2) [m4] in roll and pitch about G over ρg, heave following freely."""
    whole = found.hydrostatics.stiffness((0.0, 0.0, found.height), 1.0, 1.0)
    heave, turns = whole[2, 2], whole[3:5, 3:5]
    if heave > 0.0:
        turns = turns - np.outer(whole[3:5, 2], whole[2, 3:5]) / heave
    return 0.5 * (turns + turns.T)
