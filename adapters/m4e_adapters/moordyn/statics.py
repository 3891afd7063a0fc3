"""Static equilibrium of lumped lines between held and free points.

Travels inside the FMU: imports the standard library and `node_forces` only. World frame, Z up, SI.

Without bending the forces of `node_forces` have a convex potential, so the equilibrium is unique
but for slack pieces. Newton's method finds it: with a shift of the diagonal, which slack pieces
need, and a search along each step for where little of the potential's slope is left. EA and seabed
are brought in by stages, because a stiff line that starts too short or too long goes there in tiny
steps. Lines of many segments start from the equilibrium of the same lines with fewer, in between
their nodes. The matrix of a line is banded; free points, to which several lines may go, come last
(skyline, L D Lᵀ).
"""

from itertools import chain
from math import ceil, dist, hypot, inf
from operator import mul
from sys import float_info

from .node_forces import add_line_forces, drag_forces

STAGES = (1e2, 1e4, 1e6, inf)  # most that EA is of a line's weight, the seabed of weight per length
ROUGHLY, PRECISION = 1e-3, 1e-6  # largest force left on a node, of a stage and at the end, over the
# largest tension or the weight of the heaviest line, for lines of up to COARSE segments
COARSE = 20  # segments; with more of them, less may be left on a node, as 1/segments
REFINEMENT, DIRECT = 4, 2 * COARSE  # more segments than DIRECT start from a 4th of them
ROUNDING = 16 * float_info.epsilon  # of a node's place, over its coordinates
ITERATIONS = 150  # of each stage
SHIFTS = (1e-9, 1e-3, 1.0)  # least, first and most, over the largest entry of the diagonal
DRIFTS = 100  # rounds of drag and equilibrium
LEFT = 1e-6  # change of drag, over its sum, that is none
LONGEST_MOVE = 0.25  # of a node in one iteration, over the length of the longest line
SLOPE, BISECTIONS = 0.5, 12  # share of the slope along a step that may be left, and how it is found


