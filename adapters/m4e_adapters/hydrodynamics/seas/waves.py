"""Linear long-crested waves: spectra, components of a sea.

The elevation is a sum of components, η(x, t) = Σ a_k cos(ω_k t − k_k x cos β + φ_k), β = 0 or
180 deg. Spectra are those of Hasselmann et al. (1973, JONSWAP) and Bretschneider's two-parameter
form of Pierson and Moskowitz; the amplitudes are scaled so that Σ a_k²/2 = Hs²/16 holds exactly.

A sea is divided into parts of the frequency axis, one component in each. A record of duration T
resolves 2π/T: where parts are wider than that, the scatter of the wave height from record to record
is missing, because it comes from components that interfere. Where the energy is, parts are
therefore narrow: most have equal energy, and n of them show nine tenths of the scatter of records
of n/4 waves. In the tail, which decides the mean periods T01 and T02, parts grow with the frequency
(equal steps of log ω): each is wide, but its component carries little energy.

Directions of the components of a short-crested sea.

Each component has a direction of its own (single summation), so that no two of one frequency have
phases that are fixed to each other: double summation would make a sea that is uneven in space
(D. Miles and E. R. Funke, "A comparison of methods for synthesis of directional seas", Journal of
Offshore Mechanics and Arctic Engineering 111, 1989). The density of Longuet-Higgins, Cartwright and
Smith (1963) is in proportion to cos^2s(Δ/2).

Spectra that are tables, and components of a record.

A spectrum given as a table is linear between its rows; a component of its sea has the energy of its
part of the frequency axis exactly. Parts are chosen as those of `part_edges`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from m4e_adapters.hydrodynamics.seas.water.kinematics import STEPS
from m4e_adapters.hydrodynamics.seas.wave_files import Density, Samples
from m4e_fmi.program import AnyScalar, ScalarLike, exp, log, maximum, sign, sqrt, tanh

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_KNOTS_of_spreading = 20_001  # of the distribution's integral


def spread(count: int, exponent: float, rng: np.random.Generator) -> np.ndarray:
    """Directions (count,) [rad] from the mean one, for components in order of frequency.

    Quantiles of the density at u + k/φ (mod 1), φ the golden ratio, from a random u: any
    neighbouring components have directions that cover the density evenly.
    """
    angle = np.linspace(-math.pi, math.pi, _KNOTS_of_spreading)
    density = np.cos(0.5 * angle) ** (2.0 * exponent)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    share = (rng.random() + GOLDEN * np.arange(count)) % 1.0
    return np.interp(share, integral / integral[-1], angle)


BAND = (0.5, 12.0)  # of the components, in peak frequencies; beyond is 0.4 % of T02
LOGARITHMIC = 0.2  # share of the parts that are equal steps of log ω; the others have equal energy
_KNOTS = 4000  # of the spectrum's integral: energies of parts to 1e-5 of the whole


def recorded_wavenumber(omega: ScalarLike, *, depth: float, gravity: float) -> AnyScalar:
    """As `wavenumber` [rad/m], of one `omega` [rad/s] > 0 that is any scalar."""
    deep = omega * omega * (1.0 / gravity)
    if math.isinf(depth):
        return deep
    target = deep * depth
    y = maximum(sqrt(target), target)
    for _ in range(STEPS):
        t = tanh(y)
        y = y - (y * t - target) / (t + y * (1.0 - t * t))
    return y * (1.0 / depth)


def part_edges(
    peak_omega: float,
    count: int,
    *,
    enhancement: float = 1.0,
) -> np.ndarray:
    """Edges [rad/s], (count + 1,), of the parts of BAND that have one component each."""
    ratio, spectrum = _form(enhancement)
    energy = np.cumsum(np.diff(ratio, prepend=ratio[0]) * spectrum)
    steps = np.linspace(0.0, 1.0, _KNOTS)
    share = (1.0 - LOGARITHMIC) * energy / energy[-1] + LOGARITHMIC * steps
    return peak_omega * np.interp(np.linspace(0.0, 1.0, count + 1), share, ratio)


@lru_cache(maxsize=16)
def _form(enhancement: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies of BAND in peak frequencies, and the spectrum there, (_KNOTS,)."""
    ratio = np.geomspace(*BAND, _KNOTS)
    return ratio, np.array([relative_spectrum(r, enhancement) for r in ratio.tolist()])


def component_frequencies(edges: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Frequencies (n,) [rad/s], one at random in each part between the `edges` (n + 1,) [rad/s].

    Because their differences have no common divisor the sea does not repeat itself.
    """
    return edges[:-1] + np.diff(edges) * rng.random(len(edges) - 1)


def component_phases(count: int, rng: np.random.Generator) -> np.ndarray:
    """Phases (count,) [rad], uniform from 0 to 2π."""
    return rng.uniform(0.0, 2 * math.pi, count)


def relative_spectrum(ratio: ScalarLike, enhancement: ScalarLike) -> AnyScalar:
    """JONSWAP's form at ω/ω_p = `ratio`, peak enhancement γ (1: Pierson-Moskowitz), any scale.

    r⁻⁵ exp(−1.25 r⁻⁴) γ^exp(−(r − 1)²/(2 σ²)), σ = 0.07 below the peak, 0.09 above it.
    """
    width = 0.08 + 0.01 * sign(ratio - 1.0)
    peak = exp(-0.5 * ((ratio - 1.0) / width) ** 2)
    return exp(-1.25 / ratio**4 + log(enhancement) * peak) / ratio**5


def component_amplitudes(
    omega: Sequence[float],
    widths: Sequence[float],
    *,
    significant_height: ScalarLike,
    peak_period: ScalarLike,
    enhancement: ScalarLike,
) -> list[AnyScalar]:
    """Amplitudes [m] of components at `omega` that stand for parts of `widths` [rad/s].

    a² is in proportion to S(ω) Δω, and Σ a²/2 = `significant_height`²/16. Heights in m, periods in
    s; over any scalar of `m4e_fmi.program`.
    """
    weights = [
        float(width) * relative_spectrum(float(w) * peak_period * (0.5 / math.pi), enhancement)
        for w, width in zip(omega, widths, strict=True)
    ]
    total = weights[0]
    for weight in weights[1:]:
        total = total + weight
    scale = significant_height / sqrt(8.0 * total)
    return [scale * sqrt(weight) for weight in weights]


TAPERED = 0.05  # of a record, at each end
NEGLIGIBLE = 1e-8  # of the energy of a record, which may be left out
_KNOTS_of_spectra = 4000  # of a spectrum's parts
_LOWEST = 1e-3  # lower end of the parts over the upper one, if the table begins at 0


def table_edges(spectrum: Density, count: int) -> np.ndarray:
    """Edges [rad/s], (count + 1,), of parts of a spectrum that have one component each."""
    wet = np.flatnonzero(spectrum.density > 0)
    low = spectrum.omega[max(wet[0] - 1, 0)]
    high = spectrum.omega[min(wet[-1] + 1, len(spectrum.omega) - 1)]
    omega = np.geomspace(max(low, _LOWEST * high), high, _KNOTS_of_spectra)
    energy = energy_below(spectrum, omega)
    energy = (energy - energy[0]) / (energy[-1] - energy[0])
    share = (1.0 - LOGARITHMIC) * energy + LOGARITHMIC * np.linspace(0.0, 1.0, _KNOTS_of_spectra)
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
    place = (np.arange(count) + 0.5) / count
    inward = np.minimum(np.minimum(place, 1.0 - place) / TAPERED, 1.0)
    window = 0.5 - 0.5 * np.cos(math.pi * inward)
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
