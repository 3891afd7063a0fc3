"""The radiation memory of a group of coupled motions as a convolution, from B alone.

K(t) and the polynomials of its integral are those of `kernel`: no function is fitted. How far the
time of the integral goes, the memory decides: to where it stays below DECAYED of its largest value,
or below the noise of its data. What is cut off leaves Re K(jω) slightly negative where B is nearly
0; a damping without memory, of that size, makes it passive.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory import soundness
from m4e_adapters.hydrodynamics.memory.group_fit import DISAGREE, GroupData, MemoryGroup, Misfit
from m4e_adapters.hydrodynamics.memory.kernel import Kernel, projected, quadrature, responses
from m4e_adapters.hydrodynamics.memory.reach import Reach
from m4e_adapters.hydrodynamics.memory.vector_fitting import Complex
from m4e_fmi.errors import InputError

DECAYED = 2e-5  # of the largest K, below which the memory is cut off
ABOVE_NOISE = 2.0  # likewise, of the largest K in the last quarter of the time that is known
ACCURATE = 2e-4  # error of K(jω) by polynomials, over the largest B
COUNTS = (16, 24, 32, 48, 64, 80, 96, 128, 160, 200, 256, 320, 400)  # of polynomials
BEYOND = 4.0  # frequencies at which errors are looked for, over the last of the data
SHOWN = 200  # such frequencies
SAMPLES, MARGIN = 12, 1.1  # of Re K in each of its waves, and of the damping that makes it passive


@dataclass(frozen=True, kw_only=True)
class ConvolutionGroup(MemoryGroup):
    """Retardation functions of some motions over the last `duration`.

    Attributes
    ----------
    kernel : K(t) for all times.
    duration : time of the integral [s].
    weights : (k, m, m) [N.s/m, N.s, N.m.s] of the polynomials of the past velocity.
    truncation : largest change of K(jω) by what is cut off, over the motions' largest B [1].
    noise : root mean square scatter of B about its line, over the motion's largest B [1].
    damping : (m,) [N.s/m, N.m.s] without memory, which is part of K(jω) and makes it passive.
    surcharge : that damping over the motions' largest B [1].
    """

    kernel: Kernel
    duration: float
    weights: np.ndarray
    truncation: float
    noise: float
    damping: np.ndarray
    surcharge: float

    @property
    def order(self) -> int:
        """Number of polynomials."""
        return len(self.weights)

    @property
    def text(self) -> str:
        """Time, polynomials, truncation, noise and passivity in words."""
        return (
            f"convolution over {self.duration:.3g} s by {self.order} polynomials, truncation "
            f"{100 * self.truncation:.2g} %, noise {100 * self.noise:.2g} % and "
            f"{100 * self.surcharge:.2g} % added to be passive, of the largest damping"
        )

    def transfer(self, omega: np.ndarray) -> Complex:
        """K(jω) (n, m, m) [N.s/m, N.s, N.m.s] at `omega` (n,) [rad/s]."""
        states = responses(omega, duration=self.duration, count=self.order)
        return np.tensordot(states, self.weights, axes=1) + np.diag(self.damping)

    def impulse_response(self, time: np.ndarray) -> np.ndarray:
        """K(t) (n, m, m) [N/m, N, N.m] at `time` (n,) [s] ≥ 0, without `damping`.

        It is 0 after the `duration`.
        """
        return np.where((time <= self.duration)[:, None, None], self.kernel.at(time), 0.0)


def convolved_group(
    data: Coefficients,
    motions: tuple[int, ...],
    signal: np.ndarray,
    sound: np.ndarray,
    *,
    reach: Reach,
) -> ConvolutionGroup:
    """The convolution of one group, from the data that agree best with causality.

    `signal` (n, n), booleans: pairs of motions that count. `sound` (nω,), booleans: frequencies
    that count. These are all that matter, or those that the panels resolve.
    """
    own, found, ends = list(motions), list[ConvolutionGroup](), list[float]()
    for limits in (reach, reach.shorter()):
        end = float(limits.fitted[own].max())  # one for all: B of others is small there, not wrong
        if end in ends:
            continue
        ends.append(end)
        limits = replace(limits, fitted=np.full_like(limits.fitted, end))
        values = GroupData(data, motions, signal, sound, limits)
        found.append(_convolved(values))
        if not found[-1].misfit.is_poor and found[-1].change == 0:
            return found[-1]
    return min(found, key=lambda group: group.misfit.demerit)


def _convolved(values: GroupData) -> ConvolutionGroup:
    kernel = Kernel.of(values)
    highest = BEYOND * float(values.ends.max())
    omega = np.linspace(0.0, highest, SHOWN + 1)
    duration = _duration(kernel, float(values.ends.max()))
    times, steps = quadrature(duration, highest)
    exact = _transformed(omega, times, steps, kernel)
    weights = _weights(kernel, duration, (omega, exact / values.scale), values)
    surcharge = _surcharge(weights / values.scale, duration=duration, highest=highest)
    more, steps = quadrature(kernel.longest - duration, highest)
    rest = _transformed(omega, duration + more, steps, kernel) / values.scale
    states = responses(values.omega, duration=duration, count=len(weights))
    found = np.tensordot(states, weights.astype(complex), axes=1)
    found += surcharge * np.diag(values.own)
    surplus, misfits = _with_added_mass(values, found)
    return ConvolutionGroup(
        motions=values.motions,
        surplus=surplus,
        inertia=values.inertia,
        misfit=misfits[0],
        misfit_of_all=misfits[1],
        resolved=values.resolved,
        ends=values.ends,
        doubtful=values.doubtful,
        kernel=kernel,
        duration=duration,
        weights=weights,
        truncation=float(np.abs(rest).max()),
        noise=_noise(values),
        damping=surcharge * values.own,
        surcharge=surcharge,
    )


def _duration(kernel: Kernel, highest: float) -> float:
    """Time [s] after which K stays small; `highest` [rad/s] is the last frequency of its data.

    InputError if K is nowhere above the noise.
    """
    count = 1 + 4 * int(kernel.longest * highest)
    time = np.linspace(0.0, kernel.longest, count)
    size = np.abs(kernel.at(time))
    own = size.diagonal(axis1=1, axis2=2).max(axis=0)
    size /= np.sqrt(np.outer(own, own))
    later = np.maximum.accumulate(size[::-1], axis=0)[::-1]
    noise = ABOVE_NOISE * later[3 * count // 4]
    alive = np.flatnonzero((later > np.maximum(DECAYED, noise)).any(axis=(1, 2)))
    if not len(alive):
        raise InputError.single(
            "the radiation memory is nowhere above the noise of its damping: in the last quarter "
            f"of the {kernel.longest:.3g} s that the frequencies tell it is as large as before",
            "give coefficients of a smoother damping at more closely spaced frequencies, or remove "
            "radiation.memory: convolution",
        )
    return float(time[alive[-1] + 1])


def _transformed(
    omega: np.ndarray, times: np.ndarray, steps: np.ndarray, kernel: Kernel
) -> Complex:
    """∫ K e^{−jωt} dt (n, m, m) by a quadrature."""
    waves = np.exp(-1j * np.outer(omega, times))
    return np.tensordot(waves, kernel.at(times) * steps[:, None, None], axes=1)


def _weights(
    kernel: Kernel, duration: float, exact: tuple[np.ndarray, Complex], values: GroupData
) -> np.ndarray:
    """Those of the fewest polynomials that are accurate, (count, m, m) [N.s/m, N.s, N.m.s].

    `exact` are frequencies (n,) [rad/s] and what K(jω) (n, m, m) is there, over the largest B.
    """
    omega, response = exact
    times, steps = quadrature(duration, float(omega[-1]))
    weighted = kernel.at(times) * steps[:, None, None]
    least = 0.5 * duration * float(values.ends.max())  # a polynomial has two waves per π of degree
    for count in (count for count in COUNTS if count > least):
        weights = projected(times, weighted, duration=duration, count=count)
        states = responses(omega, duration=duration, count=count)
        found = np.tensordot(states, weights / values.scale, axes=1)
        if np.abs(found - response).max() < ACCURATE:
            return weights
    raise InputError.single(
        f"the radiation memory needs more than {COUNTS[-1]} polynomials for {duration:.3g} s",
        "remove radiation.memory: convolution, or put bodies of so different sizes into "
        "hydrodynamics components of their own",
    )


def _surcharge(weights: np.ndarray, *, duration: float, highest: float) -> float:
    """Damping over the motions' largest B [1] that makes K passive.

    `weights` (count, m, m) [1] over the largest B, `duration` [s]. Re K(jω) is sampled up to
    `highest` [rad/s], above which it falls as 1/ω², and SAMPLES times in each of its waves 2π/T.
    """
    omega = np.linspace(0.0, highest, 1 + int(SAMPLES * highest * duration / (2 * np.pi)))
    states = responses(omega, duration=duration, count=len(weights))
    found = np.tensordot(np.real(states), weights, axes=1)
    least = np.linalg.eigvalsh(0.5 * (found + found.swapaxes(1, 2))).min()
    return float(MARGIN * max(0.0, -least))


def _with_added_mass(values: GroupData, found: Complex) -> tuple[np.ndarray, tuple[Misfit, Misfit]]:
    """The change of A∞ (m, m) [kg, kg.m, kg.m2] and the errors with it.

    A∞ is the given one, or the mean of A(ω) less what B says where that halves a large error.
    """
    none = np.zeros_like(values.scale)
    given = values.misfits_of(found, none)
    if given[1].error < DISAGREE:
        return none, given
    apart = values.added_mass - found.imag / values.omega[:, None, None]
    means = [
        apart[known, i, j].mean()
        for i, j, known in zip(values.rows, values.columns, values.known.T, strict=True)
    ]
    mean = none.copy()
    mean[values.rows, values.columns] = mean[values.columns, values.rows] = means
    better = values.misfits_of(found, mean)
    return (mean, better) if better[1].error < given[1].error / 2 else (none, given)


def _noise(values: GroupData) -> float:
    """Root mean square scatter of the motions' B over their largest [1], the largest of them."""
    found = [0.0]
    for k in range(len(values.motions)):
        known = values.known[:, (values.rows == k) & (values.columns == k)].all(axis=1)
        own = values.damping[known, k, k] / values.own[k]
        found.append(soundness.scatter(values.omega[known], own))
    return max(found)