class Net:
    """Lines and points whose equilibrium is sought.

    Parameters
    ----------
    points
        For each point a dict of ``position`` (x, y, z) [m] and ``force`` (x, y, z) [N]: weight,
        buoyancy and constant load of a free point, None if the point is held.
    lines
        For each line a dict of ``ends`` (numbers of its points, from 0), ``segments``,
        ``length`` [m] unstretched, ``stiffness`` EA [N], ``bending`` EI [N·m²], ``weight`` in air
        and ``buoyancy`` [N/m], ``diameter`` [m]; for `settle_in` ``drag`` and ``axial_drag``.
    bed, bed_stiffness
        z [m] of the flat seabed and its stiffness [Pa/m].

    Attributes
    ----------
    position
        (x, y, z) [m] of every node: first the points, then the inner nodes of each line, which
        begin on the straight between its ends.
    nodes
        For each line the numbers of its nodes in `position`, from end A to end B.
    drag
        For each line the constant forces (x, y, z) [N] on its nodes; empty in still water.
    precision
        Largest force that may be left on a node, see `PRECISION`.
    """

    def __init__(self, points, lines, bed, bed_stiffness):
        self.position = [[float(x) for x in point["position"]] for point in points]
        self.loads = [point["force"] for point in points]
        self.lines, self.bed, self.bed_stiffness = lines, bed, bed_stiffness
        self.precision = PRECISION
        self.nodes, self.drag = [], []
        for line in lines:
            a, b = line["ends"]
            first, count = len(self.position), line["segments"]
            for k in range(1, count):
                ends = zip(self.position[a], self.position[b], strict=True)
                self.position.append([x + k / count * (y - x) for x, y in ends])
            self.nodes.append([a, *range(first, len(self.position)), b])

    def settle(self, known=False):
        """Move free nodes to the equilibrium; whether it was found to `precision`.

        `known` says that they are near one.
        """
        coarse = None if known else self._coarse()
        if coarse is not None:
            known = coarse.settle()
            self._follow(coarse)
        parts = [_Part(self, numbers) for numbers in self._connected()]
        return all(part.settle_from(known) for part in parts if part.order)

    def settle_in(self, current):
        """As `settle`, in water with the velocities (x, y, z) [m/s] `current` gives for places [m].

        Drag of the lines where they are, and the equilibrium with it, by turns.
        """
        found = self.settle()
        for _ in range(DRIFTS):
            before = self.drag or [[(0.0, 0.0, 0.0)] * len(nodes) for nodes in self.nodes]
            self.drag = []
            for line, nodes in zip(self.lines, self.nodes, strict=True):
                places = [self.position[k] for k in nodes]
                self.drag.append(drag_forces(line, places, current(places)))
            pairs = zip(chain(*before), chain(*self.drag), strict=True)
            change = sum(dist(old, new) for old, new in pairs)
            if not found or change <= LEFT * sum(hypot(*force) for force in chain(*self.drag)):
                return found
            parts = [_Part(self, numbers) for numbers in self._connected()]
            found = all(part.settle_from(True) for part in parts if part.order)
        return False

    def _coarse(self):
        """The same points and lines with fewer segments; None if these are few enough."""
        if max(line["segments"] for line in self.lines) <= DIRECT:
            return None
        points = zip(self.position, self.loads, strict=False)  # inner nodes stand behind
        return Net(
            [{"position": place, "force": load} for place, load in points],
            [{**line, "segments": ceil(line["segments"] / REFINEMENT)} for line in self.lines],
            self.bed,
            self.bed_stiffness,
        )

    def _follow(self, coarse):
        """Go where `coarse` is, with the nodes between its own on the straight."""
        self.position[: len(self.loads)] = coarse.position[: len(self.loads)]
        for nodes, others in zip(self.nodes, coarse.nodes, strict=True):
            for k, node in enumerate(nodes[1:-1], 1):
                j, part = divmod(k * (len(others) - 1), len(nodes) - 1)
                part /= len(nodes) - 1
                ends = zip(coarse.position[others[j]], coarse.position[others[j + 1]], strict=True)
                self.position[node] = [x + part * (y - x) for x, y in ends]

    def end_forces(self):
        """(force of end A, of end B), each (x, y, z) [N], of every line on what holds it."""
        found = []
        for number, (line, nodes) in enumerate(zip(self.lines, self.nodes, strict=True)):
            force = {k: [0.0, 0.0, 0.0] for k in nodes}
            self.add_drag(number, force)
            add_line_forces(self, line, nodes, force)
            found.append((force[nodes[0]], force[nodes[-1]]))
        return found

    def add_drag(self, number, force):
        """Add the drag on a line, by its number, to `force` [N] of nodes."""
        drags = self.drag[number] if self.drag else ()
        for node, drag in zip(self.nodes[number], drags, strict=False):
            force[node] = [a + b for a, b in zip(force[node], drag, strict=True)]

    def _connected(self):
        """The numbers of lines that hang together by free points."""
        label, first_at = list(range(len(self.lines))), {}
        for k, line in enumerate(self.lines):
            for end in line["ends"]:
                if self.loads[end] is not None:
                    old, new = label[k], label[first_at.setdefault(end, k)]
                    label = [new if one == old else one for one in label]
        return [[k for k, one in enumerate(label) if one == name] for name in sorted(set(label))]


