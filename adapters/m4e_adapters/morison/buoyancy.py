"""Buoyancy of a circular cylinder with flat ends, in any pose and partly out of the water.

Still water up to its surface, over which the axis is at the depths d₁, d₂ at its ends, has the
potential energy of the water that the cylinder displaces,

    U = ρ g ∫ −z dV = ρ g r² L (F(d₂) − F(d₁))/(d₂ − d₁),    c = r √(e_x² + e_y²)

c is half the height of a section, and F'' the wet part a(τ) of a section over r², τ = d/c:

    a = π/2 + asin τ + τ √(1 − τ²),   F' = c φ(τ),   F = c² ψ(τ),   φ' = a,   ψ' = φ

Force and moment are the derivatives of U by the pose: exact for all inclinations, and
conservative. Where the axis is nearly level, so that d₂ − d₁ is small beside c, the quotients are
taken as means of derivatives, by Gauss points.
"""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.morison.vectors import Number, Vector, add, cross, scaled
from m4e_fmi.program import asin, maximum, minimum, sqrt

UPRIGHT = 1e-6  # horizontal part of the axis of an upright member, so that its root has a slope
WITHIN = 1.0 - 1e-12  # of τ, so that roots have a slope where a section is just wet or dry
LEVEL = (0.01, 0.02)  # |d₂ − d₁|/c from which on quotients begin to count, and alone
NONE = 1e-9  # of c, which guards quotients
UP: Vector = (0.0, 0.0, 1.0)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
GAUSS = tuple(zip((0.5 + 0.5 * _NODES).tolist(), (0.5 * _WEIGHTS).tolist(), strict=True))


def buoyancy(
    arms: tuple[Vector, Vector],
    along: Vector,
    depths: tuple[Number, Number],
    *,
    radius: float,
    length: Number,
    weight: float,
) -> tuple[Vector, Vector]:
    """Force [N] and moment [N.m] on a part of a member between two `arms` [m].

    `along` is its axis, `length` [m] long; `depths` [m] are those of its ends below the surface,
    `weight` ρ g [N/m3] of the water.
    """
    x, y, upwards = along
    half = radius * sqrt(x * x + y * y + UPRIGHT**2)
    first, second, turning = _quotients(*depths, half)
    scale = weight * radius**2 * length
    one, other = scaled(scale * first, UP), scaled(scale * second, UP)
    tilt = scaled(scale * radius**2 * upwards * turning, cross(along, UP))
    moment = add(cross(arms[0], one), cross(arms[1], other), tilt)
    return add(one, other), moment


def _quotients(first: Number, second: Number, half: Number) -> tuple[Number, Number, Number]:
    """Derivatives of (F₂ − F₁)/(d₂ − d₁) by d₁ [1], by d₂ [1], and by c over c [1/m]."""
    step, (low, high) = second - first, LEVEL
    over = step / (step * step + (NONE * half) * (NONE * half))
    one, other = _Depth(first, half), _Depth(second, half)
    # F₂ − F₁ [m2], F = c² ψ + π/2 (max(d, c)² − c²), without cancellation in deep water
    deeper = other.deep - one.deep
    change = half * half * (other.psi - one.psi) + math.pi / 2 * deeper * (other.deep + one.deep)
    quotient = change * over
    steep = (
        (quotient - one.slope) * over,
        (other.slope - quotient) * over,
        (other.turning - one.turning) * over,
    )
    flat: list[Number] = [0.0, 0.0, 0.0]
    for share, weight in GAUSS:
        here = _Depth(first + share * step, half)
        flat[0] = flat[0] + weight * (1.0 - share) * here.area
        flat[1] = flat[1] + weight * share * here.area
        flat[2] = flat[2] + weight * here.turning_slope
    part = minimum(maximum((abs(step) / half - low) / (high - low), 0.0), 1.0)
    a, b, c = (part * s + (1.0 - part) * f for s, f in zip(steep, flat, strict=True))
    return a, b, c


class _Depth:
    """Derivatives of F at a depth d [m] of the axis, c = `half` [m]; its parts `psi`, max(d, c)."""

    def __init__(self, depth: Number, half: Number) -> None:
        tau = minimum(maximum(depth / half, -WITHIN), WITHIN)
        root, angle = sqrt(1.0 - tau * tau), asin(tau)
        cube = root * root * root
        self.area = math.pi / 2 + angle + tau * root
        phi = math.pi / 2 * tau + tau * angle + root - cube / 3.0
        psi = (
            math.pi / 4 * tau * tau
            + angle * (0.5 * tau * tau + 0.125)
            + tau * root * 0.625
            - tau * cube / 12.0
            + math.pi / 16
        )
        self.psi, self.deep = psi, maximum(depth, half)
        self.slope = half * phi + math.pi * (self.deep - half)
        self.turning = 2.0 * psi - tau * phi
        self.turning_slope = (phi - tau * self.area) / half
