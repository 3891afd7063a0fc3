"""Forces on the nodes of a line at rest, as MoorDyn 2.7.2 has them, and their stiffness.

Travels inside the FMU: imports the standard library only. Source: `Line::getStateDeriv` and
`Line::calcSubSeg` of MoorDyn 2.7.2: tension of segments that are longer than unstretched (others
carry nothing), weight, buoyancy by the submerged share of a segment, the seabed's spring, bending.
"""

from itertools import pairwise
from math import dist, hypot, inf, sqrt
from operator import mul

STRAIGHT = 1e-12  # sine of an angle between segments that has no plane


def add_line_forces(net, line, nodes, force, *, add=None, soft=inf):
    """Add the forces [N] of `line` on its `nodes` to `force`; the largest tension [N].

    `net` has the `position` of nodes and the seabed, `line` is one of `statics.Net`. `add(a, b,
    block)` takes the stiffness [N/m] between nodes a and b (minus the derivative of the force on a
    by the position of b; symmetric, not negative). EA is at most `soft` times the line's weight in
    water, and the seabed's stiffness `soft` times weight per length.
    """
    count, unstretched = line["segments"], line["length"] / line["segments"]
    heavy = max(abs(line["weight"] - line["buoyancy"]), 1e-3 * line["weight"])
    spring = min(line["stiffness"], soft * heavy * line["length"]) / unstretched
    bed = min(net.bed_stiffness * line["diameter"], soft * heavy / line["length"]) * unstretched / 2
    weight, buoyancy = line["weight"] * unstretched / 2, line["buoyancy"] * unstretched / 2
    at, largest = [net.position[k] for k in nodes], 0.0
    for k in range(count):
        ends, places = (nodes[k], nodes[k + 1]), (at[k], at[k + 1])
        length = dist(*places)
        if length > unstretched:
            largest = max(largest, spring * (length - unstretched))
            _add_tension(spring, unstretched, length, ends, places, force, add)
        share, fall = submerged(*places, line["diameter"] / 2, length)
        for node, place in zip(ends, places, strict=True):
            force[node][2] += buoyancy * share - weight
            stiffness = buoyancy * fall
            if place[2] < net.bed:
                force[node][2] += bed * (net.bed - place[2])
                stiffness += bed
            if add and stiffness:
                add(node, node, [[0.0] * 3, [0.0] * 3, [0.0, 0.0, stiffness]])
    if line["bending"]:
        for k in range(1, count):
            _add_bending(line["bending"], nodes[k - 1 : k + 2], at[k - 1 : k + 2], force, add)
    return largest


def drag_forces(line, places, speeds):
    """Drag [N] (x, y, z) on each node of a `line` at rest in water that moves.

    Nodes are at `places` [m], the water there has `speeds` [m/s]; `line` has the ``drag`` across
    and the ``axial_drag`` along it [N s2/m3], per length and square of the speed.
    """
    count, unstretched = line["segments"], line["length"] / line["segments"]
    wet = [
        submerged(a, b, line["diameter"] / 2, dist(a, b))[0] * unstretched / 2
        for a, b in pairwise(places)
    ]
    found = []
    for k, speed in enumerate(speeds):
        low, high = places[max(0, k - 1)], places[min(count, k + 1)]
        length = dist(low, high) or 1.0
        q = [(y - x) / length for x, y in zip(low, high, strict=True)]
        along = sum(map(mul, speed, q))
        across = [x - along * y for x, y in zip(speed, q, strict=True)]
        size = sum(wet[max(0, k - 1) : k + 1])
        first, second = line["drag"] * hypot(*across), line["axial_drag"] * abs(along) * along
        found.append([size * (first * x + second * y) for x, y in zip(across, q, strict=True)])
    return found


def _add_tension(spring, unstretched, length, ends, places, force, add):
    (a, b), (start, end) = ends, places
    q = [(y - x) / length for x, y in zip(start, end, strict=True)]
    tension = spring * (length - unstretched)
    for c in range(3):
        force[a][c] += tension * q[c]
        force[b][c] -= tension * q[c]
    if add:
        across = tension / length
        along = [(spring - across) * x for x in q]
        block = [[x * y for y in q] for x in along]
        for c in range(3):
            block[c][c] += across
        minus = [[-x for x in row] for row in block]
        add(a, a, block)
        add(b, b, block)
        add(a, b, minus)
        add(b, a, minus)


def submerged(a, b, radius, length):
    """The submerged share of a segment from a to b, and about how fast it falls with z [1/m].

    MoorDyn's formula, unsymmetric as it is: a segment whose end B is at the surface counts as
    partly submerged, one whose end A is there does not.
    """
    if a[2] <= 0.0 and b[2] < 0.0:
        return 1.0, 0.0
    if a[2] > 0.0 and b[2] > 0.0:
        return 0.0, 0.0
    low, high = (a[2], b[2]) if a[2] < 0.0 else (b[2], a[2])
    level = radius * hypot(b[0] - a[0], b[1] - a[1]) / length if length else 0.0
    below, above = abs(low - level), high + level
    if a[2] == -b[2] or below + above == 0.0:
        return 0.5, 0.0
    return below / (below + above), 1 / (below + above)


def _add_bending(stiffness, nodes, places, force, add):
    """The moment at the middle one of three nodes; the stiffness is that of its angle alone."""
    d0, d1 = dist(*places[:2]), dist(*places[1:])
    if not (d0 and d1):
        return
    q0 = [(y - x) / d0 for x, y in zip(*places[:2], strict=True)]
    q1 = [(y - x) / d1 for x, y in zip(*places[1:], strict=True)]
    cosine = max(-1.0, min(1.0, sum(map(mul, q0, q1))))
    sine = sqrt(1 - cosine * cosine)
    if sine > STRAIGHT:
        moment = stiffness * 4 / (d0 + d1) * sqrt((1 - cosine) / 2) / sine
        for c, (x, y) in enumerate(zip(q0, q1, strict=True)):
            first, last = moment / d0 * (cosine * x - y), moment / d1 * (x - cosine * y)
            force[nodes[0]][c] += first
            force[nodes[1]][c] -= first + last
            force[nodes[2]][c] += last
    if add:
        before, after = _turn(q0, d0), _turn(q1, d1)
        both = [
            [-x - y for x, y in zip(*rows, strict=True)] for rows in zip(before, after, strict=True)
        ]
        share, turns = 2 * stiffness / (d0 + d1), (before, both, after)
        for a, left in zip(nodes, turns, strict=True):
            for b, right in zip(nodes, turns, strict=True):
                add(a, b, [[share * sum(map(mul, x, y)) for y in right] for x in left])


def _turn(q, length):
    """(I − q qᵀ)/length: the change of a unit vector with the motion of its end."""
    return [[((i == j) - q[i] * q[j]) / length for j in range(3)] for i in range(3)]
