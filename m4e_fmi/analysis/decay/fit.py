"""Period and damping of a free decay, fitted to the whole record, with standard errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.analysis.decay.correlated import covariance
from m4e_fmi.analysis.decay.oscillation import Shape, oscillation
from m4e_fmi.analysis.decay.record import (
    LEAST_SWING,
    Part,
    Peaks,
    Window,
    checked,
    find_peaks,
    part_of,
)
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.shown import listing

Floats = NDArray[np.float64]

EQUIVALENT = 4.0 / (3.0 * math.pi)
"""Damping ratio per b times amplitude (Lorentz): of equal work in a period."""
EARLY = 0.25
"""Of the first distance from rest: peaks down to there give the first guess."""
LOST = 1e6
"""Residual of a motion without bound, in amplitudes."""
FAR = 2.0
"""Frequency of a fit over that of the peaks, and its inverse, beyond which it is of no use."""
ROUNDING = 1e-9
"""Of the amplitude: a residual below has no spectrum."""
AROUND = 1.0 / 12.0
"""Of a period, to both sides of a peak: rows that its height is from."""
TOLERANCE, MOST_TRIALS = 1e-12, 100
"""Of the fit: relative, and of evaluations."""
LEAST_PEAK, CLEAR = 0.01, 4.0
"""Least swing of a peak for decrements, over the release and over the residual."""
OURS = [0, 1, 2, 5]
"""Places of ω, ζ, β and rest in a shape."""
STEP = 0.1
"""Of a standard error, for derivatives."""


@dataclass(frozen=True)
class Estimate:
    """A value and its standard error, in the same unit."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:.6g} ± {self.error:.2g}"


class Motion(NamedTuple):
    """Parameters of ẍ + 2ζω ẋ + b |ẋ| ẋ + ω² (x − x₀) = 0: ω [rad/s], ζ [1], b, x₀."""

    omega: float
    ratio: float
    quadratic: float
    rest: float


