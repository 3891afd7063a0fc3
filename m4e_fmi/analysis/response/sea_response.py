"""Statistics of the response to an irregular sea, by statistical linearisation.

The motion is taken as Gaussian: a mean x̄ and the covariance of the linear response to the sea. All
loads have the linear equations that are best for this motion, the mean derivatives
A = E[∂f/∂x], … (I. E. Kazakov, "Approximate probabilistic analysis of the accuracy of operation of
essentially nonlinear automatic systems", Autom. Remote Control 17, 1956), and x̄ is where the mean
of ẋ = f is zero; both are iterated. Of a drag −c |v| v that is the equivalent damping √(8/π) c σ_v.

Means are over samples of a low-discrepancy sequence that have the covariance exactly, so that means
of quadratic outputs, such as the power of a linear damper, are exact for the linear response.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.analysis.points import Floats, OperatingPoint, place
from m4e_fmi.analysis.response.linear_equations import (
    SIGNIFICANT,
    Held,
    Limits,
    LinearEquations,
    adrift,
)
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.wave_response import doubts, usual_outputs
from m4e_fmi.analysis.response.waves import Complex, InWaves, Sea
from m4e_fmi.errors import RunError
from m4e_fmi.program import Variable
from m4e_fmi.shown import listing

SAMPLES = 2048
"""Of the motion, half of them the other half's opposites."""
ACCURACY = 1e-6
"""Relative change of standard deviations at which the iteration ends."""
MOST_STEPS = 100
DECAY = 1e-2
"""Of the first guess: decay of all motions over their frequency."""
SMALL = 1e-3
"""Standard deviation over the largest of its unit from which on its own size counts."""
NONE = 1e-9
"""Standard deviation over the largest of its unit below which it is rounding."""
MANY = 20
"""Columns that the derivatives depend on, from which on those of inputs are reduced: samples in
more than 100 directions made drag on members too large by 6 %."""
LEFT_OUT = 1e-8
"""Part of the variance of inputs, each over its own, that a reduction may leave out."""
LEAST = 1e-12
"""Part of the largest variance below which a direction of the correlated motion counts as none."""


@dataclass(frozen=True)
class SeaResponse:
    """Statistics of outputs in a `sea`: `means`, `deviations` (outputs,), in the outputs' units.

    `deviations` are standard deviations. `values` (k, outputs) are the harmonics per wave
    amplitude of the linearised response to each wave of the sea, `states` (k, n) those of states,
    `linear` the equations that they come from, about `point` and a `mean_step` (n,) from it.
    `notes` say where the response is in doubt.
    """

    point: OperatingPoint = field(repr=False)
    sea: Sea
    outputs: tuple[Variable, ...]
    means: Floats = field(repr=False)
    deviations: Floats = field(repr=False)
    values: Complex = field(repr=False)
    states: Complex = field(repr=False)
    mean_step: Floats = field(repr=False)
    linear: LinearEquations = field(repr=False)
    notes: tuple[str, ...] = ()

    def mean(self, output: str) -> float:
        """The mean of an output, in its unit."""
        return float(self.means[place(output, self.outputs)])

    def deviation(self, output: str) -> float:
        """The standard deviation of an output, in its unit."""
        return float(self.deviations[place(output, self.outputs)])

    def zero_crossing_period(self, output: str) -> float:
        """2π √(m₀/m₂) [s] of the linear response; nan of an output that has none."""
        density = np.abs(self.values[:, place(output, self.outputs)] * self.sea.amplitudes) ** 2
        second = float(density @ self.sea.omega**2)
        return float(2.0 * np.pi * np.sqrt(density.sum() / second)) if second > 0 else float("nan")

    def __repr__(self) -> str:
        title = (
            f"SeaResponse of {self.point.program.name!r}: significant height "
            f"{self.sea.significant_height:.4g} m, {len(self.sea.omega)} waves"
        )
        rows = zip(self.outputs, self.means, self.deviations, strict=True)
        return listing(title, outputs=[f"{v.name}: {m:.6g} ± {s:.6g} {v.unit}" for v, m, s in rows])


