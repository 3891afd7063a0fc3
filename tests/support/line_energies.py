"""Energy of a line: what its ends and the water put in, what it stores, what dampers take.

World frame, Z up, SI units. The sums are
those of MoorDyn's own forces (Line.cpp, `getStateDeriv`), from places and velocities of nodes:

- Stored: kinetic energy of inner nodes with their added mass (ends have no inertia), weight and
  buoyancy m g z − ρ g A min(z, 0), springs EA (L − l)²/(2 l) of taut segments, and of the seabed,
  kBot d l p²/2 at a depth p in it.
- Dissipated: BA/l times the square of the rate of each segment's length, drag times the speed
  through the water, cBot d l v_z² on the seabed.
- Put in by ends: the force that they exert, spring, damper, weight, drag and seabed of half a
  segment, times their velocity; by the water: drag times its velocity.

Powers are continuous but for ends whose velocity jumps; their trapezoids close the balance within
0.2 % of what is put in and taken out, at steps of 25 ms of a chain on the seabed. Not in it:
bending, seabed friction, the acceleration of the water, segments half out of the water, winches.
"""

from math import hypot
from operator import mul, sub


def energies(kind, net_line, places, speeds, water=None):
    """Stored energy [J]; powers [W] put in by the ends and by the water, and dissipated.

    `kind` is as `stability.kind` has it, `net_line` as `mooring.net_line`; places [m], speeds [m/s]
    and the water's (None: still) are (x, y, z) of each node.
    """
    mass, across, along, drag, axial, ea, _, ba, _, bed, spring, damper, *_ = kind
    count, length = len(places) - 1, net_line["length"] / (len(places) - 1)
    stored = by_water = dissipated = 0.0
    forces = [[0.0, 0.0, 0.0] for _ in places]
    for k in range(count):
        way = list(map(sub, places[k + 1], places[k]))
        size = hypot(*way)
        rate = sum(map(mul, way, map(sub, speeds[k + 1], speeds[k]))) / size
        stretch = max(size - length, 0.0)
        pull = (ea * stretch + ba * rate) / length
        stored += ea * stretch**2 / (2 * length)
        dissipated += ba * rate**2 / length
        for c in range(3):
            forces[k][c] += pull * way[c] / size
            forces[k + 1][c] -= pull * way[c] / size
    for k, (place, speed, force) in enumerate(zip(places, speeds, forces, strict=True)):
        inner = 0 < k < count
        part = length if inner else length / 2
        way = list(map(sub, places[min(k + 1, count)], places[max(k - 1, 0)]))
        q = [x / hypot(*way) for x in way]
        z, depth = place[2], max(bed - place[2], 0.0)
        if inner:
            past = sum(map(mul, speed, q))
            beside = sum(map(mul, speed, speed)) - past**2
            heavy = (across, along) if z < 0 else (mass, mass)
            stored += part * (heavy[0] * beside + heavy[1] * past**2) / 2
        stored += part * (net_line["weight"] * z - net_line["buoyancy"] * min(z, 0.0))
        stored += part * spring * depth**2 / 2
        force[2] -= part * (net_line["weight"] - (net_line["buoyancy"] if z < 0 else 0.0))
        if depth:
            force[2] += part * (spring * depth - damper * speed[2])
            dissipated += part * damper * speed[2] ** 2
        stream = water[k] if water else (0.0, 0.0, 0.0)
        flow = list(map(sub, stream, speed))
        past = sum(map(mul, flow, q))
        side = [f - past * x for f, x in zip(flow, q, strict=True)]
        share = part / 2 if z < 0 else 0.0
        pushed = [
            share * (drag * hypot(*side) * s + axial * abs(past) * past * x)
            for s, x in zip(side, q, strict=True)
        ]
        dissipated += sum(map(mul, pushed, flow))
        by_water += sum(map(mul, pushed, stream))
        for c in range(3):
            force[c] += pushed[c]
    put_in = -sum(sum(map(mul, forces[k], speeds[k])) for k in (0, count))
    return stored, put_in, by_water, dissipated
