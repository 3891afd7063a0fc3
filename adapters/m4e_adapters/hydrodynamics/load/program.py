"""The hydrodynamic load on floating bodies as a Program.

    F = F_b − K ξ − ∫ K(t − τ) v(τ) dτ + r(t) Re Σ X a_k e^{−i(ω_k t + φ_k)} − c |v| v

about each body's centre of gravity, world frame: ξ is the displacement (surge, heave, pitch) from
the reference pose, v its rate, F_b the buoyancy in the reference pose, r the ramp. The dry weight
and A∞ times the acceleration are *not* in F: both belong to whoever holds the body's mass, to whom
A∞ is published as `added_mass[i,j]`.

In space all this is in axes turned about Z by the heading h, in which ξ has the yaw ψ − h and, for
roll and pitch, the rotation vector R_z(ψ − h) (φ, θ, 0): R_z(ψ) R_y(θ) R_x(φ) turns by it, but for
terms of the third order (of the second about Z, which no force depends on).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Protocol

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import AnyWaves, BodyPoint, Drag, Radiation, Still
from m4e_adapters.hydrodynamics.heading import (
    Heading,
)
from m4e_adapters.hydrodynamics.load.body_points import points_on_bodies, record_air_gaps
from m4e_adapters.hydrodynamics.load.motions import record_motions
from m4e_adapters.hydrodynamics.load.outputs import (
    publish_added_mass,
    record_displacement,
    record_outputs,
)
from m4e_adapters.hydrodynamics.load.parts import (
    record_drag,
    record_hydrostatics,
    record_memory,
)
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import record_sea
from m4e_adapters.hydrodynamics.seas.systems import Number, WaveSystem
from m4e_fmi.program import Program, Recorder, Scalar, Variable

Vector = list[Scalar | float]


class RecordSea(Protocol):
    """Records waves; the excitation of each motion [N, N.m], in the axes of the heading, and the
    elevation [m] at each of the `gauges`, which are places (x, y) [m] by name."""

    def __call__(
        self,
        recorder: Recorder,
        waves: Sequence[WaveSystem],
        coefficients: Coefficients,
        *,
        heading: Number,
        places: Sequence[tuple[Number, Number]],
        gauges: Mapping[str, tuple[Number, Number]],
    ) -> tuple[Vector, Vector]:
        """As `sea.record_sea`."""
        ...


def _silent(_: str) -> None:
    pass


def hydrodynamics_program(
    coefficients: Coefficients,
    *,
    name: str = "hydrodynamics",
    waves: AnyWaves | None = None,
    drag: Mapping[str, Drag] | None = None,
    radiation: Radiation | None = None,
    heading: Heading | None = None,
    points: Mapping[str, BodyPoint] | None = None,
    sea: RecordSea = record_sea,
    folder: Path = Path(),
    progress: Callable[[str], object] = _silent,
) -> Program:
    """The load on all bodies of `coefficients`, from any source of these.

    Parameters
    ----------
    waves : None for still water; otherwise it must travel in `coefficients.wave_direction`.
    drag : quadratic drag by body name; bodies left out start with none (it stays tunable).
    radiation : order of the radiation memory; None: automatic.
    heading : of the hulls, in space; None: 0.
    points : of bodies, whose air gaps are outputs.
    sea : records the waves and gives the excitation of each motion.
    folder : where files of the waves are.
    progress : is told the accuracy of the memory.

    Returns
    -------
    Program
        Inputs `<body>.{x,z,theta,vx,vz,omega}` of the centre of gravity, outputs
        `<body>.{force_x,force_z,moment_y}` about it, `wave.elevation`, and the parts
        `<body>.excitation_…`, `<body>.radiation_…` of the force. In space also the inputs
        `<body>.{y,phi,psi,vy,omega_x,omega_z}` and `force_y`, `moment_x`, `moment_z`.
    """
    turning = heading or Heading()
    systems = wave_systems(
        waves or Still(spectrum="still"),
        depth=coefficients.depth,
        gravity=coefficients.gravity,
        folder=folder,
        band=(float(coefficients.omega[0]), float(coefficients.omega[-1])),
    )
    recorder = Recorder(name, f"linear hydrodynamics of {', '.join(coefficients.bodies)}")
    moved = record_motions(recorder, coefficients, turning)
    fitted = fit_radiation(
        coefficients, order=radiation.order if radiation else None, progress=progress
    )
    memory = record_memory(recorder, fitted.groups, coefficients, moved.velocity)
    angle = moved.axes.angle if moved.axes else 0.0
    on_bodies = points_on_bodies(coefficients, points or {})
    gauges = {point.name: point.place(coefficients, moved.reference) for point in on_bodies}
    excitation, elevations = sea(
        recorder, systems, coefficients, heading=angle, places=moved.places, gauges=gauges
    )
    restoring, carried = record_hydrostatics(recorder, coefficients, moved.displacement)
    for k, body in enumerate(coefficients.bodies):
        own = coefficients.own(k)
        resistance = record_drag(
            recorder, body, coefficients, (drag or {}).get(body, Drag()), moved.velocity[own]
        )
        parts = (restoring[own], memory[own], excitation[own], resistance)
        record_outputs(recorder, body, coefficients, parts, moved.axes)
        record_displacement(recorder, body, coefficients, moved.displacement[own], k, systems)
        text = f"mass of the water that {body} displaces in the reference pose"
        neutral = Variable(f"{body}.neutral_mass", "kg", text)
        recorder.calculate(neutral, carried[k] / coefficients.gravity)
    record_air_gaps(recorder, coefficients, moved, on_bodies, elevations)
    publish = recorder.output if turning.filter_time else recorder.calculate
    publish_added_mass(publish, coefficients, fitted.added_mass_inf, moved.axes)
    return recorder.program()
