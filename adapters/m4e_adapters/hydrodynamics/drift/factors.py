"""Sums over pairs of waves as squares of sums over waves.

A Hermitian matrix of QTFs is Q = Σ_r λ_r u_r u_rᴴ, so that the force is

    F = Σ_r λ_r |Σ_i a_i u_r(ω_i) e^{−iθ_i}|²

with as many terms r as Q has eigenvalues that matter. Between the frequencies of the file the u_r
are linear, Q bilinear. Small QTFs count as large ones: eigenvalues are those of Q_ij/(s_i s_j),
with s_i² the largest modulus in row i, and the rest that is left out is below `LEFT_OUT` of it
(Frobenius norms).

Newman's approximation Q_ij = ±√(D_i D_j), 0 where the signs differ, has one term for each sign.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

LEFT_OUT = 1e-3  # of the norm of the scaled QTFs
SMALLEST = 1e-3  # scale of a row over the largest


@dataclass(frozen=True)
class Factors:
    """`values` λ (r,) [1] and `shapes` u (nω, r) [√(N/m2), √(N.m/m2)] of one QTF."""

    values: np.ndarray
    shapes: np.ndarray = field(repr=False)

    @property
    def matrix(self) -> np.ndarray:
        """Σ λ u uᴴ, (nω, nω) [N/m2, N.m/m2]."""
        return (self.shapes * self.values) @ self.shapes.conj().T


def factorised(qtf: np.ndarray) -> Factors:
    """Factors of a Hermitian `qtf` (nω, nω) [N/m2, N.m/m2], without `LEFT_OUT` of it."""
    squares = np.abs(qtf).max(axis=1)
    if not squares.any():
        return Factors(np.zeros(0), np.zeros((len(qtf), 0), dtype=complex))
    scales = np.sqrt(np.maximum(squares, SMALLEST**2 * squares.max()))
    values, shapes = np.linalg.eigh(qtf / np.outer(scales, scales))
    order = np.argsort(-np.abs(values))
    values, shapes = values[order], shapes[:, order]
    rest = np.sqrt(np.maximum(np.cumsum(values[::-1] ** 2)[::-1], 0.0))
    kept = int(np.sum(rest > LEFT_OUT * rest[0]))
    return Factors(values[:kept], scales[:, None] * shapes[:, :kept])
