"""The heaving half-immersed sphere of IEA OES Task 10 by exact linear theory, in deep water.

Added mass A and damping B are those of the multipole solution (Havelock 1955, Hulme 1982), the
modulus of the excitation follows from B by Haskind's relation for a body of revolution,
|X|² = 2 ρ g³ B/ω³. Cummins' equation of the decay from rest at a height h has the transform
Z = h (jω (m + A∞) + K)/(k − ω² (m + A∞) + jω K), K = B + jω (A − A∞), and
z(t) = (2/π) ∫ Re Z cos ωt dω.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Floats = NDArray[np.float64]
TABLE = Path(__file__).parents[1] / "data" / "hydrodynamics" / "hemisphere_heave.csv"
DENSITY, GRAVITY, RADIUS, MASS = 1000.0, 9.81, 5.0, 261.8e3
DISPLACED = 2.0 / 3.0 * np.pi * DENSITY * RADIUS**3
STIFFNESS = DENSITY * GRAVITY * np.pi * RADIUS**2
AT_ZERO, AT_INFINITY = 0.8310, 0.5  # added mass over displaced mass at ω = 0 and ∞


def added_mass_and_damping(omega: Floats) -> tuple[Floats, Floats]:
    """A [kg] and B [N.s/m], (n,), at `omega` (n,) [rad/s] up to k a = 10."""
    ka, mass, damping = np.loadtxt(TABLE, delimiter=",").T
    place = omega**2 * RADIUS / GRAVITY
    added = CubicSpline([0.0, *ka], [AT_ZERO, *mass])(place)
    return DISPLACED * added, DISPLACED * omega * CubicSpline([0.0, *ka], [0.0, *damping])(place)


def impedance(omega: Floats, damping: Floats | float = 0.0) -> NDArray[np.complex128]:
    """Force over velocity, complex, (n,) [N.s/m], with a damper [N.s/m] beside the water."""
    added, radiated = added_mass_and_damping(omega)
    return radiated + damping + 1j * (STIFFNESS / omega - omega * (MASS + added))


def heave(omega: Floats, damping: Floats | float = 0.0) -> Floats:
    """Amplitude of heave over that of the waves, (n,) [m/m]."""
    _, radiated = added_mass_and_damping(omega)
    excitation = np.sqrt(2 * DENSITY * GRAVITY**3 * radiated / omega**3)
    return excitation / np.abs(omega * impedance(omega, damping))


def decay(times: Floats) -> Floats:
    """Height over that of the release, (n,) [1], at `times` (n,) [s]."""
    omega = np.linspace(1e-4, np.sqrt(10.0 * GRAVITY / RADIUS), 20001)
    added, damping = added_mass_and_damping(omega)
    s, inertia = 1j * omega, MASS + AT_INFINITY * DISPLACED
    memory = damping + s * (added - AT_INFINITY * DISPLACED)
    transform = (s * inertia + memory) / (STIFFNESS + s**2 * inertia + s * memory)
    weights = np.full(omega.size, omega[1] - omega[0])
    weights[[0, -1]] *= 0.5
    return 2 / np.pi * np.cos(np.outer(times, omega)) @ (weights * transform.real)
