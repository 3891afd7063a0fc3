"""Vector fitting: stable rational functions with common poles through frequency responses.

H_m(s) ≈ Σ_k r_mk / (s − p_k) (+ s·δ_m), poles real or in conjugate pairs. The poles are found by
Gustavsen and Semlyen's relocation (IEEE Trans. Power Delivery 14(3), 1999): a common scaling
function σ with the same poles is fitted with the responses, its zeros are the next poles; those on
the right half plane are mirrored to the left. Responses are reduced one by one by QR (Deschrijver
et al., IEEE Microw. Wirel. Compon. Lett. 18(6), 2008).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complexfloating]

ITERATIONS = 24


@dataclass(frozen=True)
class Samples:
    """Responses at frequencies, to be fitted.

    Attributes
    ----------
    omega : (n,) angular frequencies [rad/s] ≥ 0.
    values : (m, n) complex, at s = jω.
    weights : (m, 2 n) ≥ 0 of the errors of the real parts, then of the imaginary ones.
    offset : True if each response may have a part s·δ, which has no memory.
    """

    omega: np.ndarray
    values: Complex
    weights: np.ndarray
    offset: bool

    def columns(self, poles: Complex) -> np.ndarray:
        """Real, then imaginary parts of `basis`, (2·n, order), SI; with `offset` also of s.

        `poles` (k,) [1/s].
        """
        found = stacked(basis(self.omega, poles))
        if not self.offset:
            return found
        return np.column_stack([found, stacked(1j * self.omega)])


def fitted_poles(samples: Samples, *, order: int) -> Complex:
    """The common poles (k,) [1/s], Re < 0, pairs counting two; of each the one with Im > 0."""
    low, high = samples.omega[samples.omega > 0].min(), samples.omega.max()
    imaginary = np.linspace(low, 0.8 * high, order // 2) if order > 1 else np.zeros(0)
    poles = imaginary * (-0.2 + 1j)
    if order % 2:
        poles = np.concatenate([poles, [-0.5 * (low + high)]])
    for _ in range(ITERATIONS):
        poles = _relocated(samples, poles)
    return poles


def evaluate(omega: np.ndarray, poles: Complex, residues: Complex) -> Complex:
    """Σ r/(jω − p) over all poles, conjugates included, (..., n), SI.

    `omega` (n,) [rad/s], `poles` (k,) [1/s], one of each pair, `residues` (..., k), SI.
    """
    s = 1j * np.asarray(omega)
    result = np.zeros((*residues.shape[:-1], len(s)), dtype=complex)
    for k, pole in enumerate(poles):
        result += residues[..., k, None] / (s - pole)
        if pole.imag > 0:
            result += residues[..., k, None].conj() / (s - pole.conj())
    return result


def basis(omega: np.ndarray, poles: Complex) -> Complex:
    """Columns whose real combinations are all sums of partial fractions, (n, order) [s].

    `omega` (n,) [rad/s], `poles` (k,) [1/s].
    """
    s = 1j * omega
    columns = []
    for pole in poles:
        if pole.imag > 0:
            first, second = 1 / (s - pole), 1 / (s - pole.conj())
            columns += [first + second, 1j * (first - second)]
        else:
            columns.append(1 / (s - pole.real))
    return np.stack(columns, axis=1)


def stacked(values: Complex) -> np.ndarray:
    """Real, then imaginary parts (2 n, ...) of `values` (n, ...), in the values' unit."""
    return np.concatenate([values.real, values.imag])


def _relocated(samples: Samples, poles: Complex) -> Complex:
    """Zeros of σ(s) = 1 + Σ c_k/(s − p_k) when σ·H is fitted with the same poles."""
    own = basis(samples.omega, poles)
    columns = samples.columns(poles)
    count = columns.shape[1]
    rows, values = [], []
    for response, weights in zip(samples.values, samples.weights, strict=True):
        system = np.column_stack([columns, -stacked(own * response[:, None])]) * weights[:, None]
        q, r = np.linalg.qr(system)
        rows.append(r[count:, count:])
        values.append(q[:, count:].T @ (weights * stacked(response)))
    system = np.concatenate(rows)
    size = np.linalg.norm(system, axis=0)
    size = np.where(size > 0, size, 1.0)
    scaled, *_ = np.linalg.lstsq(system / size, np.concatenate(values), rcond=None)
    zeros = np.linalg.eigvals(companion(poles) - np.outer(inputs(poles), scaled / size))
    least = 1e-9 * np.maximum(np.abs(zeros), samples.omega.max())
    stable = -np.abs(zeros.real) - least + 1j * zeros.imag
    real = np.abs(stable.imag) < 1e-9 * np.abs(stable)
    stable[real] = stable[real].real
    return stable[stable.imag >= 0]


def companion(poles: Complex) -> np.ndarray:
    """Block-diagonal matrix (order, order) [1/s] with the eigenvalues `poles` (k,) [1/s]."""
    blocks = []
    for pole in poles:
        if pole.imag > 0:
            blocks.append(np.array([[pole.real, pole.imag], [-pole.imag, pole.real]]))
        else:
            blocks.append(np.array([[pole.real]]))
    size = sum(len(block) for block in blocks)
    result, at = np.zeros((size, size)), 0
    for block in blocks:
        result[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return result


def inputs(poles: Complex) -> np.ndarray:
    """Factors (order,) [1] of an input in the states of `companion`; `poles` (k,) [1/s]."""
    return np.concatenate([[2.0, 0.0] if pole.imag > 0 else [1.0] for pole in poles])


def residues_of(poles: Complex, combination: np.ndarray) -> Complex:
    """Residues (..., k) of a real `combination` (..., order) of the columns of `basis`, SI.

    `poles` (k,) [1/s].
    """
    residues = np.zeros((*combination.shape[:-1], len(poles)), dtype=complex)
    at = 0
    for k, pole in enumerate(poles):
        residues[..., k] = combination[..., at]
        if pole.imag > 0:
            residues[..., k] += 1j * combination[..., at + 1]
        at += 2 if pole.imag > 0 else 1
    return residues
