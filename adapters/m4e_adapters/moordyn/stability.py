"""How long MoorDyn's internal step may be before a line blows up.

A line of segments of length l, mass per length m' and stiffness EA is a chain of masses m'l and
springs EA/l. With M, C, K of the linearised line and a mode u, an eigenvalue λ solves
u*(λ²M + λC + K)u = 0: where it is complex, |λ|² = u*Ku/u*Mu; where it is real, dampers add.

Oscillation: no mode of the chain, whatever it is attached to, is faster than one segment alone with
half its mass at either end, ω = (2/l) √(EA/m') (the highest eigenvalue of an assembly is bounded by
that of its elements), with the damping ratio ζ = BA/(l √(EA m')). Bending adds ω = (4/l²) √(EI/m'),
the seabed ω = √(kBot d/m'). Further damping only moves λ along its circle to the real axis.

Decay: MoorDyn's axial dampers BA work in slack segments too, where no spring slows the decay, so
the bound is that of C alone: x²M − xC + K is positive wherever xM − C is. Rates of line, seabed and
drag add. A node on the seabed has the rate Γ = cBot d/m_b, drag at a speed V adds at most
D = ρ d V max(Cd/(m' + ρ A Ca), π CdAx/(m' + ρ A CaAx)) to every mode. Let a vertical chain have one
node on the seabed, segments on both sides. With c = 2ζω/4 of a segment per mass of a node,
u_j = r^|j| and λ = −x, its nodes and the one on the seabed give

    x = c (2 − r − 1/r)   and   x = Γ + c (2 − 2r),   so   x = ζω + √(ζ²ω² + Γ²),   and D beside it.

Segments that do not land steeply on both sides decay slower (tests compare with eigenvalues of
assembled lines of any slope, taut and slack). At the lowest node the line is at most 45° steep,
between its neighbours: there 1/m_b is the mean of 1/m' and 1/(m' + ρ A Ca). Neighbours on the
seabed are joined by segments that lie flat: seabeds so soft that nodes sink in by a good part of a
segment are outside of this. Taut lines of ζ = 1 decay with ω + Γ at most.

A one-step method is stable for λ while |R(λ dt)| ≤ 1, with its stability function R. MoorDyn's own
`CFL` is dt·√(EA/m')/(2π l), so its default 0.5 means ω dt = 6.3, beyond RK2 (2) and RK4 (2.8). RK2
lets every undamped mode grow, so it needs a short step for a line without damping.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.polynomial import polyval

SCHEMES = {"RK2": 2, "RK4": 4}  # name → order: R is the exponential series up to that power
MARGIN = 0.9  # of the longest stable step that is used when nothing else is asked for
SPEED = 5.0  # [m/s] of a node through still water, up to which drag is in the longest stable step
GROWTH = 1.0001  # |R| up to which a mode counts as stable: drag takes up so slow a growth
STRAIN = 0.2  # by which a line may be stretched on its way to the seabed
RESOLUTION = 400  # steps of the search per unit of |λ dt|
FARTHEST = 3.0  # |λ dt| that the search looks at, beyond the region of every scheme
ANGLES = 6  # damping ratios between that of a mode and 1 that are looked at


@dataclass(frozen=True)
class Segment:
    """One segment of a line, the water around and the seabed below it (SI units).

    `damping` is MoorDyn's BA [N·s]; `seabed_stiffness` kBot [Pa/m], `seabed_damping` cBot [Pa·s/m];
    `friction` [N·s/m] is what seabed friction adds to a node's damping; steps are stable up to the
    `speed` [m/s] of a node through the water.
    """

    length: float
    diameter: float
    mass_per_length: float
    axial_stiffness: float
    damping: float
    bending_stiffness: float
    seabed_stiffness: float
    seabed_damping: float
    water_density: float = 0.0
    drag_coefficient: float = 0.0
    added_mass_coefficient: float = 0.0
    axial_drag_coefficient: float = 0.0
    axial_added_mass_coefficient: float = 0.0
    friction: float = 0.0
    speed: float = SPEED


def clear_of_seabed(held: Iterable[float], *, length: float, depth: float) -> bool:
    """True if no part of a line can reach the seabed at −`depth`; `held` are z of ends that stay.

    All in metres; `length` is unstretched, a line may be stretched by STRAIN.
    """
    return max(held, default=-math.inf) - (1 + STRAIN) * length > -depth


def damping_of_ratio(ratio: float, *, length: float, mass_per_length: float, axial: float) -> float:
    """BA [N·s] of a damping ratio of the fastest mode of a segment of `length` [m]."""
    return ratio * length * math.sqrt(axial * mass_per_length)


def oscillations(segment: Segment) -> list[tuple[float, float]]:
    """(Frequency ω [rad/s], least damping ratio ζ) of the fastest axial, bending, seabed modes."""
    m, length = segment.mass_per_length, segment.length
    axial = 2 / length * math.sqrt(segment.axial_stiffness / m)
    bending = 4 / length**2 * math.sqrt(segment.bending_stiffness / m)
    seabed = math.sqrt(segment.seabed_stiffness * segment.diameter / m)
    damped = segment.seabed_damping * segment.diameter / m / (2 * seabed) if seabed else 0.0
    critical = length * math.sqrt(segment.axial_stiffness * m)
    found = [(axial, segment.damping / critical), (bending, 0.0), (seabed, damped)]
    return [mode for mode in found if mode[0] > 0]


def decay_rate(segment: Segment) -> float:
    """Upper bound [1/s] of the decay rates of a line of such segments that lands on the seabed."""
    m, length, d = segment.mass_per_length, segment.length, segment.diameter
    water = segment.water_density * math.pi * d**2 / 4
    across = m + water * segment.added_mass_coefficient
    along = m + water * segment.axial_added_mass_coefficient
    drag = max(segment.drag_coefficient / across, math.pi * segment.axial_drag_coefficient / along)
    drag = segment.water_density * d * segment.speed * drag + segment.friction / (m * length)
    seabed = segment.seabed_damping * d * (1 / m + 1 / across) / 2
    axial = 2 * segment.damping / (m * length**2)  # ζω
    return drag + axial + math.hypot(axial, seabed)


def stable_step(segment: Segment, scheme: str) -> float:
    """The longest stable internal step [s] of `scheme` for a segment."""
    limits = [_limit(scheme, 1.0) / rate for rate in (decay_rate(segment),) if rate > 0]
    for omega, ratio in oscillations(segment):
        least = min(ratio, 1.0)
        ratios = (least + (1.0 - least) * k / ANGLES for k in range(ANGLES + 1))
        limits.append(min(_limit(scheme, r) for r in ratios) / omega)
    return min(limits)


def fastest(segment: Segment, step: float, scheme: str) -> float:
    """The speed [m/s] of a node through the water up to which drag lets `step` [s] be stable."""
    still = decay_rate(replace(segment, speed=0.0))
    drag = replace(segment, speed=1.0, damping=0.0, seabed_damping=0.0, friction=0.0)
    slope = decay_rate(drag)  # the rate is linear in the speed
    return (_limit(scheme, 1.0) / step - still) / slope if slope else math.inf


def _limit(scheme: str, ratio: float) -> float:
    """The largest |λ| dt up to which `scheme` damps a λ of damping ratio `ratio`, at most 1."""
    direction = -ratio + 1j * cmath.sqrt(1 - ratio**2)
    steps = np.arange(1, int(FARTHEST * RESOLUTION) + 1)
    series = [1 / math.factorial(k) for k in range(SCHEMES[scheme] + 1)]
    grows = np.abs(polyval(direction * steps / RESOLUTION, series)) > GROWTH
    stable = int(grows.argmax()) if grows.any() else len(steps)
    return stable / RESOLUTION
