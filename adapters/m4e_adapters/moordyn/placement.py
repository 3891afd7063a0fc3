"""Fairleads that start where they cannot be meant to: below the seabed, or elsewhere than drawn.

Travels inside the FMU: imports the standard library only.
"""

from math import hypot

DIGITS, SHARE = 0.01, 1e-3  # [m], and of the shortest line: to what files round positions


def below_seabed(names, position, bed):
    """A text for each fairlead that starts below the seabed at z = `bed` [m].

    `position` is the place [m] of each, z last.
    """
    return [
        f"{name} starts at z = {z:.6g} m, {bed - z:.4g} m below the seabed at {bed:g} m: check the "
        "connection, the initial position of its body, and the depth of the water"
        for name, (*_, z) in zip(names, position, strict=True)
        if z < bed - DIGITS
    ]


def unplaced(names, position, given):
    """A text for each fairlead at the origin to which `given` gives no place."""
    origin = ", ".join("0" for _ in (position or [()])[0])
    return [
        f"{name} starts at ({origin}): if it is not connected, connect it; if ({origin}) is meant, "
        f"write 'fairleads: {{{name}: [{origin}]}}'"
        for name, place in zip(names, position, strict=True)
        if name not in given and not any(place)
    ]


def misplaced(drawn, position, *, shortest):
    """A text for each fairlead that starts elsewhere than drawn, or one if the order is another.

    `drawn` is the name and the place [m] of each, `position` where it is [m]; `shortest` is the
    length [m] of the shortest line.
    """
    tolerance = min(DIGITS, SHARE * shortest)

    def distance(k, other):
        return hypot(*(c - at for c, at in zip(position[k], drawn[other][1:], strict=True)))

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
    name, *at = drawn[k]
    starts, drawn_at = (", ".join(f"{c:.6g}" for c in place) for place in (position[k], at))
    return f"{name} starts at ({starts}) m and is at ({drawn_at}) m in the file"