def sea_response(
    waves: InWaves,
    point: OperatingPoint,
    sea: Sea,
    *,
    outputs: Sequence[str] | None = None,
    progress: Callable[[str], object] | None = None,
) -> SeaResponse:
    """Statistics in `sea` of the motion about `point`, an equilibrium in still water.

    `outputs` names outputs or states, by default `usual_outputs`; `progress` is told each step of
    the iteration. InputError for unknown names, RunError if the iteration does not converge.
    """
    names = usual_outputs(waves.program) if outputs is None else outputs
    local = LocalEquations(waves.program, point, inputs=waves.inputs, outputs=names)
    forces = waves.per_amplitude(sea.omega, sea.directions, point)
    motion = _Motion(local, sea, forces)
    linear, mean = motion.settled(progress or (lambda _: None))
    states, values = linear.harmonics(sea.omega, forces)
    means, deviations = motion.statistics(linear, mean)
    notes = [*sea.doubts, *doubts(waves, local, _needed(sea), small=False)]
    limits = Limits(waves, point)
    if limits.outputs:
        sizes = np.abs(limits.harmonics(states, forces)) * sea.amplitudes[:, None]
        significant = SIGNIFICANT * np.sqrt(0.5 * np.sum(sizes**2, axis=0))
        notes += limits.passed(significant, "a significant amplitude of")
    if name := adrift(LinearEquations.of(local), linear.rates, local.states):
        notes.append(f"nothing balances the mean force on {name}: it drifts")
    return SeaResponse(
        point=point, sea=sea, outputs=local.outputs, means=means, deviations=deviations,
        values=values, states=states, mean_step=mean, linear=linear,
        notes=tuple(notes),
    )  # fmt: skip


def _needed(sea: Sea) -> float:
    """The frequency [rad/s] below which 97 % of the energy of the sea are."""
    order = np.argsort(sea.omega)
    energy = np.cumsum(sea.amplitudes[order] ** 2)
    return float(sea.omega[order][np.searchsorted(energy, 0.97 * energy[-1])])


