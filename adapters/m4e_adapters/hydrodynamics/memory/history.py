"""The past velocity as a polynomial: states that know what a motion did in the last T seconds.

With w(t, τ) = v(t − τ), 0 ≤ τ ≤ T, the past moves on as ∂w/∂t = −∂w/∂τ, and w(t, 0) = v(t). As
w = Σ xₙ(t) Pₙ(2 τ/T − 1), Legendre's polynomials, and in the mean over each of these,

    T/(2n + 1) ẋₙ = (−1)ⁿ v − Σₘ xₘ + 2 Σ xₘ over m < n with n − m odd

(a discontinuous Galerkin method with one element). A convolution ∫₀ᵀ K(τ) v(t − τ) dτ is then
Σ kₙ xₙ, kₙ = ∫₀ᵀ K Pₙ dτ. The states cannot grow by themselves: y = Σ T xₙ²/(2n + 1), the integral
of w² over the past, has ẏ ≤ v².
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

NODES = 16  # of Gauss in each piece of an integral
PHASE = 10.0  # rad that a wave has in such a piece, at most


def quadrature(duration: float, highest: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and weights (n,) [s] for integrals over `duration` [s] of K(t) times a wave.

    `highest` [rad/s] is the frequency of the wave.
    """
    pieces = 1 + int(duration * highest / PHASE)
    places, weights = leggauss(NODES)
    step = duration / pieces
    times = step * (np.arange(pieces)[:, None] + 0.5 * (1.0 + places))
    return times.ravel(), np.tile(0.5 * step * weights, pieces)


def projected(
    times: np.ndarray, weighted: np.ndarray, *, duration: float, count: int
) -> np.ndarray:
    """kₙ (count, m, m) [N.s/m, N.s, N.m.s] of the polynomials.

    `weighted` (n, m, m) [N.s/m, N.s, N.m.s] is K times the weights of `quadrature` at its `times`
    (n,) [s].
    """
    polynomials = legvander(2.0 * times / duration - 1.0, count - 1)
    return np.tensordot(polynomials.T, weighted, axes=1)


def responses(omega: np.ndarray, *, duration: float, count: int) -> np.ndarray:
    """xₙ (nω, count) [1] for v = e^{jωt} at `omega` (nω,) [rad/s]."""
    triangle, basis, drive = _triangular(count)
    found = np.zeros((count, len(omega)), dtype=complex)
    for k in range(count - 1, -1, -1):
        known = drive[k] + triangle[k, k + 1 :] @ found[k + 1 :]
        found[k] = known / (1j * omega * duration - triangle[k, k])
    return (basis @ found).T


@lru_cache(maxsize=8)
def _triangular(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The equations for T = 1 s in a basis in which they are triangular, [1/s]."""
    from scipy.linalg import schur

    n = np.arange(count)
    later = np.subtract.outer(n, n)
    rate = 2.0 * n + 1.0
    matrix = rate[:, None] * np.where((later > 0) & (later % 2 == 1), 1.0, -1.0)
    found = schur(matrix, output="complex")
    triangle, basis = found[0], found[1]
    return triangle, basis, basis.conj().T @ (rate * (-1.0) ** n)
