"""The waves of a configuration, recorded: elevation at x = y = 0 and excitation forces.

With θ_k = ω_k t + φ_k the elevation is Σ a_k cos θ_k = Re Σ a_k e^{−iθ_k}, and the force
Σ a_k (Re X_k cos θ_k + Im X_k sin θ_k), over the components of all systems of waves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.load.drag import InWater
from m4e_adapters.hydrodynamics.seas.excitation import excitation_of
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import (
    Number,
    RecordedFlow,
    RecordedWaves,
    Triple,
)
from m4e_fmi.errors import InputError
from m4e_fmi.program import Recorder, Variable, cos, sin

ELEVATION = "wave.elevation"
ELEVATION_INPUT = "wave.elevation_input"


@dataclass(frozen=True)
class RecordedSea:
    """The excitation of each motion [N, N.m], in the hulls' axes, and the `waves` that make it.

    Without waves, if they are not those of a sea. `velocities` (x, y, z) [m/s] are those of the
    waters.
    """

    excitation: list[Number]
    waves: tuple[RecordedWaves, ...] = field(default=(), repr=False)
    velocities: tuple[Triple, ...] = ()


@dataclass(frozen=True)
class HullsInSea:
    """How hulls meet the waves, and where else these are wanted.

    `directed` are the coefficients for each system, of `towards_each`. In space the axes of the
    hulls have the `heading` [rad], and the bodies' reference `places` are (x, y) [m]; with
    `offsets` (x, y) [m] of the bodies from there the excitation is that where they are. Wanted is
    the velocity at the bodies `in_water`, at `waters` (x, y, z) [m], z ≤ 0.
    """

    directed: Sequence[Coefficients]
    heading: Number = 0.0
    places: Sequence[tuple[Number, Number]] = ()
    in_water: Sequence[InWater] = ()
    waters: Sequence[Triple] = ()
    offsets: Sequence[tuple[Number, Number]] = ()


RecordSea = Callable[
    [Recorder, Sequence[WaveSystem], Coefficients, HullsInSea],
    RecordedSea,
]
"""Records waves, or inputs in place of them, and their excitation in the axes of the heading."""


def needed_frequency(waves: Sequence[WaveSystem]) -> float:
    """Angular frequency [rad/s] up to which `waves` need computed excitation; 0 in still water.

    Of an irregular sea that is where 3 % of its energy is left. See `Coefficients.excitation_at`
    for shorter waves.
    """
    return max((system.needed for system in waves), default=0.0)


def check_frequencies(
    waves: Sequence[WaveSystem],
    highest: float,
    limit: float,
    *,
    keys: tuple[str | int, ...] = ("waves",),
) -> None:
    """InputError at `keys` if excitation that is known up to `highest` [rad/s] is too little.

    Irregular seas may have more above `limit` [rad/s], where waves are short for all bodies.
    """
    for system in waves:
        needed = system.needed
        falls = not system.regular and highest >= limit * (1 - 1e-9)
        if falls or needed <= highest * (1 + 1e-9):
            continue
        text = f"the wave has {needed:.4g} rad/s"
        if not system.regular:
            text = f"the waves need excitation up to {needed:.4g} rad/s ({system.reach})"
            needed = min(needed, limit)
        raise InputError.single(
            f"{text}, the coefficients end at {highest:.4g} rad/s",
            "use longer waves, or coefficients that reach "
            f"{needed:.4g} rad/s (raise frequencies.maximum, or leave it out)",
            keys=keys,
        )


def record_sea(
    recorder: Recorder,
    waves: Sequence[WaveSystem],
    coefficients: Coefficients,
    hulls: HullsInSea,
) -> RecordedSea:
    """Record `wave.elevation`, the waves and their ramped excitation, in the axes of the hulls.

    The velocity of the waters is ramped too, and of linear theory.
    """
    check_frequencies(waves, float(coefficients.omega[-1]), coefficients.memory_limit)
    elevation: Number = 0.0
    forces: list[Number] = [0.0] * len(coefficients.motions)
    recorded = list[RecordedWaves]()
    for system, known in zip(waves, hulls.directed, strict=True):
        own = system.record(recorder, in_space=coefficients.dimensions == 3)
        recorded.append(own)
        height, pushes = _summed(recorder, own, known, coefficients, hulls)
        elevation = elevation + own.ramp * height
        forces = [force + own.ramp * push for force, push in zip(forces, pushes, strict=True)]
    recorder.output(elevation_at_origin(coefficients.dimensions), elevation)
    water = Water(depth=coefficients.depth, gravity=coefficients.gravity)
    flow = RecordedFlow(water, recorder.time, recorded)
    velocities = tuple(flow.linear_velocity(place) for place in hulls.waters)
    return RecordedSea(forces, tuple(recorded), velocities)


def _summed(
    recorder: Recorder,
    waves: RecordedWaves,
    known: Coefficients,
    coefficients: Coefficients,
    hulls: HullsInSea,
) -> tuple[Number, list[Number]]:
    """Sums over the components of a system, without its ramp.

    The elevation at x = y = 0 [m], and the excitation of each motion [N, N.m] by the coefficients
    `known` for the system.
    """
    table = excitation_of(known, waves, heading=hulls.heading, places=hulls.places)
    height: Number = 0.0
    pushes: list[Number] = [0.0] * len(coefficients.motions)
    for k, row in enumerate(table):
        angle = waves.omega[k] * recorder.time + waves.phase[k]
        cosine, sine = cos(angle), sin(angle)
        height = height + waves.amplitude[k] * cosine
        moved = [(cosine, sine)] * len(coefficients.bodies)
        for body, (c, s) in enumerate(waves.phases_at(k, hulls.offsets)):
            moved[body] = (c * cosine + s * sine, c * sine - s * cosine)
        for i, (real, imaginary) in enumerate(row):
            c, s = moved[i // coefficients.per_body]
            pushes[i] = pushes[i] + waves.amplitude[k] * real * c
            pushes[i] = pushes[i] + waves.amplitude[k] * imaginary * s
    return height, pushes


def elevation_at_origin(dimensions: int) -> Variable:
    """The output `wave.elevation` of the plane (2) or of space (3)."""
    origin = "x = 0" if dimensions == 2 else "x = y = 0"
    return Variable(ELEVATION, "m", f"elevation of the undisturbed water at {origin}")


def record_elevation_input(recorder: Recorder, dimensions: int) -> None:
    """Record the input `ELEVATION_INPUT` [m] in place of waves, and the output that it is."""
    text = "elevation of the undisturbed water at x = y = 0"
    elevation = recorder.input(Variable(ELEVATION_INPUT, "m", text))
    recorder.output(elevation_at_origin(dimensions), elevation)