class _Motion:
    """The Gaussian motion in a sea, whose inputs per amplitude are `forces` (k, m)."""

    def __init__(self, local: LocalEquations, sea: Sea, forces: Complex) -> None:
        self.local, self.sea, self.forces = local, sea, forces
        self._basis, self._scale = self._reduced()
        self._normal = _normal_samples(self._basis.shape[1])
        self._units = np.array([v.unit for v in (*local.states, *local.inputs)], dtype=str)

    def _reduced(self) -> tuple[Floats, Floats]:
        """Directions (r, q) [1] in which the r curved columns move, and their scales (r,).

        Inputs are of one sea, whatever the motion is: many, as velocities at points of members,
        have few directions between them (principal components). Few are as they are.
        """
        n, curved = self.local.n, self.local.curved
        if len(curved) <= MANY:
            return np.eye(len(curved)), np.ones(len(curved))
        inputs = [k - n for k in curved if k >= n]
        waves = self.forces[:, inputs] * self.sea.amplitudes[:, None]
        covariance = 0.5 * np.real(waves.T @ waves.conj())
        scale = np.sqrt(covariance.diagonal())
        scale[scale == 0.0] = 1.0
        values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
        kept = np.cumsum(np.maximum(values, 0.0)) > LEFT_OUT * values.sum()
        first = len(curved) - len(inputs)
        basis = np.zeros((len(curved), first + int(kept.sum())))
        basis[:first, :first] = np.eye(first)
        basis[first:, first:] = vectors[:, kept]
        return basis, np.concatenate([np.ones(first), scale])

    def settled(self, progress: Callable[[str], object]) -> tuple[LinearEquations, Floats]:
        """The equivalent linear equations, and the mean step (n,) of the states."""
        title = "linearised for the sea: step"
        mean = np.zeros(self.local.n)
        linear = LinearEquations.of(self.local)
        last, held = self._covariance(linear, decay=DECAY), Held.by(linear.A)
        way = _Way()
        for number in range(1, MOST_STEPS + 1):
            progress(f"{title} {number} of {MOST_STEPS}")
            linear = LinearEquations.averaged(self.local, *self._samples(mean, last))
            sizes = 1.0 + np.abs(mean)
            step = held.step(linear.A, linear.rates)
            mean = mean + step
            now = self._covariance(linear)
            size, before = np.sqrt(now.diagonal()), np.sqrt(last.diagonal())
            least = np.maximum(size, SMALL / NONE * self._rounding(size))
            settled = np.abs(size - before) <= ACCURACY * least
            if settled.all() and np.max(np.abs(step) / sizes) <= ACCURACY:
                progress(f"{title} {number} of {number}")
                return linear, mean
            part = way.part((size - before) / np.where(least > 0.0, least, 1.0))
            last = (1.0 - part) * last + part * now
        name = self.local.point.program.name
        message = f"{name}: the linearised response to the sea did not settle"
        raise RunError(message, "take a lower sea, or simulate")

    def statistics(self, linear: LinearEquations, mean: Floats) -> tuple[Floats, Floats]:
        """Means and standard deviations of the outputs (k,).

        What is linear in the motion and what is left do not correlate.
        """
        n, covariance = self.local.n, self._covariance(linear)
        steps, forces = self._samples(mean, covariance)
        outputs = self.local.values(steps, forces)[:, n:]
        slopes = np.concatenate([linear.C, linear.D], axis=1)
        explained = (steps - mean) @ linear.C.T + forces @ linear.D.T
        left = np.var(outputs - explained, axis=0)
        variance = np.einsum("ij,jk,ik->i", slopes, covariance, slopes)
        return outputs.mean(axis=0), np.sqrt(np.maximum(variance, 0.0) + left)

    def _rounding(self, deviations: Floats) -> Floats:
        """The standard deviations (n + m,) below which those of their unit are rounding."""
        alike = self._units[:, None] == self._units
        return NONE * np.max(np.where(alike, deviations, 0.0), axis=1)

    def _covariance(self, linear: LinearEquations, *, decay: float = 0.0) -> Floats:
        """Of states and inputs, (n + m, n + m)."""
        states, _ = linear.harmonics(self.sea.omega, self.forces, decay=decay)
        all_of = np.concatenate([states, self.forces], axis=1) * self.sea.amplitudes[:, None]
        return 0.5 * np.real(all_of.T @ all_of.conj())

    def _samples(self, mean: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        """Steps (s, n) and inputs (s, m) with that covariance, of the curved ones only."""
        n, curved = self.local.n, self.local.curved
        found = np.zeros((len(self._normal), len(covariance)))
        deviations = np.sqrt(covariance.diagonal())
        there = deviations > self._rounding(deviations)
        covariance = covariance * np.outer(there, there)
        if curved:
            scaled = covariance[np.ix_(curved, curved)] / np.outer(self._scale, self._scale)
            inner = self._basis.T @ scaled @ self._basis
            scale = np.sqrt(np.maximum(inner.diagonal(), 0.0))
            divisor = np.where(scale > 0, scale, 1.0)
            values, vectors = np.linalg.eigh(inner / np.outer(divisor, divisor))
            least = LEAST * values.max(initial=0.0)
            roots = np.sqrt(np.where(values > least, np.maximum(values, 0), 0))
            # the symmetric root: unlike eigenvectors it follows a covariance that changes little
            factor = (vectors * roots) @ vectors.T * scale[:, None]
            found[:, curved] = self._normal @ factor.T @ self._basis.T * self._scale
        return found[:, :n] + mean, found[:, n:]


class _Way:
    """Part of the way to the next covariance, by the last two changes (Aitken's extrapolation).

    From half of it, as drag that limits a resonance would overshoot for ever, to all of it, where
    the equations are nearly linear.
    """

    def __init__(self) -> None:
        self._part, self._last = 0.5, np.zeros(0)

    def part(self, change: Floats) -> float:
        """For the next relative `change` (n,) [1]."""
        if len(self._last):
            turn = change - self._last
            size = float(turn @ turn)
            found = -self._part * float(self._last @ turn) / size if size > 0.0 else 1.0
            self._part = min(max(found, 0.5), 1.0)
        self._last = change
        return self._part


def _normal_samples(count: int) -> Floats:
    """Samples (s, count) of independent normal numbers, with unit covariance exactly."""
    if count == 0:
        return np.zeros((1, 0))
    from scipy.special import ndtri
    from scipy.stats import qmc

    half = SAMPLES // 2
    uniform = qmc.Sobol(count, rng=np.random.default_rng(0)).random(half)
    normal = ndtri(np.clip(uniform, 1e-12, 1.0 - 1e-12))
    both = np.concatenate([normal, -normal])
    square = both.T @ both / len(both)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(square), both.T).T, dtype=float)
