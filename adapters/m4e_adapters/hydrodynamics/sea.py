"""The waves of a configuration, recorded: elevation at x = 0 and excitation forces.

With θ_k = ω_k t + φ_k the elevation is Σ a_k cos θ_k = Re Σ a_k e^{−iθ_k}, and the force
Σ a_k (Re X_k cos θ_k + Im X_k sin θ_k). Height, period and peak enhancement are parameters of the
program, the components' frequencies are not: amplitudes follow the parameters, frequencies stay.
"""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Jonswap, PiersonMoskowitz, Regular, Still
from m4e_adapters.hydrodynamics.waves import (
    BAND,
    component_amplitudes,
    component_frequencies,
    component_phases,
)
from m4e_fmi.errors import InputError
from m4e_fmi.program import Recorder, Scalar, Variable, cos, maximum, minimum, sin

AnyWaves = Jonswap | PiersonMoskowitz | Regular | Still
SHORTEST = 1e-9  # ramp [s], so that a ramp_time set to 0 is none
RAMP_PERIODS = 2.0  # default length of the ramp in (peak) periods


def highest_frequency(waves: AnyWaves) -> float:
    """The highest angular frequency [rad/s] that `waves` can contain, 0 for still water."""
    if isinstance(waves, Still):
        return 0.0
    if isinstance(waves, Regular):
        return 2 * math.pi / waves.period
    return BAND[1] * 2 * math.pi / waves.peak_period


def record_sea(
    recorder: Recorder, waves: AnyWaves, coefficients: Coefficients
) -> list[Scalar | float]:
    """Record `wave.elevation`; the ramped excitation force of each motion [N, N, N.m]."""
    forces: list[Scalar | float] = [0.0] * len(coefficients.motions)
    text = "elevation of the undisturbed water at x = 0"
    if isinstance(waves, Still):
        recorder.output(Variable("wave.elevation", "m", text), 0.0)
        return forces
    _check(waves, coefficients)
    omega, amplitudes, phases = _components(recorder, waves)
    table = coefficients.excitation_at(omega)
    ramp = _ramp(recorder, waves)
    elevation: Scalar | float = 0.0
    for k, (w, amplitude, phase) in enumerate(zip(omega, amplitudes, phases, strict=True)):
        angle = float(w) * recorder.time + phase
        cosine, sine = cos(angle), sin(angle)
        elevation = elevation + amplitude * cosine
        for i in range(len(forces)):
            x = table[k, i]
            forces[i] = forces[i] + amplitude * float(x.real) * cosine
            forces[i] = forces[i] + amplitude * float(x.imag) * sine
    recorder.output(Variable("wave.elevation", "m", text), ramp * elevation)
    return [ramp * force for force in forces]


def _check(waves: Jonswap | PiersonMoskowitz | Regular, coefficients: Coefficients) -> None:
    highest, known = highest_frequency(waves), float(coefficients.omega[-1])
    if highest > known * (1 + 1e-9):
        raise InputError.single(
            f"the waves reach {highest:.4g} rad/s, the coefficients only {known:.4g} rad/s",
            f"raise frequencies.maximum to {highest:.4g}, or use longer waves",
        )
    if waves.direction != coefficients.wave_direction:
        raise InputError.single(
            f"the waves travel at {waves.direction:g} deg, the coefficients are for "
            f"{coefficients.wave_direction:g} deg",
            "compute the excitation for the direction of the waves",
        )


def _components(
    recorder: Recorder, waves: Jonswap | PiersonMoskowitz | Regular
) -> tuple[np.ndarray, list[Scalar], list[Scalar]]:
    """Angular frequencies [rad/s], amplitudes [m] and phases [rad]; the last two recorded."""
    if isinstance(waves, Regular):
        height = Variable("wave.height", "m", "height of the regular wave", start=waves.height)
        amplitudes = [0.5 * recorder.parameter(height)]
        omega, start = np.array([2 * math.pi / waves.period]), np.array([waves.phase])
    else:
        rng = np.random.Generator(np.random.PCG64(waves.seed))
        count = waves.components
        omega = component_frequencies(2 * math.pi / waves.peak_period, count, rng)
        start = component_phases(count, rng)
        amplitudes = _irregular_amplitudes(recorder, waves, omega)
    phases = []
    for k, (w, value) in enumerate(zip(omega, start, strict=True)):
        text = f"phase of the wave component of {w:.6g} rad/s at x = 0, t = 0"
        variable = Variable(f"wave.phase[{k + 1}]", "rad", text, start=float(value))
        phases.append(recorder.parameter(variable))
    return omega, amplitudes, phases


def _irregular_amplitudes(
    recorder: Recorder, waves: Jonswap | PiersonMoskowitz, omega: np.ndarray
) -> list[Scalar]:
    def parameter(key: str, unit: str, text: str) -> Scalar:
        start = getattr(waves, key)
        return recorder.parameter(Variable(f"wave.{key}", unit, text, start=start))

    height = parameter("significant_height", "m", "significant wave height")
    period = parameter("peak_period", "s", "peak period; the components' frequencies stay")
    enhancement: Scalar | float = 1.0
    if isinstance(waves, Jonswap):
        enhancement = parameter("peak_enhancement", "1", "peak enhancement of the JONSWAP spectrum")
    return component_amplitudes(
        omega.tolist(), significant_height=height, peak_period=period, enhancement=enhancement
    )


def _ramp(recorder: Recorder, waves: Jonswap | PiersonMoskowitz | Regular) -> Scalar | float:
    """½(1 − cos π t/T) until t = T = `wave.ramp_time`, then 1."""
    period = waves.period if isinstance(waves, Regular) else waves.peak_period
    start = RAMP_PERIODS * period if waves.ramp_time is None else waves.ramp_time
    if start == 0.0:
        return 1.0
    text = "time in which the sea grows from nothing"
    length = recorder.parameter(Variable("wave.ramp_time", "s", text, start=start))
    return 0.5 - 0.5 * cos(math.pi * minimum(recorder.time / maximum(length, SHORTEST), 1.0))
