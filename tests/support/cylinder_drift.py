"""Mean drift of a vertical circular cylinder that stands on the bottom, in closed form.

Potential of R. C. MacCamy and R. A. Fuchs, "Wave forces on piles: a diffraction theory", Beach
Erosion Board Technical Memorandum 69 (1954); the mean force is the integral of the mean pressure of
second order over the wetted cylinder and the strip at its waterline.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import h1vp

from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.panels import grid

STEPS = 400


def cylinder_drift(k: float, *, radius: float, depth: float, density: float, g: float) -> float:
    """F per squared amplitude [N/m2] along waves of the wavenumber `k` [rad/m]."""
    order = np.arange(int(k * radius) + 20)
    rise = np.where(order == 0, 1.0, 2.0) * 1j**order
    rise = rise * 2j / (math.pi * k * radius * h1vp(order, k * radius))
    theta = 2.0 * math.pi / STEPS * np.arange(STEPS)
    elevation = rise @ np.cos(np.outer(order, theta))  # per amplitude, e^{−iωt}, wave to +x
    along = -(rise * order) @ np.sin(np.outer(order, theta)) / radius
    factor = 2.0 * k * depth
    swell = math.sinh(factor) / factor
    over = 0.5 * depth / math.cosh(k * depth) ** 2
    potential = g / (k * math.tanh(k * depth))  # |φ|² per squared elevation: g²/ω²
    square = potential * over
    velocity = np.abs(along) ** 2 * (swell + 1.0) + (k * np.abs(elevation)) ** 2 * (swell - 1.0)
    pressure = 0.25 * density * (square * velocity - g * np.abs(elevation) ** 2)
    return float(pressure @ np.cos(theta)) * 2.0 * math.pi / STEPS * radius


def standing_cylinder(*, radius: float, depth: float, around: int, down: int) -> Hull:
    """The side of the cylinder, of the circle's area, without a bottom; a lid below the surface."""
    turn = 2.0 * math.pi / around
    angles = turn * np.arange(around + 1)
    wider = radius * math.sqrt(turn / math.sin(turn))
    levels = -depth * (1.0 - np.linspace(0.0, 1.0, down + 1) ** 0.75)
    inwards = wider * np.linspace(1.0, 0.0, around // 6 + 1)

    def ring(r: float, z: float, t: float) -> tuple[float, float, float]:
        return r * math.cos(t), r * math.sin(t), z

    side = grid(np.array([[ring(wider, z, t) for z in levels] for t in angles])).merged()
    lid = grid(np.array([[ring(r, -1e-3 * radius, t) for r in inwards] for t in angles])).merged()
    return Hull("pile", side, lid, (0.0, 0.0, -0.5 * depth), hydrostatics_of(side))
