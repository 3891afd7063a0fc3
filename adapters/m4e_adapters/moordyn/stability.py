"""How long MoorDyn's internal step may be before a line blows up.

A line of segments of length l, mass per length m' and stiffness EA is a chain of masses m'l and
springs EA/l; no mode of it, whatever it is attached to, is faster than one segment alone with half
its mass at either end: ω = (2/l) √(EA/m') (the highest eigenvalue of an assembly is bounded by that
of its elements). Its damping ratio is ζ = BA/(l √(EA m')). The seabed, a damper of cBot·d and a
spring of kBot·d per length, and bending add modes of their own. A one-step method is stable for a
mode λ while |R(λ dt)| ≤ 1, with its stability function R.

MoorDyn's own `CFL` is dt·√(EA/m')/(2π l), so its default 0.5 means ω dt = 6.3, beyond RK2 (2) and
RK4 (2.8). RK2 lets every undamped mode grow, so it needs a short step for a line without damping.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

SCHEMES = {"RK2": 2, "RK4": 4}  # name → order: R is the exponential series up to that power
MARGIN = 0.7  # of the stable step that is used when nothing else is asked for
GROWTH = 1.0001  # |R| up to which a mode counts as stable: drag takes up so slow a growth
RESOLUTION = 400  # steps of the search per unit of |λ dt|


@dataclass(frozen=True)
class Segment:
    """One segment of a line, and the seabed below it (SI units).

    `damping` is MoorDyn's BA [N·s]; `seabed_stiffness` kBot [Pa/m], `seabed_damping` cBot [Pa·s/m].
    """

    length: float
    diameter: float
    mass_per_length: float
    axial_stiffness: float
    damping: float
    bending_stiffness: float
    seabed_stiffness: float
    seabed_damping: float


def damping_of_ratio(ratio: float, *, length: float, mass_per_length: float, axial: float) -> float:
    """BA [N·s] of a damping ratio of the fastest mode of a segment of `length` [m]."""
    return ratio * length * math.sqrt(axial * mass_per_length)


def modes(segment: Segment) -> list[tuple[float, float]]:
    """(λ-magnitude ω [rad/s], damping ratio ζ) of the fastest axial, bending and seabed modes."""
    m, length = segment.mass_per_length, segment.length
    axial = 2 / length * math.sqrt(segment.axial_stiffness / m)
    ratio = segment.damping / (length * math.sqrt(segment.axial_stiffness * m))
    found = [(axial, ratio), (4 / length**2 * math.sqrt(segment.bending_stiffness / m), 0.0)]
    seabed = math.sqrt(segment.seabed_stiffness * segment.diameter / m)
    if seabed > 0:
        found.append((seabed, segment.seabed_damping * segment.diameter / m / (2 * seabed)))
    return [mode for mode in found if mode[0] > 0]


def stable_step(segment: Segment, scheme: str) -> float:
    """The longest stable internal step [s] of `scheme` for a segment."""
    return min(_limit(scheme, ratio) / omega for omega, ratio in modes(segment))


def _limit(scheme: str, ratio: float) -> float:
    """The largest ω dt up to which `scheme` damps a mode of damping ratio `ratio`."""
    root = cmath.sqrt(ratio**2 - 1)
    fast, slow = -ratio - root, -ratio + root
    scale = max(abs(fast), abs(slow))
    limit, step = 0.0, 1 / (RESOLUTION * scale)
    while all(_amplification(scheme, mode * (limit + step)) <= GROWTH for mode in (fast, slow)):
        limit += step
    return limit


def _amplification(scheme: str, value: complex) -> float:
    return abs(sum(value**k / math.factorial(k) for k in range(SCHEMES[scheme] + 1)))
