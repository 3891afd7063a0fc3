"""Lines at rest between fairleads that are held somewhere: forces, and their exact derivatives.

With A the stiffness of the free nodes, B that of free nodes by fairleads, C of fairleads by free
nodes and D of the fairleads themselves, the stiffness of the mooring is D − C A⁻¹ B.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from m4e_adapters.moordyn.mooring import NetData
from m4e_adapters.moordyn.node_forces import add_line_forces
from m4e_adapters.moordyn.rest import net_at
from m4e_adapters.moordyn.statics import Net

PRECISION = 1e-10
"""Of the forces on nodes, over the largest tension."""
REACH = 2
"""Nodes next to a node whose forces depend on its place, by bending."""
STEP = 1e-4
"""Differences of the forces of bending and of the surface, over the length of a segment."""
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
    """The equilibria of lines that `described` tells (`rest.net_at`), each from the one before."""

    def __init__(self, described: NetData) -> None:
        self._described = described
        self._last: Net | None = None

    def net_with(self, places: np.ndarray) -> Net | None:
        """The lines in equilibrium with fairleads at `places` (f, 3) [m]; None: not found."""
        net = net_at(self._described, places.tolist())
        net.precision = PRECISION
        if self._last is not None:
            held = {k for k, load in enumerate(net.loads) if load is None}
            net.position = [
                new if k in held else list(old)
                for k, (new, old) in enumerate(zip(net.position, self._last.position, strict=True))
            ]
            if not net.settle(known=True):
                self._last = None
                return self.net_with(places)
        elif not net.settle():
            return None
        self._last = net
        return net

    def at(self, places: np.ndarray) -> Resting | None:
        """The equilibrium with fairleads at `places` (f, 3) [m]; None if none was found."""
        if (net := self.net_with(places)) is None:
            return None
        points = self._described["fairleads"]
        slopes = [_force_slopes(net, k) for k in range(len(net.lines))]
        moves = _moves(net, sum(slopes), points)
        ends = np.array(net.end_forces()).reshape(-1, 2, 3)
        outer = [_rows([nodes[0], nodes[-1]]) for nodes in net.nodes]
        end_slopes = [
            (s[rows] @ moves).reshape(2, 3, -1) for s, rows in zip(slopes, outer, strict=True)
        ]
        held = np.array(
            [[[end == p for end in line["ends"]] for line in net.lines] for p in points]
        )
        return Resting(
            net,
            np.einsum("fle,lec->fc", held, ends),
            np.einsum("fle,leck->fck", held, np.array(end_slopes)),
            ends,
            np.array(end_slopes),
            [np.array([net.position[k] for k in nodes]) for nodes in net.nodes],
            [moves[_rows(nodes)].reshape(len(nodes), 3, -1) for nodes in net.nodes],
        )


def tensions(line: dict[str, Any], nodes: np.ndarray) -> np.ndarray:
    """Tension (x, y, z) [N] of each segment of a line with `nodes` (n, 3) [m]: (n - 1, 3)."""
    parts = np.diff(nodes, axis=0)
    lengths = np.linalg.norm(parts, axis=1, keepdims=True)
    stretch = np.maximum(lengths * line["segments"] / line["length"] - 1.0, 0.0)
    return line["stiffness"] * stretch * parts / np.maximum(lengths, 1e-9)


def _rows(nodes: Sequence[int]) -> list[int]:
    """The coordinates of these nodes among those of all."""
    return [3 * node + axis for node in nodes for axis in range(3)]


def _moves(net: Net, slopes: csc_array, points: Sequence[int]) -> np.ndarray:
    """Derivatives (3 n, 3 f) of the places of all n nodes by those of the fairleads `points`."""
    loads = [*net.loads, *([()] * (len(net.position) - len(net.loads)))]
    free = _rows([k for k, load in enumerate(loads) if load is not None])
    moves = np.zeros((slopes.shape[0], 3 * len(points)))
    moves[_rows(points)] = np.eye(3 * len(points))
    if free and points:
        inner = slopes[free][:, free]
        shift = SHIFT * np.abs(inner.diagonal()).max() * eye_array(len(free))
        moves[free] = splu(csc_array(shift - inner)).solve(slopes[free] @ moves)
    return moves


def _force_slopes(net: Net, number: int) -> csc_array:
    """Derivatives [N/m] of the forces of a line on all nodes by the places of all nodes.

    Those of tension and seabed are exact; those of bending, and of the share that is in the water,
    differences.
    """
    line, nodes, size = net.lines[number], net.nodes[number], 3 * len(net.position)
    entries: list[tuple[float, int, int]] = []

    def add(a: int, b: int, block: Sequence[Sequence[float]]) -> None:
        entries.extend((-block[i][j], 3 * a + i, 3 * b + j) for i in range(3) for j in range(3))

    bare = {**line, "buoyancy": 0.0, "bending": 0.0}
    add_line_forces(net, bare, nodes, {k: [0.0, 0.0, 0.0] for k in nodes}, add=add)
    step = STEP * line["length"] / line["segments"]
    if line["bending"] or max(net.position[k][2] for k in nodes) > -line["diameter"] - step:
        bare = {**line, "stiffness": 0.0}
        for first, axis in product(range(min(2 * REACH + 1, len(nodes))), range(3)):
            moved = range(first, len(nodes), 2 * REACH + 1)
            ahead, behind = (
                _forces(net, bare, nodes, {nodes[k]: (axis, s) for k in moved})
                for s in (step, -step)
            )
            change = (ahead - behind) / (2.0 * step)
            for k in moved:
                near = range(max(0, k - REACH), min(len(nodes), k + REACH + 1))
                entries.extend(
                    (change[j, i], 3 * nodes[j] + i, 3 * nodes[k] + axis)
                    for j in near
                    for i in range(3)
                )
    values, rows, columns = zip(*entries, strict=True)
    return csc_array((values, (rows, columns)), shape=(size, size))


def _forces(
    net: Net, line: dict[str, Any], nodes: list[int], moved: dict[int, tuple[int, float]]
) -> np.ndarray:
    """Forces (n, 3) [N] on the nodes of a line above no seabed, some `moved` along an axis."""
    at = {k: list(net.position[k]) for k in nodes}
    for k, (axis, by) in moved.items():
        at[k][axis] += by
    force = {k: [0.0, 0.0, 0.0] for k in nodes}
    add_line_forces(SimpleNamespace(position=at, bed=-inf, bed_stiffness=0.0), line, nodes, force)
    return np.array([force[k] for k in nodes])
