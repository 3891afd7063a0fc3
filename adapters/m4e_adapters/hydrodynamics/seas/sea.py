"""The waves of a configuration, recorded: elevation at x = 0 and excitation forces.

With θ_k = ω_k t + φ_k the elevation is Σ a_k cos θ_k = Re Σ a_k e^{−iθ_k}, and the force
Σ a_k (Re X_k cos θ_k + Im X_k sin θ_k). Height, period and peak enhancement are parameters of the
program, the components' frequencies are not: amplitudes follow the parameters, frequencies stay.
The peak period therefore has limits, within which the statistics of the sea hold (`PERIODS`).

In space the direction β that the waves travel to is a parameter too. With h the heading, X_k is the
sum of harmonics e^{ij(β − h)} of the wave at the body's centre, times the phase of the wave's way
from x = y = 0 to the reference place of that centre.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import (
    PEAK_ENHANCEMENT,
    Jonswap,
    PiersonMoskowitz,
    Regular,
    Still,
)
from m4e_adapters.hydrodynamics.seas.waves import (
    component_amplitudes,
    component_frequencies,
    component_phases,
    part_edges,
    wavenumber,
)
from m4e_fmi.errors import InputError
from m4e_fmi.program import Recorder, Scalar, Variable, cos, maximum, minimum, sin

Number = Scalar | float
Pair = tuple[Number, Number]
AnyWaves = Jonswap | PiersonMoskowitz | Regular | Still
SHORTEST = 1e-9  # ramp [s], so that a ramp_time set to 0 is none
REACH = 2.5  # peak frequencies up to which excitation is computed
PERIODS = (0.8, 1.25)  # of the peak period that the components were made for
NEGLIGIBLE = 1e-7  # harmonic of the excitation over the largest of its motion
RAMP_PERIODS = 2.0  # default length of the ramp in (peak) periods


def needed_frequency(waves: AnyWaves) -> float:
    """Angular frequency [rad/s] up to which `waves` need computed excitation; 0 in still water.

    Of an irregular sea that is where 3 % of its energy is left. See `Coefficients.excitation_at`
    for shorter waves.
    """
    if isinstance(waves, Still):
        return 0.0
    if isinstance(waves, Regular):
        return 2 * math.pi / waves.period
    return REACH * 2 * math.pi / waves.peak_period


def wavelength(waves: AnyWaves, *, depth: float, gravity: float) -> float:
    """That of the wave, or of the peak of the sea [m]; infinite in still water."""
    if isinstance(waves, Still):
        return math.inf
    period = waves.period if isinstance(waves, Regular) else waves.peak_period
    k = wavenumber(np.array(2 * math.pi / period), depth=depth, gravity=gravity)
    return 2 * math.pi / float(k)


def waves_beyond(waves: AnyWaves, highest: float, limit: float) -> tuple[str, str] | None:
    """Problem and remedy if excitation computed up to `highest` [rad/s] is too little.

    Irregular seas may have more above `limit`, where waves are short for all bodies.
    """
    needed = needed_frequency(waves)
    falls = not isinstance(waves, Regular) and highest >= limit * (1 - 1e-9)
    if falls or needed <= highest * (1 + 1e-9):
        return None
    if isinstance(waves, Regular):
        text = f"the wave has {needed:.4g} rad/s"
    else:
        text = f"the waves need excitation up to {needed:.4g} rad/s ({REACH:g} peak frequencies)"
        needed = min(needed, limit)
    return (
        f"{text}, the coefficients end at {highest:.4g} rad/s",
        f"raise frequencies.maximum to {needed:.4g} or leave it out, or use longer waves",
    )


def record_sea(
    recorder: Recorder,
    waves: AnyWaves,
    coefficients: Coefficients,
    *,
    heading: Number = 0.0,
    places: Sequence[tuple[Number, Number]] = (),
) -> list[Number]:
    """Record `wave.elevation`; the ramped excitation of each motion [N, N.m], in the hulls' axes.

    In space these have the `heading` [rad], and the bodies' reference `places` are (x, y) [m].
    """
    forces: list[Number] = [0.0] * len(coefficients.motions)
    origin = "x = 0" if coefficients.dimensions == 2 else "x = y = 0"
    text = f"elevation of the undisturbed water at {origin}"
    if isinstance(waves, Still):
        recorder.output(Variable("wave.elevation", "m", text), 0.0)
        return forces
    check_directions(waves, coefficients)
    check_frequencies(waves, coefficients)
    omega, amplitudes, phases = record_components(recorder, waves)
    if coefficients.dimensions == 2:
        table = _in_plane(coefficients.excitation_at(omega))
    else:
        direction = record_direction(recorder, waves, fixed=coefficients.is_of_one)
        table = excitation_in_space(coefficients, omega, direction, heading, places)
    ramp = record_ramp(recorder, waves)
    elevation: Scalar | float = 0.0
    for row, w, amplitude, phase in zip(table, omega, amplitudes, phases, strict=True):
        angle = float(w) * recorder.time + phase
        cosine, sine = cos(angle), sin(angle)
        elevation = elevation + amplitude * cosine
        for i, (real, imaginary) in enumerate(row):
            forces[i] = forces[i] + amplitude * real * cosine
            forces[i] = forces[i] + amplitude * imaginary * sine
    recorder.output(Variable("wave.elevation", "m", text), ramp * elevation)
    return [ramp * force for force in forces]


def _in_plane(excitation: np.ndarray) -> list[list[Pair]]:
    """Real and imaginary parts of `excitation` (k, n)."""
    return [[(float(x.real), float(x.imag)) for x in row] for row in excitation]


def record_direction(
    recorder: Recorder, waves: Jonswap | PiersonMoskowitz | Regular, *, fixed: bool = False
) -> Scalar:
    """The parameter `wave.direction` [rad]; `fixed`: it must keep its value."""
    text = "direction that the waves travel to, from +X towards +Y"
    start = math.radians(waves.direction)
    variable = Variable("wave.direction", "rad", text, start=start, display_unit="deg")
    if fixed:
        text = f"{text}; the coefficients are for this direction only"
        variable = replace(variable, description=text, minimum=start, maximum=start)
    return recorder.parameter(variable)


def excitation_in_space(
    coefficients: Coefficients,
    omega: np.ndarray,
    direction: Number,
    heading: Number,
    places: Sequence[tuple[Number, Number]],
) -> list[list[Pair]]:
    """Real and imaginary parts of the excitation of each component [N/m, N.m/m], and motion.

    For `omega` (k,) [rad/s], `direction` and `heading` [rad], reference `places` (x, y) [m] of the
    bodies; in the axes of the heading, with the phase of a crest at x = y = 0.
    """
    harmonics = coefficients.harmonics_at(omega)
    negligible = NEGLIGIBLE * np.abs(harmonics).max(axis=(0, 1))
    harmonics = np.where(np.abs(harmonics) > negligible, harmonics, 0.0)
    turns = _multiples(direction - heading, harmonics.shape[1] // 2)
    k = wavenumber(omega, depth=coefficients.depth, gravity=coefficients.gravity)
    ways = [x * cos(direction) + y * sin(direction) for x, y in places]
    table = []
    for number, own in zip(k.tolist(), harmonics, strict=True):
        phases = [(cos(number * way), sin(number * way)) for way in ways]
        row = []
        for i, column in enumerate(own.T):
            real, imaginary = _sum(column, turns)
            c, s = phases[i // coefficients.per_body]
            row.append((real * c - imaginary * s, real * s + imaginary * c))
        table.append(row)
    return table


def _multiples(angle: Number, most: int) -> list[Pair]:
    """cos jb and sin jb of an angle b, j = 0 … `most`."""
    first: Pair = (cos(angle), sin(angle))
    found: list[Pair] = [(1.0, 0.0)]
    for _ in range(most):
        c, s = found[-1]
        found.append((c * first[0] - s * first[1], s * first[0] + c * first[1]))
    return found


def _sum(harmonics: np.ndarray, turns: Sequence[Pair]) -> Pair:
    """Real and imaginary part of Σ harmonics[M + j] e^{ijb}, `harmonics` (2M + 1,)."""
    middle = len(harmonics) // 2
    real, imaginary = float(harmonics[middle].real), float(harmonics[middle].imag)
    total: Pair = (real, imaginary)
    for j in range(1, middle + 1):
        after, before = complex(harmonics[middle + j]), complex(harmonics[middle - j])
        even, odd = after + before, after - before
        c, s = turns[j]
        total = (
            total[0] + even.real * c - odd.imag * s,
            total[1] + even.imag * c + odd.real * s,
        )
    return total


def check_frequencies(
    waves: Jonswap | PiersonMoskowitz | Regular, coefficients: Coefficients
) -> None:
    """InputError if `waves` are shorter than those that the excitation was computed for."""
    known = float(coefficients.omega[-1])
    problem = waves_beyond(waves, known, coefficients.memory_limit)
    if problem:
        raise InputError.single(*problem)


def check_directions(
    waves: Jonswap | PiersonMoskowitz | Regular, coefficients: Coefficients
) -> None:
    """InputError if `waves` travel in a direction that the excitation was not computed for."""
    if coefficients.dimensions == 3:
        check_harmonics(coefficients)
    elif waves.direction != coefficients.wave_direction:
        raise InputError.single(
            f"the waves travel at {waves.direction:g} deg, the coefficients are for "
            f"{coefficients.wave_direction:g} deg",
            "compute the excitation for the direction of the waves",
        )


def check_harmonics(coefficients: Coefficients) -> None:
    """InputError if `coefficients` in space have the excitation for one direction only."""
    if not coefficients.has_harmonics:
        raise InputError.single(
            "the coefficients have no harmonics of the excitation over the wave direction",
            "compute the excitation for directions all around, or use still water",
        )


def record_components(
    recorder: Recorder, waves: Jonswap | PiersonMoskowitz | Regular
) -> tuple[np.ndarray, list[Scalar], list[Scalar]]:
    """Angular frequencies (k,) [rad/s], and recorded, k amplitudes [m] and phases [rad]."""
    if isinstance(waves, Regular):
        text = "height of the regular wave"
        height = Variable("wave.height", "m", text, start=waves.height, minimum=0.0)
        amplitudes = [0.5 * recorder.parameter(height)]
        omega, start = np.array([2 * math.pi / waves.period]), np.array([waves.phase])
    else:
        rng = np.random.Generator(np.random.PCG64(waves.seed))
        count = waves.components
        enhancement = waves.peak_enhancement if isinstance(waves, Jonswap) else 1.0
        edges = part_edges(2 * math.pi / waves.peak_period, count, enhancement=enhancement)
        omega = component_frequencies(edges, rng)
        start = component_phases(count, rng)
        amplitudes = _irregular_amplitudes(recorder, waves, omega, np.diff(edges))
    phases = []
    for k, (w, value) in enumerate(zip(omega, start, strict=True)):
        text = f"phase of the wave component of {w:.6g} rad/s at x = 0, t = 0"
        variable = Variable(f"wave.phase[{k + 1}]", "rad", text, start=float(value))
        phases.append(recorder.parameter(variable))
    return omega, amplitudes, phases


def _irregular_amplitudes(
    recorder: Recorder,
    waves: Jonswap | PiersonMoskowitz,
    omega: np.ndarray,
    widths: np.ndarray,
) -> list[Scalar]:
    def parameter(key: str, unit: str, text: str, limits: tuple[float, float]) -> Scalar:
        start, (low, high) = getattr(waves, key), limits
        variable = Variable(f"wave.{key}", unit, text, start=start, minimum=low, maximum=high)
        return recorder.parameter(variable)

    height = parameter("significant_height", "m", "significant wave height", (0.0, math.inf))
    low, high = (factor * waves.peak_period for factor in PERIODS)
    text = (
        f"peak period, {low:g} to {high:g} s: the components' frequencies are made for "
        f"{waves.peak_period:g} s and stay; for another sea change waves.peak_period and build anew"
    )
    period = parameter("peak_period", "s", text, (low, high))
    enhancement: Scalar | float = 1.0
    if isinstance(waves, Jonswap):
        text = "peak enhancement of the JONSWAP spectrum"
        enhancement = parameter("peak_enhancement", "1", text, PEAK_ENHANCEMENT)
    return component_amplitudes(
        omega.tolist(),
        widths.tolist(),
        significant_height=height,
        peak_period=period,
        enhancement=enhancement,
    )


def record_ramp(recorder: Recorder, waves: Jonswap | PiersonMoskowitz | Regular) -> Scalar | float:
    """½(1 − cos π t/T) until t = T = `wave.ramp_time`, then 1."""
    period = waves.period if isinstance(waves, Regular) else waves.peak_period
    start = RAMP_PERIODS * period if waves.ramp_time is None else waves.ramp_time
    if start == 0.0:
        return 1.0
    text = "time in which the sea grows from nothing"
    variable = Variable("wave.ramp_time", "s", text, start=start, minimum=0.0)
    length = recorder.parameter(variable)
    return 0.5 - 0.5 * cos(math.pi * minimum(recorder.time / maximum(length, SHORTEST), 1.0))
