"""Steady motion in regular waves of a given height: a mean and a first harmonic that balance.

x = x̄ + Re[x₁ e^{−iωt}] such that mean and first harmonic of ẋ = f(x, wave) balance (harmonic
balance: N. M. Krylov, N. N. Bogoliubov, "Introduction to Non-Linear Mechanics", 1943). So each load
is linearised for the motion that it limits: a drag −c |v| v has the damping 8/(3π) c |v₁|. Loads
are evaluated at equal phases of a period. With J_k the mean of ∂f/∂x e^{ikωt}, changes of x̄ and x₁
change the mean of f by J₀ δx̄ + Re[J₁* δx₁], its harmonic by 2 J₁ δx̄ + J₀ δx₁ + J₂ δx₁*.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.equilibrium import newton_matrix
from m4e_fmi.analysis.points import Floats
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.waves import Complex
from m4e_fmi.errors import RunError

PHASES = 64
"""Points of a period; of |v| v they leave 1e-5 of the harmonic."""
ACCURACY = 1e-9
"""Of the motion, over 1 + its own size in its unit."""
MOST_STEPS = 60
SHORTEST = 1e-3
"""Part of a Newton step below which the search is given up."""
DRIFT = 1e-6
"""Mean rate, over what a unit change of all states causes, from which on it is told."""
_PHASE = 2.0 * np.pi * np.arange(PHASES) / PHASES
_FIRST: Complex = np.exp(1j * _PHASE)
_WEIGHTS: Complex = np.stack([_FIRST**k for k in range(3)]) / PHASES


@dataclass(frozen=True)
class SteadyMotion:
    """Harmonics per wave amplitude, of the states (n,) and of the outputs, `response` (k,).

    `mean` (k,) of the outputs; `third` (k,), their third harmonic over the first [1]. `drift` names
    a state whose mean rate nothing balances, "" if there is none.
    """

    states: Complex
    response: Complex
    mean: Floats
    third: Floats
    drift: str


def steady_motion(
    local: LocalEquations, omega: float, forces: Complex, guess: Complex, amplitude: float
) -> SteadyMotion:
    """The steady motion in waves of `omega` [rad/s] and `amplitude` [m].

    `forces` (m,) are the harmonics of the inputs and `guess` (n,) of the states, in SI, per m of
    amplitude.
    RunError if none is found.
    """
    n = local.n
    waves = np.real(amplitude * forces * np.conj(_FIRST)[:, None])
    balance = _Balance(local, omega, waves)
    x = np.concatenate([np.zeros(n), (amplitude * guess).real, (amplitude * guess).imag])
    x = balance.solved(x)
    first = x[n : 2 * n] + 1j * x[2 * n :]
    values, slopes = balance.values(x), balance.slopes(x)[0].real
    outputs = values[:, n:]
    response = 2.0 / PHASES * (_FIRST @ outputs)
    third = 2.0 / PHASES * (_FIRST**3 @ values)
    shifted = -3j * omega * np.eye(n) - slopes[:n, :n]
    above = third[n:] + slopes[n:, :n] @ np.linalg.solve(shifted, third[:n])
    scale = np.maximum(np.abs(response), np.finfo(float).tiny)
    return SteadyMotion(
        states=first / amplitude,
        response=response / amplitude,
        mean=outputs.mean(axis=0),
        third=np.abs(above) / scale,
        drift=_drift(local, values[:, :n], slopes[:n, :n]),
    )


def _drift(local: LocalEquations, rates: Floats, slopes: Floats) -> str:
    """The state with the largest mean of `rates` (phases, n), if no change of states balances it.

    `slopes` (n, n) are the mean derivatives of the rates.
    """
    left = np.abs(rates.mean(axis=0)) / (1.0 + np.abs(slopes).sum(axis=1))
    worst = int(np.argmax(left))
    return local.states[worst].name if left[worst] > DRIFT else ""


class _Balance:
    """The balance of mean and first harmonic; x (3n,) has mean, real and imaginary part."""

    def __init__(self, local: LocalEquations, omega: float, waves: Floats) -> None:
        self.local, self.omega, self.waves = local, omega, waves

    def _steps(self, x: Floats) -> Floats:
        mean, real, imaginary = x.reshape(3, -1)
        return mean + np.outer(np.cos(_PHASE), real) + np.outer(np.sin(_PHASE), imaginary)

    def values(self, x: Floats) -> Floats:
        """Rates and outputs (phases, n + k)."""
        return self.local.values(self._steps(x), self.waves)

    def slopes(self, x: Floats) -> Complex:
        """J₀, J₁, J₂ of rates and outputs, (3, n + k, n + m)."""
        return self.local.averages(self._steps(x), self.waves, _WEIGHTS)

    def rest(self, x: Floats) -> Floats:
        """The unbalanced mean and harmonic of the rates (3n,)."""
        n = self.local.n
        rates = self.values(x)[:, :n]
        first = x[n : 2 * n] + 1j * x[2 * n :]
        harmonic = 2.0 / PHASES * (_FIRST @ rates) + 1j * self.omega * first
        return np.concatenate([rates.mean(axis=0), harmonic.real, harmonic.imag])

    def newton(self, x: Floats, sizes: Floats) -> Floats:
        """N (3n, 3n): N `rest` is the Newton step."""
        n = self.local.n
        mean, one, two = self.slopes(x)[:, :n, :n]
        turn = self.omega * np.eye(n)
        slopes = np.block(
            [
                [mean.real, one.real, one.imag],
                [2.0 * one.real, mean.real + two.real, two.imag - turn],
                [2.0 * one.imag, two.imag + turn, mean.real - two.real],
            ]
        )
        return newton_matrix(slopes, sizes)

    def solved(self, x: Floats) -> Floats:
        """The x at which all balances, from a guess."""
        sizes = np.ones_like(x)
        for _ in range(MOST_STEPS):
            sizes = 1.0 + np.abs(x)
            newton = self.newton(x, sizes)
            step = newton @ self.rest(x)
            if np.max(np.abs(step) / sizes) <= ACCURACY:
                return x + step
            part = 1.0
            while True:
                ahead = x + part * step
                left = newton @ self.rest(ahead)
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
