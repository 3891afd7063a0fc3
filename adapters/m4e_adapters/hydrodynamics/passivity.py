"""Passive fits: rational matrices of which Re K(jω) has no eigenvalue below zero (less SLACK).

A radiating body can only lose energy. With the poles fixed, K depends linearly on the residues;
each frequency ω and direction v with vᵀ Re K(jω) v < 0 becomes a linear inequality, the least
squares problem is solved again under all of them, and so on until no such pair is left. A small
slack costs nothing and saves much: K falls faster at high frequencies than rational functions can.
The poles that vector fitting finds know nothing of this; they are then moved to where the passive
fit is best, by least squares over them alone (variable projection).
"""

from __future__ import annotations

import numpy as np

from m4e_adapters.hydrodynamics.vector_fitting import (
    Complex,
    basis,
    fitted_poles,
    residues_of,
    stacked,
)

ROUNDS = 20
EVALUATIONS = 25  # of the poles' least squares, derivatives not counted; with many poles fewer
MANY_POLES, FEW_EVALUATIONS = 9, 8
SLOWEST, FASTEST = 2e-3, 20.0  # decay rates of poles, relative to the highest frequency
STEP = 1e-4  # of the poles' logarithms, for derivatives
SLACK = 8e-4  # what Re K may fall below zero, each motion scaled by its largest |K|
TOLERANCE = 1e-5


def passive_fit(
    omega: np.ndarray,
    responses: Complex,
    *,
    weights: np.ndarray,
    order: int,
    grid: np.ndarray,
) -> tuple[Complex, Complex]:
    """Poles (k,) and residues (m, k) of the best passive fit with `order` poles.

    Arguments as those of `fitted_poles` and `passive_combination`.
    """
    from scipy.optimize import least_squares

    start = fitted_poles(omega, responses, weights=weights, order=order)
    pairs = start.imag > 0

    def combination(poles: Complex) -> np.ndarray:
        return passive_combination(omega, responses, weights=weights, poles=poles, grid=grid)

    def misfit(logarithms: np.ndarray) -> np.ndarray:
        poles = _poles(logarithms, pairs)
        fitted = combination(poles) @ basis(omega, poles).T
        return stacked(((fitted - responses) * weights).T).ravel()

    lowest, highest = np.log(SLOWEST * omega.max()), np.log(FASTEST * omega.max())
    bounds = (np.where(np.arange(order) < len(start), lowest, -np.inf), highest)
    inside = np.clip(_logarithms(start), bounds[0] + STEP, highest - STEP)
    most = EVALUATIONS if order < MANY_POLES else FEW_EVALUATIONS
    found = least_squares(misfit, inside, bounds=bounds, max_nfev=most, diff_step=STEP)
    poles = _poles(found.x, pairs)
    return poles, residues_of(poles, combination(poles))


def _logarithms(poles: Complex) -> np.ndarray:
    """ln(−Re p) of all poles, then ln(Im p) of the pairs."""
    return np.log(np.concatenate([-poles.real, poles.imag[poles.imag > 0]]))


def _poles(logarithms: np.ndarray, pairs: np.ndarray) -> Complex:
    values = np.exp(logarithms)
    imaginary = np.zeros(len(pairs))
    imaginary[pairs] = values[len(pairs) :]
    return -values[: len(pairs)] + 1j * imaginary


def passive_combination(
    omega: np.ndarray,
    responses: Complex,
    *,
    weights: np.ndarray,
    poles: Complex,
    grid: np.ndarray,
) -> np.ndarray:
    """Real coefficients (m, order) of `basis` for the upper triangle of a symmetric matrix.

    Parameters
    ----------
    omega, weights : (n,) as in `fitted_poles`.
    responses : (m, n), the pairs (i, j ≥ i) row by row.
    grid : (g,) angular frequencies [rad/s] at which the matrix shall be passive.
    """
    pairs = len(responses)
    columns = stacked(basis(omega, poles) * weights[:, None])
    scale = np.linalg.norm(columns, axis=0)
    q, r = np.linalg.qr(columns / scale)
    target = stacked((responses * weights).T).T @ q  # (m, order), least squares: r x = target
    inverse = np.linalg.inv(r)
    size = int(np.sqrt(2 * pairs))
    rows, cols = np.triu_indices(size)
    twice = np.where(rows == cols, 1.0, 2.0)
    on_grid = basis(grid, poles).real / scale @ inverse  # Re K on the grid per unit of r x
    constraints: list[np.ndarray] = []
    solution = target
    for _ in range(ROUNDS):
        matrix = np.zeros((len(grid), size, size))
        matrix[:, rows, cols] = matrix[:, cols, rows] = on_grid @ solution.T
        values, vectors = np.linalg.eigh(matrix)
        violated = _worst(values[:, 0])
        if not len(violated):
            break
        for k in violated:
            v = vectors[k, :, 0]
            constraints.append(np.outer(twice * v[rows] * v[cols], on_grid[k]).ravel())
        step = _nearest(np.array(constraints), target.ravel())
        solution = target + step.reshape(target.shape)
    return solution @ inverse.T / scale


def _worst(values: np.ndarray) -> np.ndarray:
    """Indices of the local minima below zero."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    lowest = (values <= padded[:-2]) & (values <= padded[2:])
    return np.flatnonzero(lowest & (values < -SLACK - TOLERANCE))


def _nearest(constraints: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The shortest z with constraints·(point + z) ≥ −SLACK (Lawson and Hanson's LDP, by NNLS)."""
    from scipy.optimize import nnls

    length = np.linalg.norm(constraints, axis=1)
    normals = constraints / length[:, None]
    missing = -normals @ point - SLACK / length
    system = np.concatenate([normals.T, missing[None, :]])
    wanted = np.zeros(len(system))
    wanted[-1] = 1.0
    factors, _ = nnls(system, wanted)
    residual = system @ factors - wanted
    return -residual[:-1] / residual[-1]