@dataclass(frozen=True)
class Decay:
    """The fit of ẍ + 2ζω ẋ + b |ẋ| ẋ + ω² (x − x₀) = 0 to a record.

    `time` (n,) [s], `motion` and `fitted` (n,) in the motion's unit are those of the `window`.
    `parameters` (4,) are ω [rad/s], ζ [1], b [1/unit of motion], x₀ [unit of motion],
    `covariance` (4, 4) is theirs in the same units. `release` is the largest distance from rest
    [unit of motion]. `trend` is the change of x₀ over the window [unit of
    motion].
    """

    window: Window
    time: Floats = field(repr=False)
    motion: Floats = field(repr=False)
    fitted: Floats = field(repr=False)
    parameters: Floats
    covariance: Floats = field(repr=False)
    release: float
    peaks: Peaks = field(repr=False)
    trend: Estimate

    def estimate(self, of: Callable[[Motion], float]) -> Estimate:
        """`of` the parameters with its standard error, to first order in theirs."""
        slopes = np.zeros(4)
        for k, error in enumerate(np.sqrt(self.covariance.diagonal()).tolist()):
            if error > 0.0:
                shift = np.zeros(4)
                shift[k] = STEP * error
                upper, lower = (Motion(*(self.parameters + s).tolist()) for s in (shift, -shift))
                slopes[k] = (of(upper) - of(lower)) / (2.0 * STEP * error)
        error = math.sqrt(max(0.0, float(slopes @ self.covariance @ slopes)))
        return Estimate(float(of(Motion(*self.parameters.tolist()))), error)

    @property
    def period(self) -> Estimate:
        """Undamped natural period 2π/ω [s]."""
        return self.estimate(lambda p: 2.0 * math.pi / p.omega)

    @property
    def damped_period(self) -> Estimate:
        """Period of small motions, with the linear damping [s]; infinite without oscillation."""

        def of(p: Motion) -> float:
            rest = 1.0 - p.ratio**2
            return 2.0 * math.pi / (p.omega * math.sqrt(rest)) if rest > 0.0 else math.inf

        return self.estimate(of)

    @property
    def damping_ratio(self) -> Estimate:
        """Linear damping over critical, ζ [1]."""
        return self.estimate(lambda p: p.ratio)

    @property
    def quadratic(self) -> Estimate:
        """Quadratic damping over inertia, b [1/unit of motion]."""
        return self.estimate(lambda p: p.quadratic)

    @property
    def rest(self) -> Estimate:
        """Motion at rest, x₀ [unit of motion]."""
        return self.estimate(lambda p: p.rest)

    def equivalent_ratio(self, amplitude: float) -> Estimate:
        """Damping ratio [1] of equal work at an amplitude a [unit of motion]: ζ + 4/(3π) b a."""
        return self.estimate(lambda p: p.ratio + EQUIVALENT * p.quadratic * amplitude)

    @property
    def correlation(self) -> float:
        """Correlation of ζ and b: near −1 the record tells their sum only."""
        errors = np.sqrt(self.covariance.diagonal())
        product = float(errors[1] * errors[2])
        return float(self.covariance[1, 2]) / product if product else 0.0

    @property
    def surest_amplitude(self) -> float:
        """The amplitude [unit of motion] whose equivalent damping ratio has the least error."""
        variance = float(self.covariance[2, 2])
        return -float(self.covariance[1, 2]) / (EQUIVALENT * variance) if variance else 0.0

    @property
    def residual(self) -> Floats:
        """The record less the fit, (n,), in the motion's unit."""
        return self.motion - self.fitted

    @property
    def residual_share(self) -> float:
        """Root of the mean square of the residual over the release [1]."""
        return float(np.sqrt(np.mean(self.residual**2))) / self.release

    def linear_coefficient(self, *, mass: float = 0.0, stiffness: float = 0.0) -> Estimate:
        """Linear damping [N.s/m, N.m.s/rad] of a `mass` with added mass [kg, kg.m2], or with a
        `stiffness` [N/m, N.m/rad]."""
        inertia = _inertia(mass, stiffness)
        return self.estimate(lambda p: 2.0 * p.ratio * p.omega * inertia(p.omega))

    def quadratic_coefficient(self, *, mass: float = 0.0, stiffness: float = 0.0) -> Estimate:
        """Quadratic damping [N/(m/s)2, N.m/(rad/s)2]; arguments as `linear_coefficient`."""
        inertia = _inertia(mass, stiffness)
        return self.estimate(lambda p: p.quadratic * inertia(p.omega))

    def __repr__(self) -> str:
        return listing(
            f"Decay: period {self.period} s, damping ratio {self.damping_ratio}, "
            f"quadratic {self.quadratic}, rest {self.rest}"
        )


def fit_decay(
    time: ArrayLike, motion: ArrayLike, *, start: float | None = None, end: float | None = None
) -> Decay:
    """The fit to a record: `motion` (n,) in any unit at `time` (n,) [s], evenly spaced or not.

    From `start` to `end` [s]; by default from the first peak after the release. InputError for a
    record without two peaks, one that grows, that does not move or is not finite; RunError if no
    such motion is like it.
    """
    times, motions = checked(time, motion)
    part = part_of(times, motions, start, end)
    t, x = times[part.rows], motions[part.rows]
    scale = part.release
    guess = _guess(part, float(t[0]))
    shape = _fitted(t - t[0], x / scale, guess)
    values, jacobian = oscillation(shape, t - t[0])
    residual = x / scale - values
    swing = max(LEAST_SWING * float(np.ptp(values)), CLEAR * float(np.std(residual)))
    if not np.isfinite(values).all() or len(find_peaks(t, values, swing).time) < 2:
        first, second, *_ = part.peaks.time
        raise RunError(
            f"no damped oscillation fits the peaks of the record (the first at {first:.4g} and "
            f"{second:.4g} s)",
            "look at it: it may be damped too much to oscillate, be noisy, or have several "
            "motions; fit another part of it",
        )
    units = np.array([1.0, 1.0, 1.0 / scale, scale])
    spread = _spread(jacobian, residual)
    least = scale * max(LEAST_PEAK, CLEAR * float(np.std(residual)))
    width = AROUND * 2.0 * math.pi / shape.omega
    stop = part.rows.stop
    peaks = find_peaks(times[:stop], motions[:stop], least, width=width).after(t[0] - width)
    # the change of rest over the window, from one step of a fit that has one
    longer = np.column_stack([jacobian, (t - t.mean()) / np.ptp(t)])
    change, *_ = np.linalg.lstsq(longer, residual)
    drifts = _spread(longer, residual - longer @ change)
    return Decay(
        window=part.window,
        time=t,
        motion=x,
        fitted=values * scale,
        parameters=np.array(shape)[OURS] * units,
        covariance=spread[np.ix_(OURS, OURS)] * np.outer(units, units),
        release=scale,
        peaks=peaks,
        trend=Estimate(scale * float(change[-1]), scale * math.sqrt(float(drifts[-1, -1]))),
    )


