"""Lines at rest: their equilibrium put into a MoorDyn system, and warnings where there is none.

Travels inside the FMU: imports numpy only. MoorDyn 2.7.2's own solver
stops when its error changes little, wherever that is, and leaves some lines at a fifth of the
tension that they settle to.
"""

from math import hypot, sqrt

import numpy as np

HEADER = 9  # bytes of a state file before its length: "MoorDyn" and two of its version
AWAY = 0.015  # share of a line's equilibrium tension by which it may start elsewhere without a word
LEFT = 0.01  # share of a line's tension that may be left on a node where no equilibrium is known,
# of lines of up to COARSE segments: those of more carry less weight
COARSE = 20
SUNK = 0.01  # [m] below the seabed, to which its stiffness may let an end sink
LYING = 1e-3  # [m] above the seabed, up to which a node lies on it
LONGER = 1e-3  # share by which a line may be longer than there is room for without a word
LATER = "start the run before the time that counts"
MORE_TIME = (  # of a file with rods or free bodies, where TmaxIC alone changes nothing
    "give MoorDyn a smaller threshIC (1e-6) and more time (TmaxIC 1000), or its other method "
    f"(1 ICgenDynamic, with threshIC 1e-4, dtIC 10 and TmaxIC 500); else {LATER}"
)


def with_nodes(state, net):
    """The bytes of a state file of MoorDyn, with the nodes where `net` has them, at rest."""
    words, starts = _objects(state)
    points = np.arange(len(net.position) - sum(len(nodes) - 2 for nodes in net.nodes))
    rows = [*points[:, None], *(nodes[1:-1] for nodes in net.nodes)]
    for start, nodes in zip(starts[-len(rows) :], rows, strict=True):
        if words[start : start + 2].tolist() != [len(nodes), 6] and len(nodes):
            raise ValueError("a state file of MoorDyn that is not laid out as expected")
        found = np.pad(net.position[nodes], ((0, 0), (0, 3))).ravel()
        words[start + 2 : start + 2 + len(found)] = found.view("u8")
    return state[:HEADER] + words.tobytes()


def with_points(state, points, lines):
    """The bytes of a state file with `points` behind the others: (x, y, z, vx, vy, vz) of each.

    `lines` is the number of lines, which come last.
    """
    words, starts = _objects(state)
    more = [np.append(np.array([1, 6], "u8"), np.array(values).view("u8")) for values in points]
    words[:2] += np.array([8 * len(points), len(points)], "u8")
    words = np.concatenate([words[: starts[-lines]], *more, words[starts[-lines] :]])
    return state[:HEADER] + words.tobytes()


def _objects(state):
    """The words of a state file, and where in them each object begins.

    The file has a number of 8 bytes each: its length, how many objects follow, and for each of
    them rows, columns and values: bodies, rods, points, and lines with a row of position and
    velocity for each inner node.
    """
    words = np.frombuffer(state[HEADER:], "u8").copy()
    starts, at = [], 2
    for _ in range(words[1]):
        starts.append(at)
        at += 2 + int(words[at] * words[at + 1])
    return words, starts


def away_from(net, names, tensions, remedy):
    """A text for each line whose end tensions are not those of the equilibrium `net`.

    `tensions` are (of end A, of end B) [N] of each line.
    """
    texts = []
    known = np.linalg.norm(net.end_forces(), axis=2)
    for name, now, rest in zip(names, np.array(tensions), known, strict=True):
        k = np.argmax(abs(now - rest))
        if abs(now - rest)[k] > AWAY * max(rest):
            texts.append(
                f"{name} does not start at rest: it pulls {now[k]:.4g} N at its "
                f"{('anchor', 'fairlead')[k]}, {rest[k]:.4g} N in its static equilibrium, and "
                f"moves at first: {remedy}"
            )
    return texts


def left_over(names, forces, tensions, segments, remedy):
    """A text for each line with a node that is far from rest, where no equilibrium is known.

    `forces` are the largest [N] that is left on an inner node of each line, `segments` their
    numbers of segments.
    """
    return [
        f"{name} does not start at rest: its static equilibrium was not found, {force:.3g} N are "
        f"left on a node while it pulls {max(tension):.4g} N at an end, and it moves at first: "
        f"{remedy}"
        for name, force, tension, count in zip(names, forces, tensions, segments, strict=True)
        if force > LEFT * max(tension) * min(1.0, COARSE / count)
    ]


def too_long(net, names):
    """A text for each line of `net` that is longer than there is room for between its ends.

    There is room for what hangs from both ends straight down to the seabed, or of a line lighter
    than water rises to the surface, and for the distance between these two places. Lines with an
    end below the seabed are left out.
    """
    texts = []
    for name, line in zip(names, net.lines, strict=True):
        a, b = (net.position[k] for k in line["ends"])
        floats = line["weight"] < line["buoyancy"]
        level, where = (0.0, "surface") if floats else (net.bed, "seabed")
        away = [abs(z) if floats else max(0.0, z - level) for z in (a[2], b[2])]
        across = hypot(a[0] - b[0], a[1] - b[1])
        room = sum(away) + across
        if min(a[2], b[2]) >= net.bed - SUNK and line["length"] > (1 + LONGER) * room:
            texts.append(
                f"{name} is {line['length']:.6g} m long, {line['length'] - room:.4g} m more than "
                f"there is room for: {away[0]:.4g} m and {away[1]:.4g} m from its ends to the "
                f"{where} at z = {level:g} m, and {across:.4g} m along it; the rest lies in loops: "
                "check its length and the positions of its ends"
            )
    return texts


def lying(above, length):
    """The part [m] of a line of unstretched `length` on a flat seabed, from end A on.

    `above` [m] it are its nodes. Behind the last node that lies, the line rises as a parabola
    through the two next ones.
    """
    count = len(above) - 1
    free = next((k for k, z in enumerate(above) if z > LYING), count + 1)
    if not 0 < free < count:
        return length * (min(free, count + 1) - 1) / count if free else 0.0
    first, second = above[free : free + 2]
    rise = sqrt(second / first) - 1 if second > first else 0.0
    return length / count * (free - min(1.0, 1 / rise if rise else 1.0))
