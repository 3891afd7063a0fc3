"""Fairleads that start elsewhere than the file of their lines has them.

Travels inside the FMU: imports the standard library only.
"""

from math import hypot

DIGITS, SHARE = 0.01, 1e-3  # [m], and of the shortest line: to what files round positions


def misplaced(drawn, position, *, shortest):
    """A text for each fairlead that starts elsewhere than drawn, or one if the order is another.

    `drawn` is name, x and z [m] of each, `position` its (x, z) [m]; `shortest` is the length [m] of
    the shortest line.
    """
    tolerance = min(DIGITS, SHARE * shortest)

    def distance(k, other):
        (x, z), (_, at_x, at_z) = position[k], drawn[other]
        return hypot(x - at_x, z - at_z)

    count = range(len(drawn))
    away = [k for k in count if distance(k, k) > tolerance]
    nearest = [min(count, key=lambda other, k=k: (distance(k, other), other != k)) for k in count]
    swapped = sorted(nearest) == list(count) and any(
        2 * max(distance(j, nearest[j]) for j in count) < distance(k, k) for k in away
    )
    if swapped:
        order = ", ".join(drawn[nearest.index(k)][0] for k in count)
        return [
            f"fairleads start where the file has others ({_placed(drawn, position, away[0])}): "
            f"give them in the order of its coupled points, which seems to be {order}"
        ]
    return [
        f"{_placed(drawn, position, k)}, {distance(k, k):.4g} m away: check the connection, the "
        "initial position of its body, and the origin and the order of the points in the file"
        for k in away
    ]


def _placed(drawn, position, k):
    """Where fairlead `k` starts, and where it is in the file."""
    (x, z), (name, at_x, at_z) = position[k], drawn[k]
    return f"{name} starts at ({x:.6g}, {z:.6g}) m and is at ({at_x:.6g}, {at_z:.6g}) m in the file"
