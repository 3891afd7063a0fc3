"""Warnings at the start: values that can be run, but hardly be meant, and buoys above the water.

Travels inside the FMU: imports the standard library only. A `net` is a `statics.Net`; `points` are
those of the description it was made from.
"""

from itertools import pairwise
from math import dist, hypot

HIGH = 5.0, 0.05  # [m], and of the depth: so far above the seabed an anchor, above the
# water a fairlead may be without a word
LIGHT = 0.3  # weight of a line over that of the water it displaces
COARSE = 0.3  # weight in water of half a segment, over the tension at an end
SOFT = 0.05  # strain of a hanging line by its own weight in water
STRETCHED = 0.2  # strain of a segment in equilibrium
CLEAR = 1e-3  # [m] above the water


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


def high_fairleads(names, position, bed):
    """A text for each fairlead far above the water, of a depth down to z = `bed` [m] or None."""
    most = max(HIGH[0], -HIGH[1] * (bed or 0.0))
    return [
        f"fairlead {name} starts at z = {place[-1]:.4g} m, above the water: check the z of its "
        "point on the body, and the position of the body"
        for name, place in zip(names, position, strict=True)
        if place[-1] > most
    ]


def soft_lines(lines, names):
    """A text for each line that its own weight stretches far."""
    weights = [abs(line["weight"] - line["buoyancy"]) * line["length"] for line in lines]
    return [
        f"{name}, hanging, is stretched by {50 * weight / line['stiffness']:.3g} % by its own "
        f"weight: check its axial stiffness EA, {line['stiffness']:.4g} N (not kN)"
        for name, line, weight in zip(names, lines, weights, strict=True)
        if weight > 2 * SOFT * line["stiffness"]
    ]


def light_lines(lines, names):
    """A text for each line that is many times lighter than the water it displaces."""
    return [
        f"{name} weighs {line['weight']:.4g} N/m, and the water that it displaces "
        f"{line['buoyancy']:.4g} N/m: check its diameter, "
        f"{line['diameter']:g} m (not mm), and its mass per length in kg/m"
        for name, line in zip(names, lines, strict=True)
        if line["weight"] < LIGHT * line["buoyancy"]
    ]


def coarse_lines(net, names, tensions):
    """A text for each line whose segments are long; `tensions` are (of end A, of end B) [N].

    Lines that lie on the seabed up to their ends are left out.
    """
    texts = []
    for name, line, ends in zip(names, net.lines, tensions, strict=True):
        length = line["length"] / line["segments"]
        half = abs(line["weight"] - line["buoyancy"]) * length / 2
        rise = max(net.position[k][2] for k in line["ends"]) - net.bed
        if half > COARSE * max(ends) and rise > length / 10:
            texts.append(
                f"{name} is divided coarsely: half of a segment weighs {half:.4g} N in water, and "
                f"the line pulls {max(ends):.4g} N at an end: use more than {line['segments']} "
                "segments"
            )
    return texts


def stretched_lines(net, names):
    """A text for each line that hangs stretched far in the equilibrium of `net`.

    Those whose ends are further apart than they are long are told elsewhere.
    """
    texts = []
    for name, line, nodes, ends in zip(names, net.lines, net.nodes, net.end_forces(), strict=True):
        longest = max(dist(net.position[a], net.position[b]) for a, b in pairwise(nodes))
        strain = longest * line["segments"] / line["length"] - 1
        apart = dist(net.position[nodes[0]], net.position[nodes[-1]])
        if strain > STRETCHED and apart <= line["length"]:
            tension = max(hypot(*force) for force in ends)
            texts.append(
                f"{name} is stretched by up to {100 * strain:.3g} % at the start, where it pulls "
                f"{tension:.4g} N: check its stiffness EA, {line['stiffness']:.4g} N"
            )
    return texts


def above_water(points, heights):
    """A text, by number, for each buoyant free point above the water, of those with z [m]."""
    return {
        k: f"free {points[k]['name']} is at z = {z:+.3g} m, above the water, and its buoyancy of "
        f"{points[k]['buoyancy']:.4g} N is not reduced there: give it less volume or a shorter line"
        for k, z in heights.items()
        if points[k].get("buoyancy") and z > CLEAR
    }
