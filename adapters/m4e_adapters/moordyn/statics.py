"""Static equilibrium of lumped lines between held and free points.

Travels inside the FMU: imports numpy, scipy and `node_forces` only. World frame, Z up, SI.

Without bending the forces of `node_forces` have a convex potential, so the equilibrium is unique
but for slack pieces. Newton's method finds it: with a shift of the diagonal, which slack pieces
need, and a search along each step for where it is not steeply uphill. EA and seabed are brought in
by stages, because a stiff line that starts too short or too long goes there in tiny steps. Lines of
many segments start from the equilibrium of the same lines with fewer, in between their nodes.
"""

from math import ceil, inf

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from .node_forces import Lines

STAGES = (1e2, 1e4, 1e6, inf)  # most that EA is of a line's weight, the seabed of weight per length
ROUGHLY, PRECISION = 1e-3, 1e-10  # largest force left on a node, of a stage and at the end, over
# the weight of a line there
ROUNDING = 16 * np.finfo(float).eps  # of a node's place, over the largest coordinate
ITERATIONS = 150  # of each stage
REFINEMENT, DIRECT = 4, 40  # more segments than DIRECT start from a 4th of them
SHIFTS = (1e-9, 1e-3, 1.0)  # least, first and most, over the stiffness of a segment at the node
DRIFTS = 100  # rounds of drag and equilibrium
LEFT = 1e-6  # change of drag, over all of it, that is none
LONGEST_MOVE = 0.25  # of a node in one iteration, over the length of the longest line
SLOPE, HALVES = 0.5, 12  # share of a step's slope by which it may end uphill, and its halves


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
    free, load
        (n,) True of nodes that are not held, and constant forces (n, 3) [N].
    nodes
        For each line the numbers of its nodes in `position`, from end A to end B.
    each, whole
        These numbers of one line after the other (m,), and the `Lines` at places in this order.
    drag
        (m, 3) [N] on them; 0 in still water.
    """

    def __init__(self, described, places=(), lengths=()):
        self.lines = [dict(line) for line in described["lines"]]
        for k, length in dict(lengths).items():
            self.lines[k]["length"] = length
        points, self.described = described["points"], {**described, "lines": self.lines}
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
        self.whole = Lines(self.described, np.arange(len(self.each)))
        self.bed, self.drag = described["bed"], np.zeros((len(self.each), 3))

    def settle(self, known=False):
        """Move free nodes to the equilibrium; whether it was found to `PRECISION`.

        `known` says that they are near one.
        """
        if not known and max(line["segments"] for line in self.lines) > DIRECT:
            known = self._settle_roughly()
        start = self.position.copy()
        if known and self._stage(inf):
            return True
        self.position = start
        return [self._stage(soft) for soft in STAGES][-1]

    def settle_in(self, current):
        """As `settle`, in water with the velocities (n, 3) [m/s] `current` gives for places [m].

        Drag of the lines where they are, and the equilibrium with it, by turns.
        """
        found, load = self.settle(), self.load
        for _ in range(DRIFTS):
            before, places = self.drag, self.position[self.each]
            self.drag = self.whole.drag(places, current(places))
            change, size = (
                np.linalg.norm(x, axis=1).sum() for x in (self.drag - before, self.drag)
            )
            if not found or change <= LEFT * size:
                return found
            self.load = load + self.summed(self.drag)
            found = self.settle(known=True)
        return False

    def end_forces(self):
        """Forces (lines, 2, 3) [N] of ends A and B of every line on what holds them."""
        return (self.whole.forces(self.position[self.each]) + self.drag)[self.whole.ends]

    def summed(self, values):
        """Sums (n, …) over nodes of `values` (m, …) of the nodes of each line."""
        total = np.zeros((len(self.position), *values.shape[1:]))
        np.add.at(total, self.each, values)
        return total

    def _settle_roughly(self):
        """Go where the lines are with fewer segments; whether their equilibrium was found."""
        lines = [{**line, "segments": ceil(line["segments"] / REFINEMENT)} for line in self.lines]
        fairleads = self.position[np.array(self.described["fairleads"], dtype=int)]
        coarse = Net({**self.described, "lines": lines}, fairleads)
        found = coarse.settle()
        for nodes, few in zip(self.nodes, coarse.nodes, strict=True):
            at, known = np.linspace(0, len(few) - 1, len(nodes)), range(len(few))
            places = [np.interp(at, known, x) for x in coarse.position[few].T]
            self.position[nodes] = np.transpose(places)
        return found

    def _stage(self, soft):
        """Settle with EA and seabed of a stage; whether an equilibrium was found."""
        lines, free = Lines(self.described, self.each, soft), self.free
        spring, weight, stiffest = lines.scales[free].T[..., None]
        precision, shift = PRECISION if soft == inf else ROUGHLY, SHIFTS[1]
        longest = LONGEST_MOVE * max(line["length"] for line in self.lines)

        def force_at(places):
            self.position[free] = places
            return (lines.forces(self.position) + self.load)[free]

        force = force_at(self.position[free])
        for _ in range(ITERATIONS):
            rounded = ROUNDING * abs(self.position).max() * stiffest
            if (abs(force) <= np.maximum(precision * weight, rounded)).all():
                return True
            start = self.position[free]
            try:
                stiffness = factored(
                    lines.slopes(self.position), free, np.repeat(shift * spring, 3)
                )
            except RuntimeError:  # it is singular
                return False
            step = stiffness.solve(force.ravel()).reshape(-1, 3)
            step *= min(1.0, longest / abs(step).max())
            slope = np.vdot(force, step)
            for k in range(HALVES):
                force = force_at(start + 0.5**k * step)
                if np.vdot(force, step) > -SLOPE * slope:
                    break
            shift = min(SHIFTS[2], 3 * shift) if k else max(SHIFTS[0], shift / 10)
        return False


def factored(slopes, free, shift):
    """Factors of the stiffness [N/m] of the nodes `free`, a mask (n,), by `Lines.slopes`.

    `shift` (3 free nodes,) [N/m] is added on the diagonal: slack pieces have no stiffness.
    """
    values, *where = slopes
    unknown = np.flatnonzero(np.repeat(free, 3))
    stiffness = csc_array((-values, where), shape=(3 * len(free),) * 2)[unknown][:, unknown]
    return splu(csc_array(stiffness + diags_array(shift)))
