"""Spectra other than JONSWAP in deep water, and components of a record.

A spectrum given as a table is linear between its rows; a component of its sea has the energy of its
part of the frequency axis exactly. Parts are chosen as those of `waves.part_edges`.
"""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_adapters.hydrodynamics.seas.wave_files import Density, Samples
from m4e_adapters.hydrodynamics.seas.waves import LOGARITHMIC

TAPERED = 0.05  # of a record, at each end
NEGLIGIBLE = 1e-8  # of the energy of a record, which may be left out
_KNOTS = 4000  # of a spectrum's parts
_LOWEST = 1e-3  # lower end of the parts over the upper one, if the table begins at 0


def depth_factor(omega: np.ndarray, *, depth: float, gravity: float) -> np.ndarray:
    """tanh² kh/(1 + 2kh/sinh 2kh) of waves of `omega` (n,) [rad/s], (n,) [1].

    By it Bouws, Günther, Rosenthal and Vincent, "Similarity of the wind wave spectrum in finite
    depth water", Journal of Geophysical Research 90, 1985, change JONSWAP to TMA, after
    Kitaigorodskii, Krasitskii and Zaslavskii (1975).
    """
    kh = wavenumber(omega, depth=depth, gravity=gravity) * depth
    return np.tanh(kh) ** 2 / (1.0 + 2.0 * kh / np.sinh(np.minimum(2.0 * kh, 700.0)))


def table_edges(spectrum: Density, count: int) -> np.ndarray:
    """Edges [rad/s], (count + 1,), of parts of a spectrum that have one component each."""
    wet = np.flatnonzero(spectrum.density > 0)
    low = spectrum.omega[max(wet[0] - 1, 0)]
    high = spectrum.omega[min(wet[-1] + 1, len(spectrum.omega) - 1)]
    omega = np.geomspace(max(low, _LOWEST * high), high, _KNOTS)
    energy = energy_below(spectrum, omega)
    energy = (energy - energy[0]) / (energy[-1] - energy[0])
    share = (1.0 - LOGARITHMIC) * energy + LOGARITHMIC * np.linspace(0.0, 1.0, _KNOTS)
    edges = np.interp(np.linspace(0.0, 1.0, count + 1), share, omega)
    edges[0] = low
    return edges


def energy_below(spectrum: Density, omega: np.ndarray) -> np.ndarray:
    """∫₀^ω S dω (n,) [m2] of `omega` (n,) [rad/s]."""
    w, s = spectrum.omega, spectrum.density
    total = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(w) * (s[1:] + s[:-1]))])
    at = np.clip(omega, w[0], w[-1])
    k = np.clip(np.searchsorted(w, at, side="right") - 1, 0, len(w) - 2)
    return total[k] + 0.5 * (at - w[k]) * (s[k] + np.interp(at, w, s))


def record_components(record: Samples) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """ω (n,) [rad/s], amplitudes (n,) [m] and phases (n,) [rad] at t = 0 of a record at its place.

    Its discrete Fourier transform, mean left out, ends tapered by half cosines. What has less than
    1e-8 of the energy is left out.
    """
    count = len(record.elevation)
    window = _window(count)
    level = float(window @ record.elevation / window.sum())
    found = np.fft.rfft(window * (record.elevation - level))[1:]
    amplitude = 2.0 * np.abs(found) / count
    if count % 2 == 0:
        amplitude[-1] /= 2.0
    omega = 2.0 * math.pi / (count * record.interval) * np.arange(1, len(found) + 1)
    phase = np.angle(found) - omega * record.start
    order = np.argsort(amplitude)
    energy = np.cumsum(amplitude[order] ** 2)
    kept = np.sort(order[np.searchsorted(energy, NEGLIGIBLE * energy[-1]) :])
    return omega[kept], amplitude[kept], phase[kept]


def _window(count: int) -> np.ndarray:
    """1 in the middle, falling to 0 within `TAPERED` of each end, (count,)."""
    place = (np.arange(count) + 0.5) / count
    inward = np.minimum(np.minimum(place, 1.0 - place) / TAPERED, 1.0)
    return 0.5 - 0.5 * np.cos(math.pi * inward)
