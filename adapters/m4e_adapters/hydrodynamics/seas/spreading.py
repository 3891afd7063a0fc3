"""Directions of the components of a short-crested sea.

Each component has a direction of its own (single summation), so that no two of one frequency have
phases that are fixed to each other: double summation would make a sea that is uneven in space
(D. Miles and E. R. Funke, "A comparison of methods for synthesis of directional seas", Journal of
Offshore Mechanics and Arctic Engineering 111, 1989). The density of Longuet-Higgins, Cartwright and
Smith (1963) is in proportion to cos^2s(Δ/2).
"""

from __future__ import annotations

import math

import numpy as np

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_KNOTS = 20_001  # of the distribution's integral


def spread(count: int, exponent: float, rng: np.random.Generator) -> np.ndarray:
    """Directions (count,) [rad] from the mean one, for components in order of frequency.

    Quantiles of the density at u + k/φ (mod 1), φ the golden ratio, from a random u: any
    neighbouring components have directions that cover the density evenly.
    """
    angle = np.linspace(-math.pi, math.pi, _KNOTS)
    density = np.cos(0.5 * angle) ** (2.0 * exponent)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    share = (rng.random() + GOLDEN * np.arange(count)) % 1.0
    return np.interp(share, integral / integral[-1], angle)
