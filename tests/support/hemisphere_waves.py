"""Waves on a half-immersed sphere and its mean drift by linear theory, in deep water.

Multipoles of T. H. Havelock, "Waves due to a floating sphere making periodic heaving oscillations",
Proc. R. Soc. A 231 (1955), and A. Hulme, "The wave forces acting on a floating hemisphere
undergoing forced periodic oscillations", J. Fluid Mech. 121 (1982). With c = −z/r and

    T_n = ∫₀^∞ μⁿ e^{μz} J_m(μR) dμ = (n − m)! P_n^m(c)/r^{n+1}

each harmonic cos mψ of the potential, e^{−iωt}, is

    φ = b₀ S + Σ_j b_j (T_n + K T_{n−1}),  n = m + 2j,      S = T_m + K Q_m,
    Q_m = ∫₀^∞ μᵐ e^{μz} J_m(μR)/(μ − K) dμ

on the path below the pole μ = K. All satisfy ∂φ/∂z = K φ at z = 0; S alone sends out waves,
φ → i π K^{m+1} b₀ e^{Kz} H_m⁽¹⁾(KR). The coefficients b fit ∂φ/∂r on r = 1 by least squares.

With A(θ) the amplitude of all waves sent out over that of the incident, η → A η₀ √(2/(πKR))
e^{i(KR − π/4)}, the mean force is that of H. Maruo ("The drift of a body floating on waves", J.
Ship Research 4, 1960)

    F_x = ρ g |η₀|²/(2πK) ∫ |A|² (1 − cos θ) dθ.

Lengths are in radii a, so that K is the wavenumber times a; ρ = g = 1. Nothing here is shared with
the package.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import hankel1, jv, jvp, kv

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
TERMS = 24
NODES = 64  # of Gauss and Legendre in c
STEEP = 0.6  # R over −z up to which the path of Q turns away from the pole
TURN = 0.5  # rad


@cache
def _surface() -> tuple[Floats, Floats]:
    """c and weights, (n,), on the lower half of the sphere."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    return 0.5 * (1.0 + x), 0.5 * w


@cache
def _panels(length: float, count: int) -> tuple[Floats, Floats]:
    """Nodes and weights of an integral from 0 to `length`, denser at 0."""
    x, w = np.polynomial.legendre.leggauss(16)
    edges = length * np.linspace(0.0, 1.0, count + 1) ** 3
    half = 0.5 * np.diff(edges)
    nodes = edges[:-1, None] + half[:, None] * (1.0 + x)
    return nodes.ravel(), (half[:, None] * w).ravel()


def _image(k: float, m: int) -> Complex:
    """Q_m (n,) at the nodes of the surface."""
    c, _ = _surface()
    z, radius = -c, np.sqrt(1.0 - c * c)
    found = np.zeros(len(c), dtype=complex)
    steep = radius <= STEEP * c
    rho, weight = _panels(120.0, 40)
    mu = rho * np.exp(-1j * TURN)
    waves = np.exp(np.outer(z[steep], mu)) * jv(m, np.outer(radius[steep], mu))
    found[steep] = waves @ (weight * np.exp(-1j * TURN) * mu**m / (mu - k))
    z, radius = z[~steep], radius[~steep]
    s, weight = _panels(90.0, 40)
    phase = np.outer(z, s)
    decaying = kv(m, np.outer(radius, s)) * (s * np.sin(phase) - k * np.cos(phase))
    found[~steep] = 2.0 / np.pi * (decaying @ (weight * s**m / (s * s + k * k)))
    found[~steep] += 1j * np.pi * k**m * np.exp(k * z) * hankel1(m, k * radius)
    return found


def _legendre(m: int, most: int, c: Floats) -> Floats:
    """P_n^m(c) without the sign (−1)ᵐ, (most + 1, nodes)."""
    found = np.zeros((most + 1, len(c)))
    found[m] = float(np.prod(np.arange(1, 2 * m, 2))) * (1.0 - c * c) ** (0.5 * m)
    for n in range(m + 1, most + 1):
        found[n] = ((2 * n - 1) * c * found[n - 1] - (n + m - 1) * found[n - 2] * (n > m + 1)) / (
            n - m
        )
    return found


