"""How long MoorDyn's internal steps may be, and what the loop over MoorDyn knows of a line.

A line of segments of length l, mass per length m' and stiffness EA is a chain of masses m'l and
springs EA/l, with dampers. An eigenvalue λ of its small motions needs |R(λ dt)| ≤ 1, with the
method's stability function R. Where the line is in a run decides what is in the way: a damper
without a spring where segments are slack, a node that lands steeply on the seabed, drag. So the
loop looks at every line before some internal steps, and chooses those that are stable there: see
`line_steps.c` of the runtime, whose numbers of a line are `kind`.

`stable_step` is the longest step of a line that is taut and lies flat where it lies: oscillation
of one segment with half its mass at either end (no assembly of them is faster), ω = (2/l) √(EA/m')
with the damping ratio ζ = BA/(l √(EA m')), further damping added, or with ζ > 1 its faster decay,
ω (ζ + √(ζ² − 1)); bending, ω = (4/l²) √(EI/m'); the seabed, ω = √(kBot d/m'), and the decay of a
node there, cBot d/(m' + ρ A Ca), to which friction adds.

MoorDyn's own `CFL` is dt·√(EA/m')/(2π l), so its default 0.5 means ω dt = 6.3, beyond RK2 (2) and
RK4 (2.8). RK2 lets every undamped mode grow, so it needs a short step for a line without damping.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyval

SCHEMES = {"RK2": 2, "RK4": 4}
"""Name → order and evaluations of a step: R is the exponential series up to that power."""
MARGIN = 0.95  # of the longest stable step that is taken
GROWTH = 1.0001  # |R| up to which a mode counts as stable: drag takes up so slow a growth
FLOW = 5.0  # [m/s] of water that only MoorDyn knows, as from its own files
STRAIN = 0.2  # by which a line may be stretched on its way to the seabed
RESOLUTION = 400  # steps of the search per unit of |λ dt|
FARTHEST = 3.0  # |λ dt| that the search looks at, beyond the region of every scheme
ANGLES = 6  # damping ratios between that of a mode and 1 that are looked at


@dataclass(frozen=True)
class Segment:
    """One segment of a line, the water around and the seabed below it (SI units).

    `axial_stiffness` is the largest EA [N], `least_stiffness` the least where it is taut (None: the
    same), `damping` MoorDyn's BA [N·s]; `seabed_stiffness` kBot [Pa/m], `seabed_damping` cBot
    [Pa·s/m]; `friction` [N·s/m] is what seabed friction adds to a node's damping.
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
    least_stiffness: float | None = None

    @property
    def masses(self) -> tuple[float, float]:
        """Mass per length [kg/m] in water, that added to it included: across and along the line."""
        water = self.water_density * math.pi * self.diameter**2 / 4
        ratios = self.added_mass_coefficient, self.axial_added_mass_coefficient
        across, along = (self.mass_per_length + water * ratio for ratio in ratios)
        return across, along


def kind(segment: Segment, *, bed: float) -> tuple[float, ...]:
    """The numbers of `m4e_line_kind` (line_steps.h): `bed` is z [m] of the seabed at its highest.

    The last one is the speed [m/s] of water that the loop does not know: 0.
    """
    drag, least = segment.water_density * segment.diameter, segment.least_stiffness
    return (
        segment.mass_per_length,
        *segment.masses,
        drag * segment.drag_coefficient,
        drag * math.pi * segment.axial_drag_coefficient,
        segment.axial_stiffness,
        segment.axial_stiffness if least is None else least,
        segment.damping,
        segment.bending_stiffness,
        bed,
        segment.seabed_stiffness * segment.diameter,
        segment.seabed_damping * segment.diameter,
        segment.friction,
        0.0,
    )


NOTHING = (0.0,) * 14
"""The numbers of a line in which nothing moves by itself."""


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


def cheapest_scheme(segments: Iterable[Segment]) -> str:
    """The method that covers most time for an evaluation of all these."""
    each = list(segments)

    def covered(scheme: str) -> float:
        return min((stable_step(s, scheme) for s in each), default=1.0) / SCHEMES[scheme]

    return max(SCHEMES, key=covered)


def stable_step(segment: Segment, scheme: str) -> float:
    """The longest stable internal step [s] of `scheme` for a taut segment, flat on the seabed."""
    across, _ = segment.masses
    rate = segment.seabed_damping * segment.diameter / across
    rate += segment.friction / (segment.mass_per_length * segment.length)
    (omega, ratio), *_ = oscillations(segment)
    if ratio > 1:
        rate = max(rate, omega * (ratio + math.sqrt(ratio**2 - 1)))
    limits = [_limit(scheme, 1.0) / rate] if rate else []
    for omega, ratio in oscillations(segment):
        least = min(ratio, 1.0)
        ratios = (least + (1.0 - least) * k / ANGLES for k in range(ANGLES + 1))
        limits.append(min(_limit(scheme, r) for r in ratios) / omega)
    return min(limits)


def _limit(scheme: str, ratio: float) -> float:
    """The largest |λ| dt up to which `scheme` damps a λ of damping ratio `ratio`, at most 1."""
    direction = -ratio + 1j * cmath.sqrt(1 - ratio**2)
    steps = np.arange(1, int(FARTHEST * RESOLUTION) + 1)
    series = [1 / math.factorial(k) for k in range(SCHEMES[scheme] + 1)]
    grows = np.abs(polyval(direction * steps / RESOLUTION, series)) > GROWTH
    stable = int(grows.argmax()) if grows.any() else len(steps)
    return stable / RESOLUTION
