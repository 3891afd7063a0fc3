"""Static equilibrium of lumped lines between held and free points.

Travels inside the FMU: imports numpy, scipy and `node_forces` only. World frame, Z up, SI.

Without bending the forces of `node_forces` have a convex potential, so the equilibrium is unique
but for slack pieces. Newton's method finds it: with a shift of the diagonal, which slack pieces
need, and a search along each step for where little of the potential's slope is left. EA and seabed
are brought in by stages, because a stiff line that starts too short or too long goes there in tiny
steps.
"""

from math import ceil, inf

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from .node_forces import Lines

STAGES = (1e2, 1e4, 1e6, inf)  # most that EA is of a line's weight, the seabed of weight per length
ROUGHLY, PRECISION = 1e-3, 1e-6  # largest force left on a node, of a stage and at the end, over the
# largest tension or the weight of the heaviest line, for lines of up to COARSE segments
COARSE = 20  # segments; with more of them, less may be left on a node, as 1/segments
ROUNDING = 16 * np.finfo(float).eps  # of a node's place, over its coordinates
ITERATIONS = 150  # of each stage
REFINEMENT, DIRECT = 4, 2 * COARSE  # more segments than DIRECT start from a 4th of them
SHIFTS = (1e-9, 1e-3, 1.0)  # least, first and most, over the largest entry of the diagonal
DRIFTS = 100  # rounds of drag and equilibrium
LEFT = 1e-6  # change of drag, over its sum, that is none
LONGEST_MOVE = 0.25  # of a node in one iteration, over the length of the longest line
SLOPE, BISECTIONS = 0.5, 12  # share of the slope along a step that may be left, and how it is found


class Net:
    """Lines and points whose equilibrium is sought, with fairleads at `places` (f, 3) [m].

    Parameters
    ----------
    described
        ``points``: for each a dict of ``position`` (x, y, z) [m] and ``force`` (x, y, z) [N]:
        weight, buoyancy and constant load of a free point, None if the point is held.
        ``fairleads``: the numbers of their points, from 0, in MoorDyn's order.
        ``lines``: for each a dict of ``ends`` (numbers of its points), ``segments``, ``length`` [m]
        unstretched, ``stiffness`` EA [N], ``bending`` EI [N·m²], ``weight`` in air and
        ``buoyancy`` [N/m], ``diameter`` [m]; for `settle_in` ``drag`` and ``axial_drag``, across
        and along the line [N s2/m3], per length and square of the speed.
        ``bed``, ``bed_stiffness``: z [m] of the flat seabed and its stiffness [Pa/m].
    lengths
        Other lengths [m] of lines, by their numbers.

    Attributes
    ----------
    position
        (n, 3) [m] of every node: first the points, then the inner nodes of each line, which begin
        on the straight between its ends.
    held, load
        (n,) of nodes that are held, and constant forces (n, 3) [N].
    nodes
        For each line the numbers of its nodes in `position`, from end A to end B.
    drag
        (n, 3) [N] on the nodes of each line, one line's after the other's; 0 in still water.
    precision
        Largest force that may be left on a node, see `PRECISION`.
    """

    def __init__(self, described, places=(), lengths=()):
        self.lines = [dict(line) for line in described["lines"]]
        for k, length in dict(lengths).items():
            self.lines[k]["length"] = length
        self._described, points = described, described["points"]
        at = np.array([point["position"] for point in points], dtype=float)
        at[described["fairleads"]] = np.reshape(places, (-1, 3))
        first, rows, self.nodes = len(at), [at], []
        for line in self.lines:
            (a, b), count = line["ends"], line["segments"]
            rows.append(np.linspace(at[a], at[b], count + 1)[1:-1])
            self.nodes.append(np.array([a, *range(first, first + count - 1), b]))
            first += count - 1
        self.position, self.each = np.concatenate(rows), np.concatenate(self.nodes)
        self.free, self.load = np.ones(first, bool), np.zeros((first, 3))
        self.free[: len(at)] = [point["force"] is not None for point in points]
        self.load[: len(at)] = [point["force"] or (0.0, 0.0, 0.0) for point in points]
        self.bed, self.bed_stiffness = described["bed"], described["bed_stiffness"]
        self.whole = Lines(self.lines, np.arange(len(self.each)), self.bed, self.bed_stiffness)
        last = np.cumsum([len(nodes) for nodes in self.nodes]) - 1
        self.ends = np.column_stack([last - [line["segments"] for line in self.lines], last])
        self.drag, self.precision = np.zeros((len(self.each), 3)), PRECISION

    def settle(self, known=False):
        """Move free nodes to the equilibrium; whether it was found to `precision`.

        `known` says that they are near one.
        """
        if not known and max(line["segments"] for line in self.lines) > DIRECT:
            known = self._settle_roughly()
        free = np.array([self.free & np.isin(range(len(self.free)), k) for k in self.nodes])
        label = connected_components(free @ free.T)[1]
        lines = (np.flatnonzero(label == k) for k in range(max(label) + 1))
        return all(_Part(self, k).settle(known) for k in lines)

    def settle_in(self, current):
        """As `settle`, in water with the velocities (n, 3) [m/s] `current` gives for places [m].

        Drag of the lines where they are, and the equilibrium with it, by turns.
        """
        found, load = self.settle(), self.load
        for _ in range(DRIFTS):
            before, places = self.drag, self.position[self.each]
            self.drag = self.whole.drag(places, current(places))
            change, size = (np.linalg.norm(x, axis=1).sum() for x in (self.drag - before, before))
            if not found or change <= LEFT * size:
                return found
            self.load = load.copy()
            np.add.at(self.load, self.each, self.drag)
            found = self.settle(known=True)
        return False

    def end_forces(self):
        """Forces (lines, 2, 3) [N] of ends A and B of every line on what holds them."""
        force, _ = self.whole.forces(self.position[self.each])
        return (force + self.drag)[self.ends]

    def _settle_roughly(self):
        """Go where the lines are with fewer segments; whether their equilibrium was found."""
        pairs = zip(self._described["points"], self.position, strict=False)
        points = [{**point, "position": place} for point, place in pairs]
        lines = [{**line, "segments": ceil(line["segments"] / REFINEMENT)} for line in self.lines]
        coarse = Net({**self._described, "points": points, "fairleads": [], "lines": lines})
        found = coarse.settle()
        for nodes, few in zip(self.nodes, coarse.nodes, strict=True):
            at, known = (np.linspace(0.0, 1.0, len(some)) for some in (nodes, few))
            places = [np.interp(at, known, x) for x in coarse.position[few].T]
            self.position[nodes] = np.transpose(places)
        return found


