"""Load of the water's pressure on a hull at its true pose, in still water and in waves.

    F = −∫ p n dA     M = −∫ r × p n dA     p = ρ g max(0, h)

over the hull's surface, r from the centre of gravity, n out of the body. The head h is −z in still
water, which exerts no horizontal force on a closed surface and no moment about Z; in waves it is
that of `IncidentWaves`. The hydrostatic part is that of still water at the same
pose, the Froude-Krylov part is the rest: all that the undisturbed waves add, the change of the
wetted surface included.

Integrals of a pressure over the part of a surface where it is positive.

The pressure is given as a head [m of water] at the vertices and linear on each triangle between
them; a triangle is cut along the line where it vanishes. These integrals are exact. In still water
the head is the depth, which *is* linear: then the whole is exact for the triangles, and the sums of
a closed surface are those of the body below the water. Elsewhere the error is of second order in
the size of the triangles.

The mean over a triangle of λ_a h, λ_a the barycentric coordinate of corner a, is (h_a + Σh)/12. A
corner i on its own side of the waterline cuts off a triangle of which the edges to j and k are the
shares q_j = |h_i|/(|h_i| + |h_j|) and q_k: its mean is |h_i| q_j q_k (4 − q_j − q_k, q_j, q_k)/12,
for the corners i, j, k. Wet triangles have the first, those with one wet corner the second, those
with one dry corner the sum of both.

Elevation and pressure of linear waves, stretched to the instantaneous surface.

η = Σ r(t) a cos θ, θ = ω t − k (x cos β + y sin β) + φ, with ramps r = ½(1 − cos π t/T) until T.
Wheeler's stretching takes the pressure at z from z' = (z − η) d/(d + η), d the depth: it is that of
the undisturbed surface on the instantaneous one, where with the hydrostatic part it vanishes.

Points are taken in blocks whose arrays stay in the processor's cache, and angles are in turns, from
which whole ones are taken off exactly: with sine's own polynomial, 1 − 2 sin² πf is then right to
2e-15, in a quarter of the time of `numpy.cos`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import TypedDict

import numpy as np

SINE = (
    3.141592653589793, -5.167712780049969, 2.5501640398773007, -0.5992645293189447,
    0.0821458865731029, -0.007370430505916944, 0.0004662998161898394, -2.1903497074626018e-05,
    7.697826768224191e-07,
)  # fmt: skip
"""sin(πf)/f at |f| ≤ 1/2 as a polynomial in f², through Chebyshev's points: off by 4e-16."""
BLOCK = 30_000  # values of an array


def cosine(turns: np.ndarray) -> np.ndarray:
    """cos 2πf (np, n) [1] of `turns` f (np, n) [1], which are overwritten."""
    turns -= np.rint(turns)
    square = turns * turns
    value = SINE[-1] * square
    for factor in SINE[-2:0:-1]:
        value += factor
        value *= square
    value += SINE[0]
    value *= turns
    value *= value
    value *= -2.0
    value += 1.0
    return value


