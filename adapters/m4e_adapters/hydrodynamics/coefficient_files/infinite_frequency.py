"""Added mass at infinite frequency from A(ω) and B(ω), by Ogilvie's relation.

    A∞ = A(ω) + (2/π) PV ∫₀^∞ B(u)/(ω² − u²) du

(T. F. Ogilvie, "Recent progress toward the understanding and prediction of ship motions", 5th
Symposium on Naval Hydrodynamics, 1964.) B is taken as linear between its frequencies, from 0 at
ω = 0, and as falling by ω⁻³ beyond them.
"""

from __future__ import annotations

import numpy as np

USED = (0.1, 0.7)
"""Share of the highest frequency between which A∞ is looked for: below, A varies fast, above, the
unknown tail counts."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def ogilvie(
    omega: np.ndarray, added_mass: np.ndarray, damping: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Median A∞ over the frequencies in USED, (n, n) or (n,) [kg], and its spread, likewise.

    The spread is half of that of the middle 80 %. `omega` (nω,) [rad/s], `added_mass` and `damping`
    (nω, n, n) or (nω, n) [kg] and [kg/s], or any other unit of inertia.
    """
    low, high = (share * omega[-1] for share in USED)
    chosen = np.flatnonzero((omega >= low) & (omega <= high))
    if not len(chosen):
        chosen = np.arange(len(omega))
    found = np.array([added_mass[k] + _integral(omega, damping, k) for k in chosen.tolist()])
    below, middle, above = np.quantile(found, [0.1, 0.5, 0.9], axis=0)
    return middle, 0.5 * (above - below)


def _integral(omega: np.ndarray, damping: np.ndarray, k: int) -> np.ndarray:
    """(2/π) PV ∫ B(u)/(ω² − u²) du at the frequency `k`.

    The logarithm's pole at u = ω is that of both neighbours, with opposite signs: it is left out.
    """
    w = omega[k]
    knots = np.concatenate([[0.0], omega])
    values = np.concatenate([np.zeros((1, *damping.shape[1:])), damping])
    weights = np.zeros(len(knots))
    gap = np.abs(w - knots)
    near = np.log(np.where(gap > 1e-12 * w, gap, 1.0))
    far = np.log(w + knots)
    for j in range(len(knots) - 1):
        step = knots[j + 1] - knots[j]
        logs = near[j + 1] - near[j], far[j + 1] - far[j]
        constant = (logs[1] - logs[0]) / (2 * w)  # ∫ du/(ω² − u²)
        linear = -(logs[0] + logs[1]) / 2  # ∫ u du/(ω² − u²)
        weights[j] += (knots[j + 1] * constant - linear) / step
        weights[j + 1] += (linear - knots[j] * constant) / step
    end = omega[-1]
    s = 0.5 * (_NODES + 1.0)
    if k < len(omega) - 1:
        weights[-1] += end * float(0.5 * _WEIGHTS @ (s**3 / (w**2 * s**2 - end**2)))
    return (2.0 / np.pi) * np.tensordot(weights, values, axes=1)