class _Part:
    """Lines that hang together; unknown are three coordinates of each free node, in `order`."""

    def __init__(self, net, numbers):
        self.net, self.numbers = net, numbers
        self.lines = [(net.lines[k], net.nodes[k]) for k in numbers]
        ends = {end for line, _ in self.lines for end in line["ends"]}
        self.free_points = sorted(end for end in ends if net.loads[end] is not None)
        self.order = [k for _, nodes in self.lines for k in nodes[1:-1]] + self.free_points
        self.place = {k: 3 * n for n, k in enumerate(self.order)}
        self.longest = max(line["length"] for line, _ in self.lines)
        self.weight = max(line["length"] * line["weight"] for line, _ in self.lines)
        self.first = self._first_columns()
        self.share = min(1.0, COARSE / max(line["segments"] for line, _ in self.lines))
        self.soft = inf

    def settle_from(self, known):
        """Settle by the last stage alone if nodes are near a `known` equilibrium, else by all."""
        start = [self.net.position[k] for k in self.order]
        if known and self.settle(STAGES[-1:]):
            return True
        for k, place in zip(self.order, start, strict=True):
            self.net.position[k] = place
        return self.settle(STAGES)

    def settle(self, stages):
        found = False
        for self.soft in stages:
            found = self._stage(self.net.precision if self.soft == inf else ROUGHLY)
        return found

    def _rounded(self):
        """The force [N] that rounding of the places of nodes leaves on them."""
        far = max(abs(x) for k in self.order for x in self.net.position[k])
        stiffest = max(
            line["stiffness"] * line["segments"] / line["length"]
            + line["bending"] * (line["segments"] / line["length"]) ** 3
            for line, _ in self.lines
        )
        return ROUNDING * far * stiffest

    def _first_columns(self):
        """Of each row of the matrix the first column that is not zero."""
        first = dict(self.place)
        for line, nodes in self.lines:
            reach = 2 if line["bending"] else 1
            for a, k in enumerate(nodes):
                near = [self.place[j] for j in nodes[max(0, a - reach) : a + 1] if j in self.place]
                near += [self.place[j] for j in nodes[a : a + reach + 1] if j in self.place]
                if k in first:
                    first[k] = min([first[k], *near])
        return [first[k] for k in self.order for _ in range(3)]

    def _stage(self, precision):
        shift, before = SHIFTS[1], inf
        for _ in range(ITERATIONS):
            rows = [[0.0] * (i - first + 1) for i, first in enumerate(self.first)]
            force, scale = self._evaluate(rows)
            left = max(map(abs, force))
            if left <= max(self.share * precision * scale, self._rounded()):
                return True
            if before / 2 < left <= precision * scale:  # as near as rounding lets it come
                return True
            top = max(row[-1] for row in rows) or 1.0
            for row in rows:
                row[-1] += shift * top
            step = solved(rows, self.first, force)
            if step is None:
                shift, before = 10 * shift, inf
                continue
            longest = max(map(abs, step))
            if longest > LONGEST_MOVE * self.longest:
                step = [s * LONGEST_MOVE * self.longest / longest for s in step]
            whole = self._go_along(step, force)
            before = left if whole and shift == SHIFTS[0] else inf
            shift = max(SHIFTS[0], shift / 10) if whole else min(SHIFTS[2], 3 * shift)
        return False

    def _go_along(self, step, force):
        """Go along `step` until little slope is left; whether that was more than half of it."""
        start = [self.net.position[k] for k in self.order]
        slope0 = sum(map(mul, force, step))
        low, high, part = 0.0, 1.0, 1.0
        for _ in range(BISECTIONS):
            for n, k in enumerate(self.order):
                way = zip(start[n], step[3 * n : 3 * n + 3], strict=True)
                self.net.position[k] = [x + part * s for x, s in way]
            slope = sum(map(mul, self._evaluate()[0], step))
            if slope < -SLOPE * slope0:
                high = part
            elif slope > SLOPE * slope0 and high < 1.0:
                low = part
            else:
                break
            part = (low + high) / 2
        return part > 0.5

    def _evaluate(self, rows=None):
        """Forces on the unknowns [N], their scale [N]; the stiffness [N/m] is added to `rows`."""
        force = {k: [0.0, 0.0, 0.0] for _, nodes in self.lines for k in nodes}
        for k in self.free_points:
            force[k] = list(self.net.loads[k])
        for number in self.numbers:
            self.net.add_drag(number, force)
        add = None if rows is None else _block_adder(rows, self.first, self.place)
        tension = [
            add_line_forces(self.net, line, nodes, force, add=add, soft=self.soft)
            for line, nodes in self.lines
        ]
        return [x for k in self.order for x in force[k]], max(*tension, self.weight)


def _block_adder(rows, first, place):
    """A function that adds a 3×3 block of two nodes, if both are free, to the lower triangle."""

    def add(a, b, block):
        i, j = place.get(a), place.get(b)
        if i is None or j is None or j > i:
            return
        for r in range(3):
            row, start = rows[i + r], first[i + r]
            for c in range(3 if j < i else r + 1):
                row[j + c - start] += block[r][c]

    return add


def solved(rows, first, right):
    """The solution of A x = `right`, or None unless A is positive.

    `rows` (overwritten) holds the lower triangle of A, row i from its column `first[i]` on.
    """
    diagonal, x = [], list(right)
    for i, row in enumerate(rows):
        start = first[i]
        for j in range(start, i):
            low = max(start, first[j])
            known = rows[j][low - first[j] : j - first[j]]
            row[j - start] -= sum(map(mul, row[low - start : j - start], known))
        pivot = row[-1]
        for j in range(start, i):
            share = row[j - start] / diagonal[j]
            pivot -= share * row[j - start]
            row[j - start] = share
        if not pivot > 0.0:
            return None
        diagonal.append(pivot)
        x[i] -= sum(map(mul, row[:-1], x[start:i]))
    x = [value / pivot for value, pivot in zip(x, diagonal, strict=True)]
    for i in reversed(range(len(rows))):
        for j, share in enumerate(rows[i][:-1], first[i]):
            x[j] -= share * x[i]
    return x
