"""Steady motion in regular waves of a given height: a mean and three harmonics that balance.

x = x̄ + Σ Re[x_h e^{−ihωt}], h = 1, 2, 3, such that mean and harmonics of ẋ = f(x, wave) balance
(harmonic balance: N. M. Krylov, N. N. Bogoliubov, "Introduction to Non-Linear Mechanics", 1943). So
each load is linearised for the motion that it limits: a drag −c |v| v of one harmonic has the
damping 8/(3π) c |v₁|. Loads are evaluated at equal phases φ of a period. With the functions
b = 1, cos hφ, sin hφ the derivatives of the balance are means of ∂f/∂x b_i b_j.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from m4e_fmi.analysis.points import Floats
from m4e_fmi.analysis.response.linear_equations import Held, LinearEquations, adrift
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.waves import Complex
from m4e_fmi.errors import RunError

HARMONICS = 3
PHASES = 64
"""Points of a period; of |v| v they leave 1e-5 of the harmonic."""
ACCURACY = 1e-9
"""Of the motion, over 1 + its own size in its unit."""
MOST_STEPS = 60
RISE = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Parts of the waves for which the motion is found one after another, if not at once."""
SHORTEST = 1e-3
"""Part of a Newton step below which the search is given up."""
_PHASE = 2.0 * np.pi * np.arange(PHASES) / PHASES
_FIRST: Complex = np.exp(1j * _PHASE)
_BASIS = np.array(
    [
        np.ones(PHASES),
        *(f(h * _PHASE) for h in range(1, HARMONICS + 1) for f in (np.cos, np.sin)),
    ]
)
_TESTS = _BASIS * np.array([1.0] + [2.0] * (2 * HARMONICS))[:, None] / PHASES
_SIZE = len(_BASIS)
_PRODUCTS: Complex = (_TESTS[:, None] * _BASIS[None]).reshape(-1, PHASES).astype(complex)


def steady_motion(
    local: LocalEquations, omega: float, forces: Complex, guess: Complex, amplitude: float
) -> tuple[Complex, Complex, Floats, Floats, str]:
    """The steady motion in waves of `omega` [rad/s] and `amplitude` [m].

    Returns first harmonics per wave amplitude of the states (n,) and of the outputs (k,) [SI]; the
    mean (k,) of the outputs, in their units, and their third harmonic over the first (k,) [1]; a
    state whose mean rate nothing balances, "" if there is none.

    `forces` (m,) are the harmonics of the inputs and `guess` (n,) of the states, in SI, per m of
    amplitude. RunError if none is found.
    """
    waves = np.real(amplitude * forces * np.conj(_FIRST)[:, None])
    balance = _Balance(local, omega, waves)
    start = np.zeros((_SIZE, local.n))
    start[1], start[2] = amplitude * guess.real, amplitude * guess.imag
    try:
        x = balance.solved(start)
    except RunError:  # from lower waves on
        x = RISE[0] * start
        for part in RISE:
            x = _Balance(local, omega, part * waves).solved(x)
    values = balance.values(x)
    outputs = values[:, local.n :]
    first, third = (2.0 / PHASES * (_FIRST**h @ outputs) for h in (1, 3))
    return (
        (x[1] + 1j * x[2]) / amplitude,
        first / amplitude,
        outputs.mean(axis=0),
        np.abs(third) / np.maximum(np.abs(first), np.finfo(float).tiny),
        adrift(LinearEquations.of(local), balance.rest(x)[0], local.states),
    )


class _Balance:
    """The balance of mean and harmonics; x (2·HARMONICS + 1, n) has the parts of the basis."""

    def __init__(self, local: LocalEquations, omega: float, waves: Floats) -> None:
        self.local, self.omega, self.waves = local, omega, waves
        self._held = Held.by(local.at_rest.A)

    def values(self, x: Floats) -> Floats:
        """Rates and outputs (phases, n + k)."""
        return self.local.values(_BASIS.T @ x, self.waves)

    def rest(self, x: Floats) -> Floats:
        """The unbalanced parts of the rates, as `x`."""
        found = _TESTS @ self.values(x)[:, : self.local.n]
        for h in range(1, HARMONICS + 1):
            cosine, sine = 2 * h - 1, 2 * h
            found[cosine] -= h * self.omega * x[sine]
            found[sine] += h * self.omega * x[cosine]
        return found

    def slopes(self, x: Floats) -> Floats:
        """Derivatives of `rest` by `x`, (parts, n, parts, n)."""
        n = self.local.n
        found = self.local.averages(_BASIS.T @ x, self.waves, _PRODUCTS)[:, :n, :n].real
        slopes = found.reshape(_SIZE, _SIZE, n, n).transpose(0, 2, 1, 3).copy()
        own = np.arange(n)
        for h in range(1, HARMONICS + 1):
            cosine, sine = 2 * h - 1, 2 * h
            slopes[cosine, own, sine, own] -= h * self.omega
            slopes[sine, own, cosine, own] += h * self.omega
        return slopes

    def newton(self, x: Floats) -> _Newton:
        """Newton steps from `x`."""
        return _Newton(self.slopes(x), self._held)

    def solved(self, x: Floats) -> Floats:
        """The x at which all balances, from a guess."""
        for _ in range(MOST_STEPS):
            sizes, newton = 1.0 + np.abs(x), self.newton(x)
            step = newton.step(self.rest(x))
            if np.max(np.abs(step) / sizes) <= ACCURACY:
                return x + step
            part = 1.0
            while True:
                ahead = x + part * step
                left = newton.step(self.rest(ahead))
                if np.linalg.norm(left / sizes) <= (1 - part / 4) * np.linalg.norm(step / sizes):
                    break
                part /= 2.0
                if part < SHORTEST:
                    raise self._lost()
            x = ahead
        raise self._lost()

    def _lost(self) -> RunError:
        name, period = self.local.point.program.name, 2.0 * np.pi / self.omega
        return RunError(
            f"{name}: no steady motion in waves of {period:.6g} s was found",
            "take a smaller height, or simulate: the motion may not have the period of the waves",
        )


class _Newton:
    """Newton steps of a balance, whose mean moves where it is `held` only.

    `slopes` (parts, n, parts, n) are derivatives, in SI.
    """

    def __init__(self, slopes: Floats, held: Held) -> None:
        self._held, self._shape = held, slopes.shape[:2]
        n = slopes.shape[1]
        matrix = slopes.reshape(slopes.shape[0] * n, -1)
        matrix = np.concatenate([held.rows @ matrix[:n], matrix[n:]])
        matrix = np.concatenate([matrix[:, :n] @ held.columns, matrix[:, n:]], axis=1)
        self._factors = lu_factor(matrix, check_finite=False)

    def step(self, rest: Floats) -> Floats:
        """The change (parts, n) that makes `rest` (parts, n) zero to first order, in SI."""
        right = np.concatenate([self._held.rows @ rest[0], rest[1:].ravel()])
        found = -np.asarray(lu_solve(self._factors, right, check_finite=False))
        known = self._held.columns.shape[1]
        step = np.empty(self._shape)
        step[0] = self._held.columns @ found[:known]
        step[1:] = found[known:].reshape(-1, self._shape[1])
        return step