def _guess(part: Part, begin: float) -> Shape:
    """Parameters from the peaks, of a motion from `begin` [s] on in units of the release."""
    time, away = part.peaks.time, (part.peaks.values - part.rest) / part.release
    size = np.abs(away)
    count = max(2, int(np.argmax(np.append(size, 0.0) < EARLY * size[0])))
    omega = math.pi * (count - 1) / float(time[count - 1] - time[0])
    decrements = -np.diff(np.log(np.maximum(size[:count], 1e-6)))
    ratios = decrements / np.sqrt(math.pi**2 + decrements**2)
    between = EQUIVALENT * np.sqrt(size[: count - 1] * size[1:count])
    ratio, quadratic = float(ratios.mean()), 0.0
    if count > 3:
        quadratic, ratio = np.polyfit(between, ratios, 1, w=between).tolist()
        if quadratic < 0.0 or ratio < 0.0:
            ratio, quadratic = float(ratios.mean()), 0.0
    phase = omega * (begin - float(time[0]))
    start, speed = float(away[0]) * math.cos(phase), -float(away[0]) * math.sin(phase)
    ratio = min(max(ratio, 0.0), 0.9)
    return Shape(omega, ratio, quadratic, start, speed, part.rest / part.release)


def _fitted(time: Floats, values: Floats, guess: Shape) -> Shape:
    """The shape with the least squares of `values` (n,) [1] at `time` (n,) [s] from 0 on."""
    from scipy.optimize import least_squares

    known: dict[bytes, tuple[Floats, Floats]] = {}
    lost = np.full(len(time), LOST), np.zeros((len(time), len(guess)))

    def at(p: Floats) -> tuple[Floats, Floats]:
        key = p.tobytes()
        if key not in known:
            known.clear()
            shape = Shape(*p.tolist())
            near = 1.0 / FAR < shape.omega / guess.omega < FAR
            known[key] = oscillation(shape, time) if near else lost
        return known[key]

    def residual(p: Floats) -> Floats:
        return np.nan_to_num(at(p)[0] - values, nan=LOST)

    found = least_squares(
        residual,
        np.array(guess),
        jac=lambda p: np.nan_to_num(at(p)[1]),
        method="lm",
        x_scale=np.array([guess.omega, 0.1, 0.1, 1.0, 1.0, 1.0]),
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=TOLERANCE,
        max_nfev=MOST_TRIALS,
    )
    return Shape(*found.x.tolist())


def _spread(jacobian: Floats, residual: Floats) -> Floats:
    """Covariance (m, m) of the parameters, in the units of the shape.

    `jacobian` (n, m) and `residual` (n,) [1] are in units of the release.
    """
    n, m = jacobian.shape
    variance = float((residual**2).sum()) / (n - m)
    if math.sqrt(variance) >= ROUNDING:
        return covariance(jacobian, residual)
    back = np.linalg.inv(np.linalg.qr(jacobian, mode="r"))
    return variance * back @ back.T


def _inertia(mass: float, stiffness: float) -> Callable[[float], float]:
    """Inertia at a frequency [rad/s]: `mass`, or what oscillates so on `stiffness`."""
    if (mass > 0.0) == (stiffness > 0.0):
        message = "coefficients need either the mass with added mass, or the stiffness"
        raise InputError.single(message, "give one of them, above 0")
    return lambda omega: mass if mass > 0.0 else stiffness / omega**2
