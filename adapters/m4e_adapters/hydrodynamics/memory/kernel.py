"""The radiation memory K(t) of coupled motions from their damping: T. F. Ogilvie's (1964)

    K(t) = (2/π) ∫₀^∞ B(ω) cos ωt dω.

B is a cubic spline through its data, less what is negative in them, and 0 at ω = 0; beyond the last
of them it falls as a mean of powers ω⁻ᵖ, that with which A(ω) − A∞ is most nearly what K says.

The past velocity as a polynomial: states that know what a motion did in the last T seconds.

With w(t, τ) = v(t − τ), 0 ≤ τ ≤ T, the past moves on as ∂w/∂t = −∂w/∂τ, and w(t, 0) = v(t). As
w = Σ xₙ(t) Pₙ(2 τ/T − 1), Legendre's polynomials, and in the mean over each of these,

    T/(2n + 1) ẋₙ = (−1)ⁿ v − Σₘ xₘ + 2 Σ xₘ over m < n with n − m odd

(a discontinuous Galerkin method with one element). A convolution ∫₀ᵀ K(τ) v(t − τ) dτ is then
Σ kₙ xₙ, kₙ = ∫₀ᵀ K Pₙ dτ. The states cannot grow by themselves: y = Σ T xₙ²/(2n + 1), the integral
of w² over the past, has ẏ ≤ v².
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

from m4e_adapters.hydrodynamics.memory.group_fit import GroupData

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


GAUSS = 6  # of Gauss in each step of the frequencies, which spans at most half a wave of cos ωt
POWERS = (2, 3, 5, 9)  # of the tail; that of a wall's surge is 3, of a half-ball's heave 7
FIRM = 1e3  # weight of the tail's first value against those of A


@dataclass(frozen=True)
class Kernel:
    """K(t) of m motions.

    Attributes
    ----------
    nodes : (k,) [rad/s], those of a quadrature over the data.
    damping : (k, m, m) [N.s/m, N.s, N.m.s], B there times the weights of the quadrature [rad/s].
    end : frequency [rad/s] where the tail begins.
    last : (m, m) [N.s/m, N.s, N.m.s], B there, that of the tail.
    longest : time [s] up to which the frequencies, by their spacing, tell the memory.
    shares : (4,) of POWERS in the tail [1], together 1.
    """

    nodes: np.ndarray
    damping: np.ndarray
    end: float
    last: np.ndarray
    longest: float
    shares: np.ndarray

    @classmethod
    def of(cls, data: GroupData) -> Kernel:
        """The kernel of the trusted data, with the tail that agrees best with A(ω)."""
        from scipy.interpolate import CubicSpline

        trusted = data.known.all(axis=1)
        omega = np.append(0.0, data.omega[trusted])
        values = _positive(data.damping[trusted], data.scale)
        half = 0.5 * np.diff(omega)
        places, weights = np.polynomial.legendre.leggauss(GAUSS)
        nodes = (omega[:-1, None] + half[:, None] * (1.0 + places)).ravel()
        spline = CubicSpline(omega, np.concatenate([np.zeros_like(values[:1]), values]))
        plain = cls(
            nodes=nodes,
            damping=spline(nodes) * (half[:, None] * weights).reshape(-1, 1, 1),
            end=float(omega[-1]),
            last=values[-1],
            longest=np.pi / float(np.median(2.0 * half)),
            shares=np.eye(len(POWERS))[0],
        )
        return replace(plain, shares=plain._best_shares(data))

    def at(self, time: np.ndarray) -> np.ndarray:
        """K (n, m, m) [N/m, N, N.m] at `time` (n,) [s] ≥ 0."""
        tail = (2.0 / np.pi) * (self._tails(time) @ self.shares)[:, None, None] * self.last
        return self._of_data(time) + tail

    def _of_data(self, time: np.ndarray) -> np.ndarray:
        waves = np.cos(np.outer(time, self.nodes))
        return (2.0 / np.pi) * np.tensordot(waves, self.damping, axes=1)

    def _tails(self, time: np.ndarray) -> np.ndarray:
        """∫ (end/ω)ᵖ cos ωt dω from the end on, (n, 4) [rad/s], at `time` (n,) [s]."""
        from scipy.special import exp1

        z = 1j * np.maximum(self.end * time, 1e-9)
        found = [exp1(z)]
        for k in range(1, max(POWERS)):
            found.append((np.exp(-z) - z * found[-1]) / k)
        return self.end * np.stack([found[p - 1].real for p in POWERS], axis=1)

    def _best_shares(self, data: GroupData) -> np.ndarray:
        """Those of the tail with which A(ω) − A∞ is most nearly what B says; with another A∞ if
        that halves the difference.
        """
        from scipy.optimize import nnls

        time = np.linspace(0.0, self.longest, 1 + 4 * int(self.longest * self.end))
        steps = np.full(len(time), time[1])
        steps[[0, -1]] *= 0.5
        trusted = data.known.all(axis=1)
        omega = data.omega[trusted]
        waves = np.sin(np.outer(omega, time)) * steps / omega[:, None]
        size = np.sqrt(np.outer(data.inertia, data.inertia))[data.rows, data.columns]

        def upper(mass: np.ndarray) -> np.ndarray:
            """Values (n, pairs) [1] over A∞."""
            return mass[:, data.rows, data.columns] / size

        rest = upper(data.added_mass[trusted] + np.tensordot(waves, self._of_data(time), axes=1))
        own = -(2.0 / np.pi) * waves @ self._tails(time)
        tails = np.stack([upper(t[:, None, None] * self.last) for t in own.T], axis=-1)

        def fitted(wanted: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, float]:
            matrix = columns.reshape(-1, len(POWERS))
            firm = np.full((1, len(POWERS)), FIRM)
            shares, error = nnls(np.vstack([matrix, firm]), np.append(wanted.ravel(), FIRM))
            return shares / shares.sum(), error

        given = fitted(rest, tails)
        other = fitted(rest - rest.mean(axis=0), tails - tails.mean(axis=0))
        return (other if other[1] < given[1] / 2 else given)[0]


def _positive(matrices: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Symmetric `matrices` (n, m, m) without their negative parts; `scale` (m, m) is their unit."""
    values, vectors = np.linalg.eigh(matrices / scale)
    return (vectors * np.maximum(values, 0.0)[:, None]) @ vectors.swapaxes(1, 2) * scale
