"""Outputs in the middle of a step where they cannot be read there: from those at other points.

See `input_interpolation` for the points at which they are known, and for the order that is kept.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.exchange.operations import Combine, Operation, gather


def weights(shares: Sequence[float]) -> np.ndarray:
    """Weights (n,) [1] of values at `shares` of a step in their polynomial, taken at its middle."""
    return np.array([math.prod((0.5 - q) / (p - q) for q in shares if q != p) for p in shares])


class MiddleFromPoints:
    """From values at `points`, the ends of so many of a step's `pieces`.

    Those that lie within the step are read into `rows`; `operations` follow the reading at its end.
    """

    def __init__(
        self, network: Network, outputs: slice, points: Sequence[int], pieces: int
    ) -> None:
        values, places = network.values, np.arange(outputs.start, outputs.stop)
        read = np.zeros((len(points), len(places)))
        self.rows = {point: row for point, row in zip(points, read, strict=True) if point < pieces}
        blocks = {0: network.now, pieces: network.stepped}
        known = [
            gather(row, values, blocks[point] + places)
            for point, row in zip(points, read, strict=True)
            if point in blocks
        ]
        weight = weights([point / pieces for point in points])
        into = values[network.middle :][outputs]
        index = np.arange(read.size, dtype=np.uint32).reshape(read.shape)
        share = np.repeat(weight[:, None], len(places), axis=1)
        self.operations: tuple[Operation, ...] = (*known, Combine(into, read.ravel(), index, share))

    def prepare(self, size: float, last: float) -> None:
        """Nothing depends on the sizes."""


class MiddleFromEnds:
    """From values at both ends of the step, and their declared derivatives there.

    Without these, from those at the start of the step before; if there was none, or on a `straight`
    line, the middle has their mean.
    """

    def __init__(self, network: Network, outputs: slice, *, straight: bool) -> None:
        self.rows: dict[int, np.ndarray] = {}
        self._straight = straight
        places = np.arange(outputs.start, outputs.stop)
        chains = [network.derivatives(port) for port in network.outputs[outputs]]
        self._has_rate = np.array([len(chain) > 1 for chain in chains])
        rates = np.array([network.index(chain[min(1, len(chain) - 1)]) for chain in chains])
        now, end, before = network.now, network.stepped, network.before
        index = np.array([now + places, end + places, before + places, now + rates, end + rates])
        into = network.values[network.middle :][outputs]
        shape = np.zeros(index.shape)
        self._combined = Combine(into, network.values, index.astype(np.uint32), shape)
        self.operations: tuple[Operation, ...] = (self._combined,)

    def prepare(self, size: float, last: float) -> None:
        """Weights for a step of `size` [s] after one of `last` [s] (0: there was none)."""
        mean = [0.5, 0.5, 0.0]
        past = mean if self._straight or not last else weights((0.0, 1.0, -last / size)).tolist()
        rate = [0.0, 0.0] if self._straight else [size / 8, -size / 8]
        self._combined.weight[:] = np.array([*past, 0.0, 0.0])[:, None]
        self._combined.weight[:, self._has_rate] = np.array([*mean, *rate])[:, None]
