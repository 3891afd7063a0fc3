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
from dataclasses import replace
from pathlib import Path

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import (
    AnyWaves,
    Current,
    Drag,
    Loads,
    Radiation,
)
from m4e_adapters.hydrodynamics.drift.bodies import matched_drifts, record_drifts, shown_motions
from m4e_adapters.hydrodynamics.drift.recording import Directed
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.drag import (
    InWater,
    record_drag,
    record_water_velocity,
)
from m4e_adapters.hydrodynamics.load.motions import Motions, Vector, record_motions
from m4e_adapters.hydrodynamics.load.outputs import (
    publish_added_mass,
    record_displacement,
    record_outputs,
)
from m4e_adapters.hydrodynamics.load.parts import record_hydrostatics, record_memory
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory, fit_radiation
from m4e_adapters.hydrodynamics.seas.excitation import towards_each
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import HullsInSea, RecordSea, record_sea
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder


def hydrodynamics_program(
    coefficients: Coefficients,
    *,
    name: str = "hydrodynamics",
    waves: AnyWaves | Sequence[WaveSystem] | None = None,
    drag: Mapping[str, Drag] | None = None,
    current: Current | None = None,
    radiation: Radiation | None = None,
    heading: Heading | None = None,
    loads: Loads | None = None,
    drift: Mapping[str, BodyDrift] | None = None,
    sea: RecordSea = record_sea,
    memory: RadiationMemory | None = None,
    folder: Path = Path(),
    progress: Callable[[str], object] = lambda _: None,
) -> Program:
    """The load on all bodies of `coefficients`, from any source of these.

    Parameters
    ----------
    waves : in directions that `coefficients` are for; None: still water.
    drag : drag by body name; bodies left out start with none (it stays tunable).
    current : of the water, which drag is relative to.
    radiation : kind and order of the radiation memory; None: a state space, automatic.
    heading : of the hulls, in space; None: 0.
    loads : the parts of the load that act; None: all. Those of the excitation must be what
        `coefficients` have (`excited_by`).
    drift : second-order drift by body name.
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
    acting, given, drags = loads or Loads(), drift or {}, drag or {}
    if coefficients.excited_by != acting.excitation:
        # the whole excitation, as files have it, cannot be divided
        wanted, known = (
            " and ".join(p) or "none" for p in (acting.excitation, coefficients.excited_by)
        )
        raise InputError.single(
            f"the loads have {wanted} of the excitation, the coefficients {known} as a whole",
            "switch froude_krylov and diffraction on, or give coefficients with their parts",
            keys=("loads",),
        )
    heading = heading or Heading()
    made = wave_systems(
        waves or (), depth=coefficients.depth, gravity=coefficients.gravity, folder=folder
    )
    systems = [
        own.within(float(coefficients.omega[0]), float(coefficients.omega[-1])) for own in made
    ]
    drifts = matched_drifts(given, systems, heading.angle, progress)
    directed = towards_each(coefficients, systems, heading=heading.angle)
    of_single = bool(systems) and coefficients.dimensions == 3 and not coefficients.has_harmonics
    if of_single or not all(isinstance(own, Directed) for own in drifts.values()):
        heading = replace(heading, fixed=True)
        systems = [replace(system, fixed=True) for system in systems]
    recorder = Recorder(name, f"linear hydrodynamics of {', '.join(coefficients.bodies)}")
    moved = record_motions(recorder, coefficients, heading)
    if memory is None and acting.radiation != "none":
        kind = radiation or Radiation()
        convolution = kind.memory == "convolution"
        memory = fit_radiation(
            coefficients, order=kind.order, convolution=convolution, progress=progress
        )
    parts: dict[str, Vector] = {}
    if memory is not None and acting.radiation != "none":
        parts["radiation"] = record_memory(recorder, memory.groups, coefficients, moved.velocity)
    hulls = _hulls(coefficients, moved, directed, acting, drags, current)
    met = sea(recorder, systems, coefficients, hulls)
    if excited_by := coefficients.excited_by:
        whole = excited_by[0] if len(excited_by) == 1 else "excitation"
        parts[whole] = met.excitation
    if acting.hydrostatics != "none":
        restoring = record_hydrostatics(recorder, coefficients, moved.displacement)
        parts = {"hydrostatic": restoring, **parts}
    if acting.drag != "none":
        water = record_water_velocity(
            recorder, coefficients, current, moved, hulls.in_water, met.velocities
        )
        parts["drag"] = record_drag(recorder, coefficients, drags, moved.velocity, water)
    if given:
        parts["drift"] = record_drifts(recorder, given, drifts, met.waves, coefficients, moved)
    for k, body in enumerate(coefficients.bodies):
        own = coefficients.own(k)
        shown = shown_motions(given.get(body), coefficients)
        acts = {kind: part[own] for kind, part in parts.items()}
        record_outputs(recorder, body, coefficients, acts, moved.axes, drifts=shown)
        held = () if acting.displaced else systems
        record_displacement(recorder, body, coefficients, moved.displacement[own], k, held)
    if "radiation" in parts and memory is not None:
        publish_added_mass(recorder, coefficients, memory.added_mass_inf, moved.axes)
    return recorder.program()


def _hulls(
    coefficients: Coefficients,
    moved: Motions,
    directed: Sequence[Coefficients],
    loads: Loads,
    drags: Mapping[str, Drag],
    current: Current | None,
) -> HullsInSea:
    """Where the waves are wanted: at bodies, and where drag acts.

    Where bodies are displaced, they meet the waves of where they have come to.
    """
    usual = "still" if current is None else "moving"
    in_water = [
        InWater(k, min(float(coefficients.places[k][2]), 0.0))
        for k, body in enumerate(coefficients.bodies if loads.drag != "none" else ())
        if (drags.get(body, Drag()).water or usual) == "moving"
    ]
    offsets = moved.offsets(coefficients) if loads.displaced else []
    return HullsInSea(
        directed,
        heading=moved.axes.angle if moved.axes else 0.0,
        places=moved.places,
        in_water=in_water,
        waters=[body.place(coefficients, moved.axes, offsets) for body in in_water],
        offsets=offsets,
    )
