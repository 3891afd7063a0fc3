"""Warnings at the start: places that can be run, but hardly be meant.

Of anchors and fairleads, buoys above the water, and fairleads elsewhere than drawn.

Travels inside the FMU: imports the standard library only. A `net` is a `statics.Net`; `points` are
those of the description it was made from.
"""

from math import dist

HIGH = 5.0, 0.05  # [m], and of the depth: so far above the seabed an anchor may be without a word
CLEAR = 1e-3  # [m] above the water
DIGITS, SHARE = 0.01, 1e-3  # [m], and of the shortest line: to what files round positions


def high_anchors(points, bed):
    """A text for each anchor above the water, or far above the seabed at z = `bed` [m]."""
    texts = []
    for point in points:
        z = point["position"][2]
        if not point.get("anchor") or z - bed <= max(HIGH[0], -HIGH[1] * bed):
            continue
        place = "above the water" if z > 0 else "in the water"
        texts.append(
            f"{point['name']} is fixed {place} at z = {z:.6g} m, {z - bed:.4g} m above the seabed "
            f"at {bed:.6g} m: check its z and the depth of the water"
        )
    return texts


def above_water(points, heights):
    """A text, by its number, for each buoyant free point above the water, of those with z [m]."""
    return {
        f"point {k}": f"free {points[k]['name']} is at z = {z:+.3g} m, above the water, and its "
        f"buoyancy of {points[k]['buoyancy']:.4g} N is not reduced there: give it less volume or a "
        "shorter line"
        for k, z in heights.items()
        if points[k].get("buoyancy") and z > CLEAR
    }


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
    """A text for each fairlead that starts elsewhere than drawn.

    `drawn` is the name and the place [m] of each, `position` where it is [m]; `shortest` is the
    length [m] of the shortest line.
    """
    texts = []
    for (name, *at), place in zip(drawn, position, strict=bool(drawn)):
        away = dist(place, at)
        if away > min(DIGITS, SHARE * shortest):
            starts, there = (", ".join(f"{c:.6g}" for c in p) for p in (place, at))
            texts.append(
                f"{name} starts at ({starts}) m and is at ({there}) m in the file, {away:.4g} m "
                "away: check the connection, the initial position of its body, and the origin and "
                "the order of the points in the file"
            )
    return texts