class _Part:
    """Lines that hang together, by their numbers; unknown are the places of their free nodes."""

    def __init__(self, net, numbers):
        lines = [net.lines[k] for k in numbers]
        nodes = np.concatenate([net.nodes[k] for k in numbers])
        self.net, self.free = net, net.free & np.isin(range(len(net.free)), nodes)
        self.lines = Lines(lines, nodes, net.bed, net.bed_stiffness)
        self.longest = max(line["length"] for line in lines)
        self.weight = max(line["length"] * line["weight"] for line in lines)
        self.share = min(1.0, COARSE / max(line["segments"] for line in lines))

    def settle(self, known):
        """Settle by the last stage alone if nodes are near a `known` equilibrium, else by all."""
        start = self.net.position[self.free]
        if not self.free.any() or (known and self._stage(inf)):
            return True
        self.net.position[self.free] = start
        return [self._stage(soft) for soft in STAGES][-1]

    def _stage(self, soft):
        shift, precision = SHIFTS[1], self.net.precision if soft == inf else ROUGHLY
        for _ in range(ITERATIONS):
            force, scale = self._forces(soft)
            rounded = ROUNDING * abs(self.net.position[self.free]).max() * self.lines.stiffest
            if abs(force).max() <= max(self.share * precision * scale, rounded):
                return True
            stiffness = factored(self.lines.slopes(self.net.position, soft), self.free, shift)
            step = stiffness.solve(force.ravel()).reshape(-1, 3)
            step *= min(1.0, LONGEST_MOVE * self.longest / abs(step).max())
            whole = self._go_along(step, force, soft)
            shift = max(SHIFTS[0], shift / 10) if whole else min(SHIFTS[2], 3 * shift)
        return False

    def _go_along(self, step, force, soft):
        """Go along `step` until it is not steeply uphill; whether all of it."""
        start, slope = self.net.position[self.free], np.vdot(force, step)
        if not slope > 0.0:
            return False
        for k in range(BISECTIONS):
            self.net.position[self.free] = start + 0.5**k * step
            if np.vdot(self._forces(soft)[0], step) > -SLOPE * slope:
                break
        return k == 0

    def _forces(self, soft):
        """Forces (free nodes, 3) [N], and their scale [N]."""
        force, largest = self.lines.forces(self.net.position, soft)
        return (force + self.net.load)[self.free], max(largest, self.weight)


def factored(slopes, free, shift):
    """Factors of the stiffness [N/m] of the nodes `free`, a mask, by `Lines.slopes`.

    `shift` of its largest entry is on the diagonal: slack pieces have no stiffness.
    """
    values, *where = slopes
    number = np.where(np.repeat(free, 3), np.cumsum(np.repeat(free, 3)) - 1, -1)
    rows, columns = number[np.array(where)]
    inner = (rows >= 0) & (columns >= 0)
    size = number.max() + 1
    matrix = csc_array((-values[inner], (rows[inner], columns[inner])), shape=(size, size))
    top = abs(matrix.diagonal()).max() or 1.0
    return splu(csc_array(matrix + shift * top * eye_array(size)))
