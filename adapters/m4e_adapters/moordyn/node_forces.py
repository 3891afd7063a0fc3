"""Forces on the nodes of lines at rest, as MoorDyn 2.7.2 has them, and their derivatives.

Travels inside the FMU: imports numpy only. Source: `Line::getStateDeriv` and
`Line::calcSubSeg` of MoorDyn 2.7.2: tension of segments that are longer than unstretched (others
carry nothing), weight, buoyancy by the submerged share of a segment, the seabed's spring, bending.
Laws are of a segment or of a pair of them, and are differentiated by complex steps (W. Squire and
G. Trapp, SIAM Review 40, 1998, 110-112), which are exact.
"""

from functools import partial
from math import inf

import numpy as np

TINY = 1e-24  # [m2] beside squares of distances, which may be zero
STEP = 1e-30  # [m] along the imaginary axis
VALUES = ("length", "stiffness", "bending", "weight", "buoyancy", "diameter")


class Lines:
    """Lines, each with nodes from end A to B of its own, one line's n nodes after the other's.

    Parameters
    ----------
    lines
        For each line what `statics.Net` takes.
    bed, bed_stiffness
        z [m] of the flat seabed and its stiffness [Pa/m].
    """

    def __init__(self, lines, nodes, bed, bed_stiffness):
        count = np.array([line["segments"] for line in lines])
        last = np.cumsum(count + 1) - 1
        first = np.delete(np.arange(last[-1] + 1), last)
        self.segments = nodes[first[:, None] + np.arange(2)]
        length, stiffness, bending, weight, buoyancy, self.diameter = (
            np.repeat([line[key] for line in lines], count).astype(float) for key in VALUES
        )
        self.unstretched = length / np.repeat(count, count)
        self.half_weight, self.half_buoyancy = (
            load * self.unstretched / 2 for load in (weight, buoyancy)
        )
        self.heavy = np.maximum(abs(weight - buoyancy), 1e-3 * weight)
        self.length, self.stiffness = length, stiffness
        self.stiffest = (stiffness / self.unstretched + bending / self.unstretched**3).max()
        self.drags = [
            np.repeat([line.get(key, 0.0) for line in lines], count + 1)
            for key in ("drag", "axial_drag")
        ]
        self.bed, self.bed_stiffness = bed, bed_stiffness * self.diameter
        bent = (bending > 0.0) & ~np.isin(first, last - count)
        self.pairs, self.bending = nodes[first[bent][:, None] + np.arange(-1, 2)], bending[bent]

    def forces(self, places, soft=inf):
        """Forces (n, 3) [N] on nodes at `places` (n, 3) [m], and the largest of a segment.

        EA is at most `soft` times a line's weight in water, and the seabed's stiffness `soft` times
        weight per length.
        """
        force, largest = np.zeros(places.shape), []
        for nodes, law in self._laws(soft):
            found = law(places[nodes])
            np.add.at(force, nodes, found)
            largest.append(abs(found).max(initial=0.0))
        return force, largest[0]

    def slopes(self, places, soft=inf):
        """Derivatives [N/m] of `forces`: values, and the coordinates of forces and of places."""
        entries = []
        for nodes, law in self._laws(soft):
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
        wet = submerged(places[self.segments], self.diameter / 2) * self.unstretched / 2
        size, way = np.zeros(len(places)), np.zeros(places.shape)
        for k in (0, 1):
            np.add.at(size, self.segments[:, k], wet)
            np.add.at(way, self.segments[:, k], np.diff(places[self.segments], axis=1)[:, 0])
        q = way / _size(way)[:, None]
        along = (speeds * q).sum(axis=1)[:, None] * q
        across = speeds - along
        first, second = (c * _size(v) for c, v in zip(self.drags, (across, along), strict=True))
        return size[:, None] * (first[:, None] * across + second[:, None] * along)

    def _laws(self, soft):
        """Nodes (elements, k) of elements, and their law: places (..., k, 3) to forces."""
        spring = np.minimum(self.stiffness, soft * self.heavy * self.length) / self.unstretched
        bed = np.minimum(self.bed_stiffness, soft * self.heavy / self.length) * self.unstretched / 2
        yield self.segments, partial(self._stretched, spring=spring, bed=bed[:, None])
        if len(self.pairs):
            yield self.pairs, self._bent

    def _stretched(self, at, *, spring, bed):
        way = at[..., 1, :] - at[..., 0, :]
        length = _size(way)
        stretch = np.where(length.real > self.unstretched, length - self.unstretched, 0.0)
        pull = (spring * stretch / length)[..., None] * way
        force = np.stack([pull, -pull], axis=-2)
        lift = self.half_buoyancy * submerged(at, self.diameter / 2) - self.half_weight
        depth = self.bed - at[..., 2]
        force[..., 2] += lift[..., None] + bed * np.where(depth.real > 0.0, depth, 0.0)
        return force

    def _bent(self, at):
        """Forces of the moment at the middle one of three nodes."""
        way = np.diff(at, axis=-2)
        length = _size(way)[..., None]
        way = way / length
        cosine = (way[..., 0, :] * way[..., 1, :]).sum(axis=-1)[..., None]
        moment = self.bending[:, None] * 4 / length.sum(axis=-2) / np.sqrt(2 + 2 * cosine + TINY)
        first = moment / length[..., 0, :] * (cosine * way[..., 0, :] - way[..., 1, :])
        last = moment / length[..., 1, :] * (way[..., 0, :] - cosine * way[..., 1, :])
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
