"""The hydrodynamic load on floating bodies as a Program.

    F = F_b − K ξ − ∫ K(t − τ) v(τ) dτ + r(t) Re Σ X a_k e^{−i(ω_k t + φ_k)} − c |v| v + F_d

about each body's centre of gravity, world frame: ξ is the displacement (surge, heave, pitch) from
the reference pose, v its rate, F_b the buoyancy in the reference pose, r the ramp, F_d the drift
of second order (see `drift`). The dry weight
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
from m4e_adapters.hydrodynamics.config import (
    AnyWaves,
    BodyPoint,
    Current,
    Drag,
    Loads,
    Radiation,
)
from m4e_adapters.hydrodynamics.drift.bodies import (
    record_drifts,
    shown_motions,
)
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift
from m4e_adapters.hydrodynamics.heading import (
    Heading,
)
from m4e_adapters.hydrodynamics.load.body_points import (
    OnBody,
    points_on_bodies,
    record_air_gaps,
)
from m4e_adapters.hydrodynamics.load.drag import (
    InWater,
    bodies_in_moving_water,
    record_drag,
    record_water_velocity,
)
from m4e_adapters.hydrodynamics.load.matched_sea import MatchedSea, matched_sea
from m4e_adapters.hydrodynamics.load.motions import Motions, record_motions
from m4e_adapters.hydrodynamics.load.outputs import (
    publish_added_mass,
    record_displacement,
    record_outputs,
)
from m4e_adapters.hydrodynamics.load.parts import (
    record_hydrostatics,
    record_memory,
)
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory, fit_radiation
from m4e_adapters.hydrodynamics.seas.recorded_waves import Number
from m4e_adapters.hydrodynamics.seas.sea import RecordedSea, record_sea
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Triple
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder, Scalar

Vector = list[Scalar | float]


class RecordSea(Protocol):
    """Records waves and their excitation, in the axes of the heading."""

    def __call__(
        self,
        recorder: Recorder,
        waves: Sequence[WaveSystem],
        coefficients: Coefficients,
        *,
        directed: Sequence[Coefficients],
        heading: Number,
        places: Sequence[tuple[Number, Number]],
        gauges: Sequence[tuple[Number, Number]],
        waters: Sequence[Triple],
        offsets: Sequence[tuple[Number, Number]],
    ) -> RecordedSea:
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
    current: Current | None = None,
    radiation: Radiation | None = None,
    heading: Heading | None = None,
    loads: Loads | None = None,
    drift: Mapping[str, BodyDrift] | None = None,
    points: Mapping[str, BodyPoint] | None = None,
    sea: RecordSea = record_sea,
    memory: RadiationMemory | None = None,
    folder: Path = Path(),
    progress: Callable[[str], object] = _silent,
) -> Program:
    """The load on all bodies of `coefficients`, from any source of these.

    Parameters
    ----------
    waves : None for still water; otherwise they must travel in directions that `coefficients` are
        for.
    drag : drag by body name; bodies left out start with none (it stays tunable).
    current : of the water, which drag is relative to.
    radiation : kind and order of the radiation memory; None: a state space, automatic.
    heading : of the hulls, in space; None: 0.
    loads : the parts of the load that act; None: all. Those of the excitation must be what
        `coefficients` have (`excited_by`).
    drift : second-order drift by body name.
    points : of bodies, whose air gaps are outputs.
    sea : records the waves and gives the excitation of each motion.
    memory : of the radiation; None: it is fitted.
    folder : where files of the waves are.
    progress : is told the accuracy of the memory.

    Returns
    -------
    Program
        Inputs `<body>.{x,z,theta,vx,vz,omega}` of the centre of gravity, outputs
        `<body>.{force_x,force_z,moment_y}` about it, `wave.elevation`, and the parts
        `<body>.hydrostatic_…`, `radiation_…`, `excitation_…`, `drag_…`, `drift_…` of the force. In
        space also the inputs `<body>.{y,phi,psi,vy,omega_x,omega_z}` and `force_y`, `moment_x`,
        `moment_z`.
    """
    drifts, drags, acting = drift or {}, drag or {}, loads or Loads()
    _check_excitation(coefficients, acting)
    matched = matched_sea(
        coefficients, waves=waves, drift=drifts, heading=heading or Heading(), folder=folder,
        progress=progress,
    )  # fmt: skip
    recorder = Recorder(name, f"linear hydrodynamics of {', '.join(coefficients.bodies)}")
    moved = record_motions(recorder, coefficients, matched.heading)
    parts: dict[str, Vector] = {}
    fitted = None
    if acting.radiation != "none":
        fitted = memory or _fitted(coefficients, radiation or Radiation(), progress)
        parts["radiation"] = record_memory(recorder, fitted.groups, coefficients, moved.velocity)
    on_bodies = points_on_bodies(coefficients, points or {})
    acts_drag = acting.drag != "none"
    in_water = bodies_in_moving_water(coefficients, drags, current) if acts_drag else ()
    waves_on = _waves_on(
        sea, recorder, matched, coefficients, moved, on_bodies, in_water, displaced=acting.displaced
    )
    if coefficients.excited_by:
        parts[_excitation(coefficients)] = waves_on.excitation
    if acting.hydrostatics != "none":
        restoring = record_hydrostatics(recorder, coefficients, moved.displacement)
        parts = {"hydrostatic": restoring, **parts}
    if acts_drag:
        water = record_water_velocity(
            recorder, coefficients, current, moved, in_water, waves_on.velocities
        )
        parts["drag"] = record_drag(recorder, coefficients, drags, moved.velocity, water)
    if drifts:
        parts["drift"] = record_drifts(
            recorder, drifts, matched.drifts, waves_on.waves, coefficients, moved
        )
    _record_bodies(recorder, coefficients, parts, moved, matched.systems, drifts, acting)
    record_air_gaps(recorder, coefficients, moved, on_bodies, waves_on.levels)
    if fitted is not None:
        publish = recorder.output if matched.heading.filter_time else recorder.calculate
        publish_added_mass(publish, coefficients, fitted.added_mass_inf, moved.axes)
    return recorder.program()


def _fitted(
    coefficients: Coefficients, radiation: Radiation, progress: Callable[[str], object]
) -> RadiationMemory:
    """The radiation memory that is asked for."""
    convolution = radiation.memory == "convolution"
    return fit_radiation(
        coefficients, order=radiation.order, convolution=convolution, progress=progress
    )


def _waves_on(
    sea: RecordSea,
    recorder: Recorder,
    matched: MatchedSea,
    coefficients: Coefficients,
    moved: Motions,
    on_bodies: Sequence[OnBody],
    in_water: Sequence[InWater],
    *,
    displaced: bool,
) -> RecordedSea:
    """The waves as `sea` records them: at bodies, at points for air gaps, and where drag acts.

    Where bodies are `displaced`, they meet the waves of where they have come to.
    """
    offsets = moved.offsets(coefficients) if displaced else []
    waters = [body.place(coefficients, moved.reference, offsets) for body in in_water]
    return sea(
        recorder,
        matched.systems,
        coefficients,
        directed=matched.directed,
        heading=moved.axes.angle if moved.axes else 0.0,
        places=moved.places,
        gauges=[point.place(coefficients, moved.reference) for point in on_bodies],
        waters=waters,
        offsets=offsets,
    )


def _record_bodies(
    recorder: Recorder,
    coefficients: Coefficients,
    parts: Mapping[str, Vector],
    moved: Motions,
    waves: Sequence[WaveSystem],
    drifts: Mapping[str, BodyDrift],
    loads: Loads,
) -> None:
    """Wrench, its parts and displacement of each body."""
    held = () if loads.displaced else waves
    for k, body in enumerate(coefficients.bodies):
        own = coefficients.own(k)
        shown = shown_motions(drifts.get(body), coefficients)
        acts = {name: part[own] for name, part in parts.items()}
        record_outputs(recorder, body, coefficients, acts, moved.axes, drifts=shown)
        record_displacement(recorder, body, coefficients, moved.displacement[own], k, held)


def _check_excitation(coefficients: Coefficients, loads: Loads) -> None:
    """InputError if the excitation of `coefficients` consists of other parts than those of `loads`.

    The whole excitation, as files have it, cannot be divided without the part that is left out.
    """
    if coefficients.excited_by != loads.excitation:
        wanted, known = (
            " and ".join(p) or "none" for p in (loads.excitation, coefficients.excited_by)
        )
        raise InputError.single(
            f"the loads have {wanted} of the excitation, the coefficients {known} as a whole",
            "switch froude_krylov and diffraction on, or give coefficients with their parts",
            keys=("loads",),
        )


def _excitation(coefficients: Coefficients) -> str:
    """The name of what excites: excitation, or its only part."""
    parts = coefficients.excited_by
    return parts[0] if len(parts) == 1 else "excitation"
