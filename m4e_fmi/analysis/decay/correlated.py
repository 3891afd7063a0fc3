"""Covariance of parameters of a least-squares fit whose residual is correlated in time.

The residual is taken as an autoregressive process. A fit takes out of the noise what looks like a
change of its parameters, just where the spectrum of the noise matters; the process is therefore
that of the greatest restricted likelihood (Patterson and Thompson 1971), found by the EM algorithm:
the noise is the residual plus what the fit may have taken, with its expected squares. Coefficients
are Burg's (1975), their number is that of the smallest Akaike criterion (corrected, Hurvich and
Tsai 1989). Estimates themselves stay those of ordinary least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.linalg import matmul_toeplitz, solve_triangular

Floats = NDArray[np.float64]

MOST = 20
"""Coefficients of a process."""
SAMPLES = 8
"""Samples for each coefficient, at least."""
ROUNDS = 8
"""Of the EM algorithm."""

FLOOR = 1e-2
"""White noise that a residual has at least, over its mean square: one that is predictable, as of a
simulation, would have a process that is nearly unstable, and errors without bound."""
TAKEN = 4.0
"""Squares of noise that a fit may have taken, over those of its residual: of a drift, whose process
wanders off, there is no end otherwise."""


def _longer(own: Floats, reflection: float) -> Floats:
    """Coefficients (n + 1,) [1] with one reflection more than those of `own` (n,)."""
    longer = np.append(own, 0.0)
    return longer + reflection * longer[::-1]


@dataclass(frozen=True)
class Process:
    """e_k + Σ a_j e_{k−j} = white noise of `variance`; `reflections` are those of Burg."""

    reflections: tuple[float, ...]
    variance: float

    @property
    def coefficients(self) -> Floats:
        """1, a_1, a_2, … (order + 1,) [1]."""
        found = np.ones(1)
        for k in self.reflections:
            found = _longer(found, k)
        return found

    def autocovariance(self, count: int) -> Floats:
        """Covariance at lags 0, 1, … (count,), in the square of the noise's unit."""
        k = np.array(self.reflections)
        error = self.variance / float(np.prod(1.0 - k**2))
        found, own = [error], np.ones(1)
        for reflection in k:
            found.append(-reflection * error - float(own[1:] @ found[:0:-1]))
            own = _longer(own, reflection)
            error *= 1.0 - reflection**2
        for _ in range(count - len(found)):
            found.append(-float(own[1:] @ found[: -len(own) : -1]) if len(k) else 0.0)
        return np.array(found[:count])


def covariance(jacobian: Floats, residual: Floats) -> Floats:
    """Covariance (m, m) of the parameters, in their units.

    `jacobian` (n, m) [unit of the residual over those of the parameters] is that of the model,
    `residual` (n,) in any unit. Rows count as equally spaced.
    """
    basis, triangle = np.linalg.qr(jacobian)
    process = _process(basis.T, residual)
    gamma = process.autocovariance(len(residual))
    middle = basis.T @ np.asarray(matmul_toeplitz((gamma, gamma), basis), dtype=float)
    back = np.linalg.inv(triangle)
    return back @ middle @ back.T


def _process(basis: Floats, residual: Floats) -> Process:
    """The process of the noise; `basis` (m, n) is orthonormal and at right angles to `residual`."""
    n = len(residual)
    most = min(MOST, n // SAMPLES)
    first = np.sqrt(np.mean(residual**2)) * basis
    floor = FLOOR * float(np.mean(residual**2))
    process = burg(np.vstack([residual, first]), most, floor=floor)
    for _ in range(ROUNDS):
        signals = np.vstack([residual, basis])
        weights = process.coefficients
        white = sliding_window_view(signals, len(weights), axis=1) @ weights[::-1]
        turned, triangle = np.linalg.qr(white[1:].T)
        change = solve_triangular(triangle, turned.T @ white[0])
        spread = np.sqrt(process.variance) * solve_triangular(triangle, np.eye(len(basis)))
        taken = float(change @ change) + float((spread**2).sum())
        capped = min(1.0, np.sqrt(TAKEN * float(residual @ residual) / taken))
        noise = np.vstack([residual - capped * change @ basis, capped * spread.T @ basis])
        process = burg(noise, most, floor=floor)
    return process


def burg(signals: Floats, most: int, *, floor: float = 0.0) -> Process:
    """The process that several `signals` (k, n) in one unit have in common, of up to `most` terms.

    Its variance is that of their sum, and of white noise of the variance `floor` [unit squared],
    which counts with its expected squares.
    """
    n = signals.shape[1]
    forward = backward = signals
    variance = float((signals**2).sum()) / n + floor
    reflections: list[float] = []
    own = np.ones(1)
    best, least = Process((), variance), np.inf
    for order in range(most + 1):
        criterion = n * np.log(variance) + n * (n + order) / (n - order - 2)
        if criterion < least:
            best, least = Process(tuple(reflections), variance), criterion
        f, b = forward[:, 1:], backward[:, :-1]
        common = float((f * b).sum()) + n * floor * float(own[1:] @ own[:0:-1])
        squares = float((f**2 + b**2).sum()) + 2.0 * n * floor * float(own @ own)
        k = -2.0 * common / squares
        k = min(max(k, 1.0 / n - 1.0), 1.0 - 1.0 / n)  # nothing correlates beyond the record
        forward, backward = f + k * b, b + k * f
        own = _longer(own, k)
        variance *= 1.0 - k**2
        reflections.append(k)
    return best