@dataclass(frozen=True)
class Harmonic:
    """The outgoing flow of the harmonic cos mψ for radial velocities on the sphere.

    `potentials`, `velocities` (nodes, terms) are φ and ∂φ/∂r of each multipole on the sphere.
    """

    m: int
    k: float
    potentials: Complex
    velocities: Complex

    def solve(self, velocity: NDArray[np.complex128] | Floats) -> tuple[complex, Complex]:
        """Amplitude a of the wave a H_m⁽¹⁾(KR) e^{Kz}, and φ (nodes,) on the sphere."""
        _, weights = _surface()
        root = np.sqrt(weights)
        scale = np.abs(self.velocities).max(axis=0)
        system = root[:, None] * self.velocities / scale
        strength = np.linalg.lstsq(system, root * velocity, rcond=None)[0] / scale
        wave = 1j * math.pi * self.k ** (self.m + 1) * strength[0]
        return complex(wave), self.potentials @ strength


def harmonic(k: float, m: int) -> Harmonic:
    """The multipoles of one harmonic."""
    c, _ = _surface()
    radius = np.sqrt(1.0 - c * c)
    most = m + 2 * TERMS
    p = _legendre(m, most + 1, c)
    image, above = _image(k, m), _image(k, m + 1)
    source = p[m] + k * image
    along = k * (m * image / radius - above)  # of K Q by R
    upward = k * (p[m] + k * image)  # of K Q by z
    slope = -(m + 1) * p[m] + radius * along - c * upward
    potentials, velocities = [source], [slope]
    for n in range(m + 2, most + 1, 2):
        ratio = k / (n - m)  # (n − 1 − m)!/(n − m)!
        potentials.append(p[n] + ratio * p[n - 1])
        velocities.append(-(n + 1) * p[n] - n * ratio * p[n - 1])
    return Harmonic(m, k, np.array(potentials).T.astype(complex), np.array(velocities).T)


def sent_waves(k: float, *, free: bool) -> Complex:
    """Amplitudes a_m (m,) of all waves that a sphere sends out in a wave φ = e^{Kz + iKx}.

    Held, or free in heave and surge, with the mass of the water that it displaces.
    """
    c, weights = _surface()
    radius, omega = np.sqrt(1.0 - c * c), math.sqrt(k)
    directions = {0: -c, 1: radius}
    stiffness = {0: math.pi, 1: 0.0}
    found = []
    for m in range(math.ceil(k) + 5):
        flow = harmonic(k, m)
        rising = (1 if m == 0 else 2) * 1j**m * np.exp(-k * c)
        incident = rising * jv(m, k * radius)
        normal = k * rising * (radius * jvp(m, k * radius) - c * jv(m, k * radius))
        wave, scattered = flow.solve(-normal)
        if free and m in directions:
            along = (2.0 if m == 0 else 1.0) * math.pi * weights * directions[m]
            radiated, moved = flow.solve(directions[m].astype(complex))
            force = -1j * omega * (along @ (incident + scattered))
            inertia = 2.0 / 3.0 * math.pi - along @ moved
            wave += -1j * omega * force / (stiffness[m] - k * inertia) * radiated
        found.append(wave)
    return np.array(found)


def drift(k: float, *, free: bool) -> float:
    """Mean force F_x/(ρ g a |η₀|²) [1] of waves of the wavenumber K = `k` (times a)."""
    waves = sent_waves(k, free=free)
    order = np.arange(len(waves))
    theta = np.linspace(0.0, 2.0 * math.pi, 8 * len(waves), endpoint=False)
    amplitude = (waves * (-1j) ** order) @ np.cos(np.outer(order, theta))
    mean = np.mean(np.abs(amplitude) ** 2 * (1.0 - np.cos(theta)))
    return float(mean) / k


def added_mass_and_damping(k: float, m: int) -> tuple[float, float]:
    """A/(⅔πρa³) and B/(⅔πρa³ω) [1] of heave (`m` 0) or surge (1)."""
    c, weights = _surface()
    direction = -c if m == 0 else np.sqrt(1.0 - c * c)
    _, moved = harmonic(k, m).solve(direction)
    share = -complex((2.0 - m) * math.pi * weights * direction @ moved) / (2.0 / 3.0 * math.pi)
    return share.real, share.imag