class IncidentWaves:
    """Waves of n components: `omega` [rad/s], `wavenumber` [rad/m], `amplitude` [m], `phase` and
    `direction` [rad], `ramp_time` [s], (n,) each; the last may be 0. `depth` [m] may be inf.
    """

    def __init__(self, data: Mapping[str, Sequence[float] | float]) -> None:
        names = ("omega", "wavenumber", "amplitude", "phase", "direction")
        omega, k, self._amplitude, phase, direction = (np.array(data[n]) for n in names)
        self._k, turn = k, 2.0 * math.pi
        self._vectors = np.stack([k * np.cos(direction), k * np.sin(direction)]) / turn
        self._rates, self._phases = omega / turn, phase / turn
        self._depth = float(data["depth"])  # pyrefly: ignore[bad-argument-type]
        self._reflected = 1.0 / (1.0 + np.exp(-2.0 * k * self._depth))  # e^{kd}/(2 cosh kd)
        self._ramp_time = np.array(data["ramp_time"])

    def _amplitudes(self, time: float) -> np.ndarray:
        """r a (n,) [m] at `time` [s]."""
        length = self._ramp_time
        grown = np.where(time < length, time / np.where(length > 0.0, length, 1.0), 1.0)
        return self._amplitude * (0.5 - 0.5 * np.cos(math.pi * grown))

    def elevation(self, points: np.ndarray, time: float) -> np.ndarray:
        """η (np,) [m] at `points` (np, 2) [m] or more columns, the first of which are x, y."""
        return self._cosines(points, time) @ self._amplitudes(time)

    def head(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Pressure head and elevation (np,) [m] at `points` (np, 3) [m].

        Above the surface the head is the height below it, which is negative. Below the bed waves
        add what they add on it.
        """
        rows = max(1, BLOCK // len(self._k))
        parts = [self._head(points[k : k + rows], time) for k in range(0, len(points), rows)]
        heads, elevations = zip(*parts, strict=True)
        return np.concatenate(heads), np.concatenate(elevations)

    def _head(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """As `head`, of one block."""
        cosines, amplitude = self._cosines(points, time), self._amplitudes(time)
        elevation = cosines @ amplitude
        head = elevation - points[:, 2]
        wet = np.flatnonzero(head > 0.0)
        if not len(wet):
            return head, elevation
        level = -head[wet]
        if math.isfinite(self._depth):
            level = level * self._depth / (self._depth + elevation[wet])
            level = np.maximum(level, -self._depth)
        falling = self._decay(level)
        falling *= cosines[wet]
        head[wet] = falling @ (self._reflected * amplitude) - points[wet, 2]
        return head, elevation

    def _cosines(self, points: np.ndarray, time: float) -> np.ndarray:
        """cos θ (np, n) at `points` (np, 2) [m] or more columns."""
        turns = np.ascontiguousarray(points[:, :2]) @ self._vectors
        turns -= np.mod(self._rates * time + self._phases, 1.0)
        return cosine(turns)

    def _decay(self, level: np.ndarray) -> np.ndarray:
        """2 cosh k(z' + d)/e^{kd} (np, n), e^{kz'} in deep water.

        `level` (np,) [m] are the heights z', from −d to 0.
        """
        falling = np.exp(np.multiply.outer(level, self._k))
        if math.isinf(self._depth):
            return falling
        rising = np.exp(np.multiply.outer(-(level + 2.0 * self._depth), self._k))
        falling += rising
        return falling


class ClippedSurface:
    """A closed surface of `triangles` (nt, 3), corner indices of `vertices` (nv, 3) [m].

    Normals point out of the body. Moments are about the origin of the vertices.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        self.vertices, self._triangles = vertices, triangles
        corners = vertices[triangles]
        area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        moment = np.cross(corners, area[:, None])
        force = np.broadcast_to(area[:, None], moment.shape)
        self._weights = -np.concatenate([force, moment], axis=2) / 12.0  # (nt, 3, 6)
        spread = self._weights + self._weights.sum(axis=1, keepdims=True)
        self._wet = np.zeros((len(vertices), 6))
        np.add.at(self._wet, triangles, spread)

    def wrench(self, head: np.ndarray) -> np.ndarray:
        """Force and moment (6,) [m3, m4] of the positive part of `head` (nv,) [m].

        −∫ h n dA and −∫ r × h n dA, in the axes of the vertices: times ρ g they are N and N.m.
        """
        wet = head > 0.0
        total = np.where(wet, head, 0.0) @ self._wet
        of_corners = wet[self._triangles]
        count = of_corners.sum(axis=1)
        cut = np.flatnonzero((count == 1) | (count == 2))
        if len(cut):
            alone = np.where(count[cut] == 1, of_corners[cut].argmax(1), of_corners[cut].argmin(1))
            total = total + self._beyond(head, cut, alone)
        return total

    def _beyond(self, head: np.ndarray, cut: np.ndarray, alone: np.ndarray) -> np.ndarray:
        """Wrench (6,) [m3, m4] of triangles `cut` (nc,) beyond that of their wet corners' heads.

        `alone` (nc,) are their corners on their own side of the waterline.
        """
        rows = np.arange(len(cut))
        order = (alone[:, None] + np.arange(3)) % 3
        own, second, third = np.abs(head[self._triangles[cut[:, None], order]]).T
        to_second, to_third = own / (own + second), own / (own + third)
        tip = own * to_second * to_third
        shares = np.empty((len(cut), 3))
        shares[rows, order[:, 0]] = tip * (4.0 - to_second - to_third) - 2.0 * own
        shares[rows, order[:, 1]] = tip * to_second - own
        shares[rows, order[:, 2]] = tip * to_third - own
        return np.tensordot(shares, self._weights[cut], axes=2)


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


POSE = ("x", "y", "z", "phi", "theta", "psi")
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
OF_PLANE = ("force_x", "force_z", "moment_y")


class HullData(TypedDict):
    """A hull called `name`: the arguments of `HullLoad`, `neutral_mass` [kg], and the `y` [m] that
    it keeps in the plane.
    """

    name: str
    vertices: list[list[float]]
    triangles: list[list[int]]
    neutral_mass: float
    y: float


class PressureData(TypedDict):
    """All hulls, `weight` ρ g [N/m3], 2 or 3 `dimensions`, `depth` [m]; `waves`, None if still."""

    bodies: list[HullData]
    weight: float
    dimensions: int
    depth: float
    waves: dict[str, list[float] | float] | None


class HullOutputs:
    """The hulls of `data`: their loads follow time and pose at once."""

    def __init__(self, data: PressureData) -> None:
        self._bodies, self._depth = data["bodies"], data["depth"]
        self._waves = IncidentWaves(data["waves"]) if data["waves"] else None
        self._forces = OF_PLANE if data["dimensions"] == 2 else FORCES
        self._hulls = [
            HullLoad(body["vertices"], body["triangles"], weight=data["weight"], waves=self._waves)
            for body in self._bodies
        ]
        self._told: set[tuple[str, str]] = set()
        self._last: dict[str, Load] = {}

    def at(self, given: Mapping[str, float], time: float) -> dict[str, float]:
        """All outputs at `time` [s] for the `given` inputs, by name, SI.

        ValueError for a pose without a finite pressure.
        """
        found: dict[str, float] = {}
        for body, hull in zip(self._bodies, self._hulls, strict=True):
            name = body["name"]
            kept = {"y": body["y"], "phi": 0.0, "psi": 0.0}  # in the plane
            pose = [
                given[place] if (place := f"{name}.{key}") in given else kept[key] for key in POSE
            ]
            load = self._last[name] = hull.at(pose[:3], pose[3:], time)
            if not isfinite(sum(pose) + load.hydrostatic.sum() + load.froude_krylov.sum()):
                raise ValueError(f"{name} has no finite pressure at x, y, z = {pose[:3]} m")
            found[f"{name}.neutral_mass"] = body["neutral_mass"]
            found |= {f"{name}.{key}": value for key, value in self._of(load)}
        if self._waves:
            found["wave.elevation"] = float(self._waves.elevation(np.zeros((1, 2)), time)[0])
        return found

    def _of(self, load: Load) -> Iterator[tuple[str, float]]:
        """Outputs of one body."""
        parts = {"": load.hydrostatic + load.froude_krylov, "hydrostatic_": load.hydrostatic}
        if self._waves:
            parts["froude_krylov_"] = load.froude_krylov
            yield "water_level", load.water_level
        for part, wrench in parts.items():
            for force, value in zip(FORCES, wrench.tolist(), strict=True):
                if force in self._forces:
                    yield f"{part}{force}", value
        yield "wetted_volume", load.wetted_volume

    def doubts(self, time: float) -> Iterator[str]:
        """Hulls that have left the water or touch the bed where `at` was asked last; each once."""
        for name, load in self._last.items():
            if load.wetted_volume <= 0.0 and self._is_new(name, "dry"):
                yield f"{name} is wholly out of the water (t = {time:.4g} s): no force on it"
            if load.lowest < -self._depth and self._is_new(name, "aground"):
                yield (
                    f"{name} reaches down to z = {load.lowest:.4g} m (t = {time:.4g} s), below the "
                    f"sea bed at z = {-self._depth:.4g} m: the bed exerts no force on it"
                )

    def _is_new(self, name: str, doubt: str) -> bool:
        known = (name, doubt) in self._told
        self._told.add((name, doubt))
        return not known
