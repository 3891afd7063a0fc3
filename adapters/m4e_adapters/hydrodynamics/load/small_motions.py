"""Ranges of the motions from the reference pose in which linear hydrodynamics holds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import NO_WATERPLANE, Coefficients
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem

HEAVE, TURN = 0.5, math.radians(15.0)  # limits: mean drafts, rad
OF_WAVE = 0.1  # of the wave length (at the peak): 36 deg of the phase
OF_GAP = 0.25  # of the distance between bodies, whose waves feel it


@dataclass(frozen=True)
class Range:
    """From `minimum` to `maximum` [m or rad]; `reason` tells both in words."""

    minimum: float = -math.inf
    maximum: float = math.inf
    reason: str = ""

    @property
    def is_open(self) -> bool:
        """True if there is no limit."""
        return math.isinf(self.minimum) and math.isinf(self.maximum)


def motion_ranges(
    coefficients: Coefficients, k: int, waves: Sequence[WaveSystem]
) -> dict[str, Range]:
    """The ranges of body `k` by motion."""
    reason = f"the water is linear, for motions within {math.degrees(TURN):g} deg"
    turn, drift = Range(-TURN, TURN, reason), _drift(coefficients, k, waves)
    known = {"heave": _heave(coefficients, k), "surge": drift, "sway": drift}
    return {m.name: known.get(m.name, turn) for m in coefficients.body_motions}


def _drift(coefficients: Coefficients, k: int, waves: Sequence[WaveSystem]) -> Range:
    """The excitation is that at the reference place: a share of the shortest system's length.

    In still water a share of the distance to the nearest of several bodies; one body may go
    anywhere.
    """
    if waves:
        length = min(system.length for system in waves)
        limit = OF_WAVE * length
        reason = (
            f"the waves are those at the reference place, for motions within {OF_WAVE:g} of their "
            f"length of {length:.4g} m"
        )
        return Range(-limit, limit, reason)
    ways = np.delete(coefficients.places, k, axis=0) - coefficients.places[k]
    distances = [math.hypot(x, y) for x, y, _ in ways.tolist()]
    if not distances or min(distances) == 0.0:
        return Range()
    limit = OF_GAP * min(distances)
    reason = (
        f"bodies feel each other as in the reference pose, for motions within {OF_GAP:g} of their "
        f"distance of {min(distances):.4g} m"
    )
    return Range(-limit, limit, reason)


def _heave(coefficients: Coefficients, k: int) -> Range:
    """Up and down to half the mean draft (displaced volume over waterplane), or to the surface.

    A submerged body has no waterplane: it may rise, and sink, by the depth of its highest point.
    Nor may a body leave the water or reach the sea bed.
    """
    weight = coefficients.density * coefficients.gravity
    heave = k * coefficients.per_body + coefficients.heave
    waterplane = float(coefficients.hydrostatic_stiffness[heave, heave]) / weight
    volume = float(coefficients.buoyancy[heave]) / weight
    keel, top = coefficients.heights[k] if len(coefficients.heights) else (-math.inf, 0.0)
    if waterplane > NO_WATERPLANE * math.cbrt(volume) ** 2:
        limit = HEAVE * volume / waterplane
        reason = f"the water is linear, for motions within {HEAVE:g} of the mean draft"
    elif top < 0.0:
        limit = -top
        reason = f"the water is linear, its surface is {limit:.4g} m above the body"
    else:
        return Range()
    down = min(limit, coefficients.depth + keel) if math.isfinite(keel) else limit
    if down < limit:
        reason += f", and the sea bed {down:.4g} m below it"
    up = min(limit, -keel)
    if up < limit:
        reason += f", and the body leaves the water {up:.4g} m higher"
    return Range(-down, up, reason)
