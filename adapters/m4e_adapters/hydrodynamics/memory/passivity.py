"""Passive fits: rational matrices of which Re K(jω) is positive definite at every frequency.

A radiating body can only lose energy. With the poles fixed, K depends linearly on the residues;
each frequency ω and direction v with vᵀ Re K(jω) v < 0 becomes a linear inequality, and the least
squares problem is solved again under all of them, until no such pair is left on a grid. Between its
points and beyond, up to ω = ∞, a proof decides: Re K(jω) is singular just where the pencil

    | A   0   B  |       | 1 0 0 |
    | 0  −Aᵀ −Cᵀ |  − s  | 0 1 0 | ,     K(s) = C (s − A)⁻¹ B,
    | C   Bᵀ  0  |       | 0 0 0 |

has the eigenvalue s = jω (the Hamiltonian test of Boyd, Balakrishnan and Kabamba, 1989, for K + K*
without a direct part). Where it has such eigenvalues, the worst frequency between two of them
joins the inequalities; where it has none, Re K is of one sign, and that is the sign on the grid.

The poles that vector fitting finds know nothing of this; they are moved to where the passive fit
is best, by least squares over them alone (variable projection).
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.memory.vector_fitting import (
    Complex,
    Samples,
    basis,
    companion,
    evaluate,
    fitted_poles,
    inputs,
    residues_of,
    stacked,
)

ROUNDS = 60  # of inequalities that are added
SLOWEST, FASTEST = 2e-3, 20.0  # decay rates of poles, relative to the highest frequency
LEAST_DECAY = 0.03  # of a pole, over its magnitude: slower ones are irregular frequencies
STEP = 1e-4  # of the poles' logarithms, for derivatives
MARGIN = 3e-5
"""Least eigenvalue of (1 + ω²/ω₁²) Re K that is asked for, each motion scaled by its largest B: a
body in steady motion feels this share of it."""
ACCEPTED = 1e-6  # likewise, what a fit is content with
ON_AXIS = 1e-6
"""|Re s| over |s| or the largest pole below which an eigenvalue of the pencil may be some jω: what
is looked at for nothing costs little."""
BETWEEN = 12  # points looked at between two singular frequencies


class UnprovenError(Exception):
    """No passive fit was found with these poles."""


@dataclass(frozen=True)
class Fit:
    """`poles` (k,) [1/s], `residues` (m, k) of the upper triangle, `offset` (m,): the part s·δ."""

    poles: Complex
    residues: Complex
    offset: np.ndarray


class Inequalities:
    """Frequencies `omega` [rad/s] and `directions` (m,) in which Re K must not be negative."""

    def __init__(self) -> None:
        self.omega: list[float] = []
        self.directions: list[np.ndarray] = []

    def add(self, omega: np.ndarray, values: np.ndarray, vectors: np.ndarray) -> None:
        """Add the eigenvectors whose value is too small.

        `omega` (n,) [rad/s]; `values` (n, m) and `vectors` (n, m, m), scaled by the largest B [1].
        """
        for k, e in np.argwhere(values < ACCEPTED):
            self.omega.append(float(omega[k]))
            self.directions.append(vectors[k, :, e])

    def keep(self, chosen: np.ndarray) -> None:
        """Keep only the `chosen` (n_inequalities,), booleans."""
        self.omega = [w for w, one in zip(self.omega, chosen, strict=True) if one]
        self.directions = [v for v, one in zip(self.directions, chosen, strict=True) if one]


def passive_fit(samples: Samples, *, order: int, evaluations: int) -> Fit:
    """The best passive fit with `order` poles; UnprovenError if there is none.

    `samples` are the upper triangle of a symmetric matrix, row by row, each motion scaled so that
    its largest B is 1. `evaluations` of the poles' least squares at most, derivatives not counted.
    """
    poles = fitted_poles(samples, order=order)
    poles = np.minimum(poles.real, -LEAST_DECAY * np.abs(poles)) + 1j * poles.imag
    known = Inequalities()  # those of one fit serve the next, whose poles are nearly the same
    with contextlib.suppress(UnprovenError):  # those of vector fitting may do
        poles = _moved(samples, poles, known, evaluations)
    return _Combinations(samples, poles).best(known, proven=True)


def _moved(samples: Samples, start: Complex, known: Inequalities, evaluations: int) -> Complex:
    from scipy.optimize import least_squares

    pairs = start.imag > 0
    order = len(start) + int(pairs.sum())

    def misfit(logarithms: np.ndarray) -> np.ndarray:
        fit = _Combinations(samples, _poles(logarithms, pairs)).best(known, proven=False)
        found = evaluate(samples.omega, fit.poles, fit.residues)
        found = found + 1j * samples.omega * fit.offset[:, None]
        return (stacked((found - samples.values).T).T * samples.weights).ravel()

    highest = samples.omega.max()
    slowest, fastest = np.log(SLOWEST * highest), np.log(FASTEST * highest)
    bounds = (np.where(np.arange(order) < len(start), slowest, -np.inf), fastest)
    logarithms = np.log(np.concatenate([-start.real, start.imag[pairs]]))  # of −Re p, then Im p
    inside = np.clip(logarithms, bounds[0] + STEP, fastest - STEP)
    found = least_squares(misfit, inside, bounds=bounds, max_nfev=evaluations, diff_step=STEP)
    return _poles(found.x, pairs)


def _poles(logarithms: np.ndarray, pairs: np.ndarray) -> Complex:
    values = np.exp(logarithms)
    imaginary = np.zeros(len(pairs))
    imaginary[pairs] = values[len(pairs) :]
    return -values[: len(pairs)] + 1j * imaginary


class _Combinations:
    """Combinations of partial fractions with given poles, in coordinates of the least squares.

    The weighted error of response m is |z_m − target_m|, but for what no combination can mend; its
    coefficients, of the columns of `basis` and of the offset, are `back`_m z_m.
    """

    def __init__(self, samples: Samples, poles: Complex) -> None:
        self.samples, self.poles = samples, poles
        self.order = len(inputs(poles))
        self.size = int(np.sqrt(2 * len(samples.values)))
        self.rows, self.columns = np.triu_indices(self.size)
        columns = samples.columns(poles)
        scale = np.linalg.norm(columns, axis=0)
        back, target = [], []
        for values, weights in zip(samples.values, samples.weights, strict=True):
            q, r = np.linalg.qr(columns / scale * weights[:, None])
            back.append(np.linalg.inv(r) / scale[:, None])
            target.append(q.T @ (weights * stacked(values)))
        self.back, self.target = np.array(back), np.array(target)

    def best(self, known: Inequalities, *, proven: bool) -> Fit:
        """The one with the least error under all inequalities, which are used and added to.

        Without `proven` it is passive on a grid only.
        """
        highest, solution = self.samples.omega.max(), self.target
        inner, outer = np.linspace(0.0, 2.0, 160), np.geomspace(2.0, 20.0, 30)
        grid = np.concatenate([highest * inner, highest * outer[1:], [np.inf]])
        for _ in range(ROUNDS):
            if known.omega:
                step, active = _nearest(self._conditions(known), self.target.ravel())
                solution = self.target + step.reshape(self.target.shape)
                known.keep(active)
            coefficients = np.einsum("mij,mj->mi", self.back, solution)
            own = coefficients[:, : self.order]
            omega = grid
            values, vectors = self._eigen(omega, own)
            worst = _minima(values[:, 0])
            if not len(worst) and proven:
                omega = _between(singular_frequencies(self.poles, own, self.size))
                if len(omega):
                    values, vectors = self._eigen(omega, own)
                    worst = _minima(values[:, 0])
            if not len(worst):
                nothing = np.zeros(len(own))
                offset = coefficients[:, -1] if self.samples.offset else nothing
                return Fit(self.poles, residues_of(self.poles, own), offset)
            known.add(omega[worst], values[worst], vectors[worst])
        raise UnprovenError

    def _conditions(self, known: Inequalities) -> np.ndarray:
        """Coefficients of all z in vᵀ Re K v, one row for each inequality."""
        v, twice = np.array(known.directions), np.where(self.rows == self.columns, 1.0, 2.0)
        factor = twice * v[:, self.rows] * v[:, self.columns]
        parts = self._real_parts(np.array(known.omega))
        found = np.einsum("cm,ck,mkj->cmj", factor, parts, self.back[:, : self.order])
        return found.reshape(len(v), -1)

    def _eigen(self, omega: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Eigenvalues (n, m), ascending, and eigenvectors of (1 + ω²/ω₁²) Re K."""
        matrix = np.zeros((len(omega), self.size, self.size))
        upper = self._real_parts(omega) @ coefficients.T
        matrix[:, self.rows, self.columns] = matrix[:, self.columns, self.rows] = upper
        return np.linalg.eigh(matrix)

    def _real_parts(self, omega: np.ndarray) -> np.ndarray:
        """(1 + ω²/ω₁²) Re of the columns of `basis`, also at ω = ∞, (n, order)."""
        reference, finite = self.samples.omega.max() / 2, np.isfinite(omega)
        found = np.empty((len(omega), self.order))
        growth = 1 + (omega[finite] / reference) ** 2
        found[finite] = basis(omega[finite], self.poles).real * growth[:, None]
        ends = [[-2 * p.real, 2 * p.imag] if p.imag > 0 else [-p.real] for p in self.poles]
        found[~finite] = np.concatenate(ends) / reference**2
        return found


