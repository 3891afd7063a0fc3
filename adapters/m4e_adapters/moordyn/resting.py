"""Lines at rest between fairleads that are held somewhere: forces, and their exact derivatives.

With A the stiffness of the free nodes, B that of free nodes by fairleads, C of fairleads by free
nodes and D of the fairleads themselves, the stiffness of the mooring is D − C A⁻¹ B.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from m4e_adapters.moordyn.mooring import NetData
from m4e_adapters.moordyn.statics import Net, factored

SHIFT = 1e-12
"""Of the diagonal, over its largest entry: slack pieces have no stiffness."""


@dataclass(frozen=True)
class Resting:
    """Lines in equilibrium, and derivatives by the k places (x, y, z) [m] of f fairleads, k = 3 f.

    `force` (f, 3) [N] of the lines on what moves the fairleads, `force_slopes` (f, 3, k) [N/m].
    `ends` (lines, 2, 3) [N] and `end_slopes` (lines, 2, 3, k): forces of end A and B of each line
    on what holds them. `nodes` (n, 3) [m] and `node_slopes` (n, 3, k) of each line, from A to B.
    """

    net: Net
    force: np.ndarray
    force_slopes: np.ndarray
    ends: np.ndarray
    end_slopes: np.ndarray
    nodes: list[np.ndarray]
    node_slopes: list[np.ndarray]


class LinesAtRest:
    """The equilibria of lines that `described` tells (`statics.Net`), each from the one before."""

    def __init__(self, described: NetData) -> None:
        self._described = described
        self._last: Net | None = None

    def net_with(self, places: np.ndarray) -> Net | None:
        """The lines in equilibrium with fairleads at `places` (f, 3) [m]; None: not found."""
        for last in dict.fromkeys((self._last, None)):
            net = self._last = Net(self._described, places)
            if last is not None:
                net.position[net.free] = last.position[net.free]
            if net.settle(known=last is not None):
                return net
        self._last = None
        return None

    def at(self, places: np.ndarray) -> Resting | None:
        """The equilibrium with fairleads at `places` (f, 3) [m]; None if none was found."""
        if (net := self.net_with(places)) is None:
            return None
        points, size = self._described["fairleads"], places.size
        values, rows, columns = net.whole.slopes(net.position[net.each])
        to = np.arange(net.position.size).reshape(-1, 3)[net.each].ravel()
        shape = len(to), net.position.size
        slopes = csr_array((values, (rows, to[columns])), shape=shape)  # on nodes of each line
        moves = np.zeros((*net.position.shape, size))
        moves[points] = np.eye(size).reshape(-1, 3, size)

        def changes() -> np.ndarray:
            return (slopes @ moves.reshape(-1, size)).reshape(-1, 3, size)

        if net.free.any():
            shift = np.full(3 * net.free.sum(), SHIFT * abs(values).max())
            factors = factored((values, to[rows], to[columns]), net.free, shift)
            force = net.summed(changes())[net.free]
            moves[net.free] = factors.solve(force.reshape(-1, size)).reshape(-1, 3, size)
        ends, end_slopes = net.end_forces(), changes()[net.whole.ends]
        held = np.array(
            [[[end == p for end in line["ends"]] for line in net.lines] for p in points]
        )
        return Resting(
            net,
            np.einsum("fle,lec->fc", held, ends),
            np.einsum("fle,leck->fck", held, end_slopes),
            ends,
            end_slopes,
            [net.position[nodes] for nodes in net.nodes],
            [moves[nodes] for nodes in net.nodes],
        )


def tensions(line: dict[str, Any], nodes: np.ndarray) -> np.ndarray:
    """Tension (x, y, z) [N] of each segment of a line with `nodes` (n, 3) [m]: (n - 1, 3)."""
    parts = np.diff(nodes, axis=0)
    lengths = np.linalg.norm(parts, axis=1, keepdims=True)
    stretch = np.maximum(lengths * line["segments"] / line["length"] - 1.0, 0.0)
    return line["stiffness"] * stretch * parts / np.maximum(lengths, 1e-9)
