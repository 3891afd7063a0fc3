"""The waves of a configuration, recorded: elevation at x = y = 0 and excitation forces.

With θ_k = ω_k t + φ_k the elevation is Σ a_k cos θ_k = Re Σ a_k e^{−iθ_k}, and the force
Σ a_k (Re X_k cos θ_k + Im X_k sin θ_k), over the components of all systems of waves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.seas.excitation import check_harmonics, excitation_of
from m4e_adapters.hydrodynamics.seas.systems import Number, WaveSystem
from m4e_fmi.errors import InputError
from m4e_fmi.program import Recorder, Variable, cos, sin

ELEVATION = "wave.elevation"


def needed_frequency(waves: Sequence[WaveSystem]) -> float:
    """Angular frequency [rad/s] up to which `waves` need computed excitation; 0 in still water.

    Of an irregular sea that is where 3 % of its energy is left. See `Coefficients.excitation_at`
    for shorter waves.
    """
    return max((system.needed for system in waves), default=0.0)


def waves_beyond(
    waves: Sequence[WaveSystem], highest: float, limit: float
) -> tuple[str, str] | None:
    """Problem and remedy if excitation computed up to `highest` [rad/s] is too little.

    Irregular seas may have more above `limit`, where waves are short for all bodies.
    """
    for system in waves:
        needed = system.needed
        falls = not system.regular and highest >= limit * (1 - 1e-9)
        if falls or needed <= highest * (1 + 1e-9):
            continue
        if system.regular:
            text = f"the wave has {needed:.4g} rad/s"
        else:
            text = f"the waves need excitation up to {needed:.4g} rad/s ({system.reach})"
            needed = min(needed, limit)
        return (
            f"{text}, the coefficients end at {highest:.4g} rad/s",
            f"raise frequencies.maximum to {needed:.4g} or leave it out, or use longer waves",
        )
    return None


def record_sea(
    recorder: Recorder,
    waves: Sequence[WaveSystem],
    coefficients: Coefficients,
    *,
    heading: Number = 0.0,
    places: Sequence[tuple[Number, Number]] = (),
    gauges: Mapping[str, tuple[Number, Number]] | None = None,
) -> tuple[list[Number], list[Number]]:
    """Record `wave.elevation`; the ramped excitation of each motion [N, N.m], in the hulls' axes.

    In space these have the `heading` [rad], and the bodies' reference `places` are (x, y) [m].
    Also the ramped elevation [m] at each of the `gauges`, places (x, y) [m] by name.
    """
    ways = list((gauges or {}).values())
    levels: list[Number] = [0.0] * len(ways)
    check_directions(waves, coefficients)
    check_frequencies(waves, coefficients)
    elevation: Number = 0.0
    forces: list[Number] = [0.0] * len(coefficients.motions)
    for system in waves:
        own = system.record(recorder, in_space=coefficients.dimensions == 3)
        table = excitation_of(coefficients, own, heading=heading, places=places)
        height: Number = 0.0
        pushes: list[Number] = [0.0] * len(forces)
        heights: list[Number] = [0.0] * len(ways)
        for k, row in enumerate(table):
            angle = own.omega[k] * recorder.time + own.phase[k]
            cosine, sine = cos(angle), sin(angle)
            height = height + own.amplitude[k] * cosine
            for i, (c, s) in enumerate(own.phases_at(k, ways)):
                heights[i] = heights[i] + own.amplitude[k] * (c * cosine + s * sine)
            for i, (real, imaginary) in enumerate(row):
                pushes[i] = pushes[i] + own.amplitude[k] * real * cosine
                pushes[i] = pushes[i] + own.amplitude[k] * imaginary * sine
        elevation = elevation + own.ramp * height
        forces = [force + own.ramp * push for force, push in zip(forces, pushes, strict=True)]
        levels = [
            level + own.ramp * own_level for level, own_level in zip(levels, heights, strict=True)
        ]
    recorder.output(elevation_at_origin(coefficients.dimensions), elevation)
    return forces, levels


def elevation_at_origin(dimensions: int) -> Variable:
    """The output `wave.elevation` of the plane (2) or of space (3)."""
    origin = "x = 0" if dimensions == 2 else "x = y = 0"
    return Variable(ELEVATION, "m", f"elevation of the undisturbed water at {origin}")


def check_frequencies(waves: Sequence[WaveSystem], coefficients: Coefficients) -> None:
    """InputError if `waves` are shorter than those that the excitation was computed for."""
    known = float(coefficients.omega[-1])
    problem = waves_beyond(waves, known, coefficients.memory_limit)
    if problem:
        raise InputError.single(*problem)


def check_directions(waves: Sequence[WaveSystem], coefficients: Coefficients) -> None:
    """InputError if `waves` travel in a direction that the excitation was not computed for."""
    if waves and coefficients.dimensions == 3:
        check_harmonics(coefficients)
        return
    for system in waves:
        if system.offsets.any() or system.direction != coefficients.wave_direction:
            raise InputError.single(
                f"the waves travel at {system.direction:g} deg"
                + (", and others" if system.offsets.any() else "")
                + f", the coefficients are for {coefficients.wave_direction:g} deg",
                "compute the excitation for the direction of the waves",
            )
