"""Forces on the nodes of lines at rest, as MoorDyn 2.7.2 has them, and their derivatives.

Travels inside the FMU: imports numpy only. Source: `Line::getStateDeriv` and
`Line::calcSubSeg` of MoorDyn 2.7.2: tension of segments that are longer than unstretched (others
carry nothing), weight, buoyancy by the submerged share of a segment, the seabed's spring, bending.
Laws are of a segment or of a pair of them, and are differentiated by complex steps (W. Squire and
G. Trapp, SIAM Review 40, 1998, 110-112), which are exact.
"""

from math import inf

import numpy as np

TINY = 1e-24  # [m2] beside squares of distances, which may be zero
STEP = 1e-30  # [m] along the imaginary axis


class Lines:
    """Lines with nodes of the numbers `nodes`, from end A to B, one line's after the other's.

    Parameters
    ----------
    described
        As of `statics.Net`, of which it takes lines and seabed.
    nodes
        (m,) of the places that methods take, and of the forces that they give.
    soft
        EA is at most so many times a line's weight in water, the seabed's stiffness so many times
        its weight per length.

    Attributes
    ----------
    ends
        (lines, 2): where among `nodes` the ends of lines are.
    scales
        (n, 3) of each node the largest EA over length of a segment there [N/m], weight of its line
        [N], and stiffness of the segment with bending [N/m].
    """

    def __init__(self, described, nodes, soft=inf):
        lines = described["lines"]
        count = np.array([line["segments"] for line in lines])
        last = np.cumsum(count + 1) - 1
        first, self.ends = np.delete(np.arange(len(nodes)), last), np.stack([last - count, last], 1)
        length, stiffness, bending, weight, buoyancy, self.diameter = (
            np.repeat([line[key] for line in lines], count).astype(float)
            for key in ("length", "stiffness", "bending", "weight", "buoyancy", "diameter")
        )
        self.size, self.level = length / np.repeat(count, count), described["bed"]
        heavy = np.maximum(abs(weight - buoyancy), 1e-3 * weight)
        bed = np.minimum(described["bed_stiffness"] * self.diameter, soft * heavy / length)
        self.half_weight, self.half_buoyancy, self.half_bed = (
            per_length * self.size / 2 for per_length in (weight, buoyancy, bed)
        )
        self.spring = np.minimum(stiffness, soft * heavy * length) / self.size
        bent = (bending > 0.0) & ~np.isin(first, self.ends)
        self.bending = bending[bent]
        self.segments, pairs = (
            nodes[k[:, None] + around]
            for k, around in ((first, np.arange(2)), (first[bent], np.arange(-1, 2)))
        )
        self._laws = [(self.segments, self._stretched), (pairs, self._bent)][: 1 + bent.any()]
        self.scales = np.zeros((nodes.max() + 1, 3))
        scales = [self.spring, weight * length, self.spring + bending / self.size**3]
        np.maximum.at(self.scales, self.segments, np.transpose(scales)[:, None])
        self.drags = [
            np.repeat([line.get(key, 0.0) for line in lines], count + 1)
            for key in ("drag", "axial_drag")
        ]

    def forces(self, places):
        """Forces (n, 3) [N] on nodes at `places` (n, 3) [m]."""
        force = np.zeros(places.shape)
        for nodes, law in self._laws:
            np.add.at(force, nodes, law(places[nodes]))
        return force

    def slopes(self, places):
        """Derivatives [N/m] of `forces`: values, and the coordinates of forces and of places."""
        entries = []
        for nodes, law in self._laws:
            size = 3 * nodes.shape[1]
            steps = 1j * STEP * np.eye(size).reshape(size, 1, -1, 3)
            values = law(places[nodes] + steps).imag.reshape(size, -1, size) / STEP
            where = (3 * nodes[..., None] + np.arange(3)).reshape(-1, size)
            entries.append(np.broadcast_arrays(values, where, where.T[..., None]))
        return [np.concatenate([x.ravel() for x in parts]) for parts in zip(*entries, strict=True)]

    def drag(self, places, speeds):
        """Drag (n, 3) [N] on nodes at rest at `places` in water with `speeds`, (n, 3) [m, m/s].

        Of lines with ``drag`` across and ``axial_drag`` along them [N s2/m3], per length and
        square of the speed.
        """
        wet = submerged(places[self.segments], self.diameter / 2) * self.size / 2
        size, way = np.zeros(len(places)), np.zeros(places.shape)
        np.add.at(size, self.segments, wet[:, None])
        np.add.at(way, self.segments, np.diff(places[self.segments], axis=1))
        q = way / _size(way)[:, None]
        along = (speeds * q).sum(axis=1)[:, None] * q
        across = speeds - along
        first, second = (c * _size(v) for c, v in zip(self.drags, (across, along), strict=True))
        return size[:, None] * (first[:, None] * across + second[:, None] * along)

    def _stretched(self, at):
        """Forces of the tension, weight, buoyancy and seabed of segments."""
        way = at[..., 1, :] - at[..., 0, :]
        length = _size(way)
        stretch = np.where(length.real > self.size, length - self.size, 0.0)
        pull = (self.spring * stretch / length)[..., None] * way
        force = np.stack([pull, -pull], axis=-2)
        lift = self.half_buoyancy * submerged(at, self.diameter / 2) - self.half_weight
        depth = self.level - at[..., 2]
        rest = self.half_bed[:, None] * np.where(depth.real > 0.0, depth, 0.0)
        force[..., 2] += lift[..., None] + rest
        return force

    def _bent(self, at):
        """Forces of the moment at the middle one of three nodes."""
        way = np.diff(at, axis=-2)
        length = _size(way)[..., None]
        way = way / length
        cosine = np.prod(way, axis=-2).sum(axis=-1)[..., None, None]
        moment = self.bending[:, None, None] * 4 / length.sum(axis=-2, keepdims=True)
        pull = moment / np.sqrt(2 + 2 * cosine + TINY) / length * (cosine * way - way[..., ::-1, :])
        first, last = pull[..., 0, :], -pull[..., 1, :]
        return np.stack([first, -first - last, last], axis=-2)


def submerged(at, radius):
    """The submerged share of segments of a `radius` [m] with their ends `at` (..., 2, 3) [m].

    MoorDyn's formula, unsymmetric as it is: a segment whose end B is at the surface counts as
    partly submerged, one whose end A is there does not.
    """
    way, a, b = at[..., 1, :] - at[..., 0, :], at[..., 0, 2], at[..., 1, 2]
    low, high = np.where(a.real < 0.0, (a, b), (b, a))
    level = radius * _size(way[..., :2]) / _size(way)
    below = np.sqrt((low - level) ** 2)
    wet, dry = (a.real <= 0.0) & (b.real < 0.0), (a.real > 0.0) & (b.real > 0.0)
    whole = wet | dry
    return np.where(whole, wet, below / np.where(whole, 1.0, below + high + level))


def _size(vectors):
    return np.sqrt((vectors**2).sum(axis=-1) + TINY)
