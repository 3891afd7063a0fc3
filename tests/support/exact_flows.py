"""Closed forms of linear potential flow, e^{−iωt}, written for the tests alone.

A submerged sphere in deep water: multipoles with their images in the free surface (as G. X. Wu and
R. Eatock Taylor, "Radiation and diffraction of water waves by a submerged sphere at forward speed",
Proc. R. Soc. A 417, 1988, and C. M. Linton, J. Fluid Mech. 225, 1991, do for other waters).
Cylinders from the surface to the sea bed: R. C. MacCamy and R. A. Fuchs, "Wave forces on piles: a
diffraction theory", Beach Erosion Board TM 69, 1954; of several C. M. Linton and D. V. Evans, "The
interaction of waves with arrays of vertical circular cylinders", J. Fluid Mech. 215, 1990.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import expi, h1vp, hankel1, jvp

TERMS = 16


def submerged_sphere(wavenumber: float, *, radius: float, depth: float, mode: int) -> complex:
    """(A + iB/ω)/(ρ 4/3 π a³) [1] of a sphere whose centre is `depth` [m] below deep water.

    `mode` 0 is heave, 1 surge; `wavenumber` [1/m].

    The potential is Σ bₙ aⁿ⁺² [Pₙᵐ(cos θ)/rⁿ⁺¹ + Σₛ Cₙₛ rˢ Pₛᵐ(cos θ)] cos mψ about the centre,

        Cₙₛ = 1/((n − m)! (s + m)!) ∫₀^∞ (k + K)/(k − K) kⁿ⁺ˢ e^{−2kd} dk,

    the path below the pole: image waves go outwards. On r = a its derivative is cos θ or
    sin θ cos ψ.
    """
    orders = range(1, TERMS + 1)
    integral = _image_integrals(wavenumber, 2.0 * depth, 2 * TERMS)
    matrix = np.diag([-(s + 1.0) for s in orders]).astype(complex)
    for s in orders:
        for n in orders:
            factor = math.factorial(n - mode) * math.factorial(s + mode)
            matrix[s - 1, n - 1] += s * radius ** (s + n + 1) * integral[n + s] / factor
    right = np.zeros(TERMS, dtype=complex)
    right[0] = 1.0
    return -(1.0 + 3.0 * np.linalg.solve(matrix, right)[0])


def _image_integrals(wavenumber: float, length: float, most: int) -> list[complex]:
    """∫ (k + K)/(k − K) k^N e^{−ck} dk below the pole, for N = 0 … `most`."""
    pole, c = wavenumber, length
    principal = -math.exp(-c * pole) * float(expi(c * pole))  # of k^N e^{−ck}/(k − K)
    found: list[complex] = []
    for power in range(most + 1):
        if power:
            principal = pole * principal + math.factorial(power - 1) / c**power
        residue = 1j * math.pi * pole**power * math.exp(-c * pole)
        found.append(math.factorial(power) / c ** (power + 1) + 2 * pole * (principal + residue))
    return found


def cylinder_forces(
    wavenumber: float,
    *,
    radii: Sequence[float],
    places: Sequence[tuple[float, float]],
    depth: float,
    direction: float = 0.0,
    density: float = 1000.0,
    gravity: float = 9.81,
) -> np.ndarray:
    """Forces along X and Y on each cylinder per wave amplitude, (N, 2) complex [N/m].

    `wavenumber` [1/m], `radii` and `places` [m], water of `depth` [m]; waves towards `direction`
    [rad] whose elevation at (0, 0) is Re e^{−iωt}. One cylinder is that of MacCamy and Fuchs.
    """
    k, count = wavenumber, len(radii)
    orders = np.arange(-TERMS, TERMS + 1)
    size = len(orders)
    matrix = np.eye(count * size, dtype=complex)
    right = np.zeros(count * size, dtype=complex)
    for here in range(count):
        own = slice(here * size, (here + 1) * size)
        x, y = places[here]
        way = np.exp(1j * k * (x * math.cos(direction) + y * math.sin(direction)))
        right[own] = -way * np.exp(1j * orders * (math.pi / 2 - direction))
        for other in range(count):
            if other == here:
                continue
            dx, dy = np.subtract(places[here], places[other])
            differ = orders[None, :] - orders[:, None]  # n − m
            between = hankel1(differ, k * math.hypot(dx, dy))
            turned = np.exp(1j * differ * math.atan2(dy, dx))
            scattered = jvp(orders, k * radii[other]) / h1vp(orders, k * radii[other])
            matrix[own, other * size : (other + 1) * size] = between * turned * scattered
    found = np.linalg.solve(matrix, right).reshape(count, size)
    first, last = found[:, TERMS + 1], found[:, TERMS - 1]  # of n = 1 and −1
    unit = 2j * density * gravity * math.tanh(k * depth) / k**2
    scale = unit / np.array([h1vp(1, k * radius) for radius in radii])
    return np.stack([scale * (first - last), 1j * scale * (first + last)], axis=1)