def _minima(values: np.ndarray) -> np.ndarray:
    """Indices of the local minima that are too small."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    lowest = (values <= padded[:-2]) & (values <= padded[2:])
    return np.flatnonzero(lowest & (values < ACCEPTED))


def _between(singular: np.ndarray) -> np.ndarray:
    """Frequencies [rad/s] between and beyond some at which Re K is singular, if any."""
    if not len(singular):
        return singular
    edges = np.concatenate([[0.0], singular, [4 * singular[-1]]])
    parts = np.linspace(0.0, 1.0, BETWEEN)
    return np.unique(np.concatenate([a + (b - a) * parts for a, b in pairwise(edges)]))


def singular_frequencies(poles: Complex, combination: np.ndarray, size: int) -> np.ndarray:
    """Angular frequencies (n,) [rad/s] > 0 at which Re K(jω) has an eigenvalue 0, ascending.

    `poles` (k,) [1/s]; `combination` (m, order), SI, of the columns of `basis`: the upper triangle
    of K row by row, which has `size` rows.
    """
    from scipy.linalg import eig

    one, order = companion(poles), len(inputs(poles))
    n = size * order
    a = np.kron(np.eye(size), one)
    b = np.kron(np.eye(size), inputs(poles)[:, None])
    c = np.zeros((size, size, order))
    rows, cols = np.triu_indices(size)
    c[rows, cols] = c[cols, rows] = combination
    c = c.reshape(size, n)
    fastest = np.abs(poles).max()
    a, b, c = a / fastest, b / np.sqrt(fastest), c / np.sqrt(fastest)
    corner, side = np.zeros((n, n)), np.zeros((size, size))
    pencil = np.block([[a, corner, b], [corner, -a.T, -c.T], [c, b.T, side]])
    mass = np.diag(np.concatenate([np.ones(2 * n), np.zeros(size)]))
    pairs = eig(pencil, mass, right=False, homogeneous_eigvals=True)
    numerator, denominator = np.asarray(pairs)
    with np.errstate(all="ignore"):
        values = numerator / denominator
    finite = np.isfinite(values) & (np.abs(denominator) > 1e-8 * np.abs(numerator))
    near = ON_AXIS * np.maximum(1.0, np.abs(values.imag))
    axis = finite & (np.abs(values.real) < near) & (values.imag > 0)
    return np.sort(values.imag[axis]) * fastest


def _nearest(conditions: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The shortest z with conditions·(point + z) ≥ MARGIN, and which of them hold it there.

    Lawson and Hanson's LDP, by NNLS. UnprovenError if the conditions contradict each other.
    """
    from scipy.optimize import nnls

    length = np.linalg.norm(conditions, axis=1)
    normals = conditions / length[:, None]
    missing = -normals @ point + MARGIN / length
    system = np.concatenate([normals.T, missing[None, :]])
    wanted = np.zeros(len(system))
    wanted[-1] = 1.0
    try:
        factors, _ = nnls(system, wanted, maxiter=20 * system.shape[1])
    except RuntimeError:
        raise UnprovenError from None
    residual = system @ factors - wanted
    if residual[-1] > -1e-13:
        raise UnprovenError
    return -residual[:-1] / residual[-1], factors > 0
