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

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Protocol

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Drag, Radiation, Still
from m4e_adapters.hydrodynamics.geometry.motions import PLANE, SPACE, SWAY, YAW, mass_unit
from m4e_adapters.hydrodynamics.heading import (
    Axes,
    Heading,
    record_filter,
    record_heading,
    reference_places,
)
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation
from m4e_adapters.hydrodynamics.memory.radiation_group import RadiationGroup
from m4e_adapters.hydrodynamics.sea import AnyWaves, Number, record_sea
from m4e_adapters.hydrodynamics.small_motions import motion_ranges
from m4e_fmi.program import Program, Recorder, Scalar, Variable, atan2

Vector = list[Scalar | float]


class RecordSea(Protocol):
    """Records waves; the excitation of each motion [N, N.m], in the axes of the heading."""

    def __call__(
        self,
        recorder: Recorder,
        waves: AnyWaves,
        coefficients: Coefficients,
        *,
        heading: Number,
        places: Sequence[tuple[Number, Number]],
    ) -> Vector:
        """As `sea.record_sea`."""
        ...


YAW_PLACE = SPACE.index(YAW)
ANGLES = ", R = R_z(psi) R_y(theta) R_x(phi) from body to world axes"
SMALL = 1e-9  # relative: stiffness and added mass below it are panels' noise


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
    sea: RecordSea = record_sea,
    progress: Callable[[str], object] = _silent,
) -> Program:
    """The load on all bodies of `coefficients`, from any source of these.

    Parameters
    ----------
    waves : None for still water; otherwise it must travel in `coefficients.wave_direction`.
    drag : quadratic drag by body name; bodies left out start with none (it stays tunable).
    radiation : order of the radiation memory; None: automatic.
    heading : of the hulls, in space; None: 0.
    sea : records the waves and gives the excitation of each motion.
    progress : is told the accuracy of the memory.

    Returns
    -------
    Program
        Inputs `<body>.{x,z,theta,vx,vz,omega}` of the centre of gravity, outputs
        `<body>.{force_x,force_z,moment_y}` about it, `wave.elevation`, and the parts
        `<body>.excitation_…`, `<body>.radiation_…` of the force. In space also the inputs
        `<body>.{y,phi,psi,vy,omega_x,omega_z}` and `force_y`, `moment_x`, `moment_z`.
    """
    waves, turning = waves or Still(spectrum="still"), heading or Heading()
    recorder = Recorder(name, f"linear hydrodynamics of {', '.join(coefficients.bodies)}")
    moved = _record_motions(recorder, coefficients, turning)
    fitted = fit_radiation(
        coefficients, order=radiation.order if radiation else None, progress=progress
    )
    memory = _record_memory(recorder, fitted.groups, coefficients, moved.velocity)
    angle = moved.axes.angle if moved.axes else 0.0
    excitation = sea(recorder, waves, coefficients, heading=angle, places=moved.places)
    restoring, carried = _record_hydrostatics(recorder, coefficients, moved.displacement)
    for k, body in enumerate(coefficients.bodies):
        own = coefficients.own(k)
        resistance = _record_drag(
            recorder, body, coefficients, (drag or {}).get(body, Drag()), moved.velocity[own]
        )
        parts = (restoring[own], memory[own], excitation[own], resistance)
        _record_outputs(recorder, body, coefficients, parts, moved.axes)
        _record_displacement(recorder, body, coefficients, moved.displacement[own], k, waves)
        text = f"mass of the water that {body} displaces in the reference pose"
        neutral = Variable(f"{body}.neutral_mass", "kg", text)
        recorder.calculate(neutral, carried[k] / coefficients.gravity)
    publish = recorder.output if turning.filter_time else recorder.calculate
    _publish_added_mass(publish, coefficients, fitted.added_mass_inf, moved.axes)
    return recorder.program()


@dataclass(frozen=True)
class _Motions:
    """Of all bodies, displacement and velocity in the axes of the heading, in space `axes`.

    `places` are the reference places (x, y) [m] of the bodies in space, in world axes.
    """

    displacement: Vector
    velocity: Vector
    axes: Axes | None = None
    places: Sequence[tuple[Number, Number]] = ()


def _record_motions(recorder: Recorder, coefficients: Coefficients, heading: Heading) -> _Motions:
    """Inputs of all bodies, and in space the heading."""
    if coefficients.dimensions == 2:
        return _Motions(*_record_inputs(recorder, coefficients, heading))
    reference, axes = record_heading(recorder, heading)
    position, velocity = _record_inputs(recorder, coefficients, heading)
    record_filter(recorder, heading, axes, position[YAW_PLACE])
    places = reference_places(coefficients.centers, reference)
    displacement = _in_heading_axes(position, axes, places, coefficients.centers)
    return _Motions(displacement, axes.from_world(velocity), axes, places)


def _record_inputs(
    recorder: Recorder, coefficients: Coefficients, heading: Heading
) -> tuple[Vector, Vector]:
    """Inputs of all bodies, positions and velocities."""
    bodies = range(len(coefficients.bodies))
    motions = [_record_motion(recorder, coefficients, k, heading) for k in bodies]
    position, velocity = ([*chain(*part)] for part in zip(*motions, strict=True))
    return position, velocity


def _record_motion(
    recorder: Recorder, coefficients: Coefficients, k: int, heading: Heading
) -> tuple[Vector, Vector]:
    """Inputs of a body, positions and velocities.

    Those of the plane are relative to the reference pose, with the centre of gravity there.
    """
    body, motions = coefficients.bodies[k], coefficients.body_motions
    in_plane = coefficients.dimensions == 2
    x, y, z = _start(coefficients, k, heading)
    starts = {"x": x, "y": y, "z": z, "psi": math.radians(heading.angle)}
    position: Vector = []
    velocity: Vector = []
    for motion in motions:
        start = starts.get(motion.position, 0.0)
        name = f"{motion.position} of the centre of gravity"
        text = f"{motion.name} angle" if motion.is_rotation else name
        text += ", world frame" if motion in PLANE or motion is SWAY else ANGLES
        variable = Variable(f"{body}.{motion.position}", motion.unit, text, start=start)
        value = recorder.input(variable)
        position.append(value - start if in_plane else value)
    for motion in motions:
        text = f"rate of {body}.{motion.position}, world frame"
        if motion.is_rotation and not in_plane:
            text = f"angular velocity about +{'XYZ'[motions.index(motion) - 3]}, world frame"
        variable = Variable(f"{body}.{motion.velocity}", f"{motion.unit}/s", text)
        velocity.append(recorder.input(variable))
    return position, velocity


def _start(coefficients: Coefficients, k: int, heading: Heading) -> tuple[float, float, float]:
    """The centre of gravity (x, y, z) [m] of a body in the reference pose."""
    centers = coefficients.places
    x, y = centers[k, :2]
    if heading.angle:
        x, y = reference_places(centers, Axes.at(math.radians(heading.angle)))[k]
    return float(x), float(y), float(centers[k, 2])


def _in_heading_axes(
    position: Vector, axes: Axes, places: list[tuple[Number, Number]], centers: np.ndarray
) -> Vector:
    """Displacements from the reference pose, in the axes of the heading."""
    found: Vector = []
    for k, (x, y) in enumerate(places):
        own = position[6 * k : 6 * k + 6]
        moved = axes.from_world([own[0] - x, own[1] - y, own[2] - float(centers[k, 2]), 0, 0, 0])
        yaw = Axes.at(own[YAW_PLACE] - axes.angle)
        roll, pitch = yaw.to_world([0, 0, 0, own[3], own[4], 0])[3:5]
        found += [*moved[:3], roll, pitch, atan2(yaw.sine, yaw.cosine)]
    return found


def _record_memory(
    recorder: Recorder,
    groups: tuple[RadiationGroup, ...],
    coefficients: Coefficients,
    velocity: Vector,
) -> Vector:
    """States of the radiation memory and the force they make, −∫ K v dτ.

    Each pole p = σ ± jω of a group has, for each of its motions' velocities v, the block
    ẋ₁ = σ x₁ + ω x₂ + 2 v, ẋ₂ = −ω x₁ + σ x₂ (a real pole: ẋ = σ x + v); the residue r of a force
    adds Re r x₁ + Im r x₂ to it.
    """
    force: Vector = [0.0] * len(velocity)
    count = dict.fromkeys(coefficients.bodies, 0)

    def state(place: int) -> tuple[str, Scalar]:
        k, own = divmod(place, coefficients.per_body)
        body, motion = coefficients.bodies[k], coefficients.body_motions[own]
        count[body] += 1
        name = f"{body}.radiation_state[{count[body]}]"
        text = f"memory of {body}'s {motion.name}"
        return name, recorder.state(Variable(name, motion.unit, text, local=True))

    for group in groups:
        for column, motion in enumerate(group.motions):
            v = velocity[motion]
            for pole, residue in zip(group.poles, group.residues, strict=True):
                sigma, omega = float(pole.real), float(pole.imag)
                name, first = state(motion)
                if omega > 0:
                    other, second = state(motion)
                    recorder.rate(name, sigma * first + omega * second + 2.0 * v)
                    recorder.rate(other, sigma * second - omega * first)
                else:
                    second = None
                    recorder.rate(name, sigma * first + v)
                for row, target in enumerate(group.motions):
                    r = residue[row, column]
                    force[target] = force[target] - float(r.real) * first
                    if second is not None:
                        force[target] = force[target] - float(r.imag) * second
    return force


def _record_hydrostatics(
    recorder: Recorder, coefficients: Coefficients, displacement: Vector
) -> tuple[Vector, Vector]:
    """Buoyancy in the reference pose less stiffness times displacement; both are parameters.

    Also what the water carries of each body in the reference pose, (N,).
    """
    force: Vector = []
    carried: Vector = [0.0] * len(coefficients.bodies)
    for k, body in enumerate(coefficients.bodies):
        own, motions = coefficients.own(k), coefficients.body_motions
        stiffness = coefficients.hydrostatic_stiffness[own, own]
        buoyancy = coefficients.buoyancy[own]
        for i, motion in enumerate(motions):
            symbol, unit = motion.force, motion.force_unit
            total: Scalar | float = 0.0
            if abs(buoyancy[i]) > SMALL * max(abs(coefficients.buoyancy).max(), 1e-300):
                text = f"{symbol} of the still water in the reference pose"
                start = float(buoyancy[i])
                total = recorder.parameter(
                    Variable(f"{body}.buoyancy_{symbol}", unit, text, start=start)
                )
                if symbol == "force_z":
                    carried[k] = total
            for j, other in enumerate(motions):
                if abs(stiffness[i, j]) <= SMALL * abs(stiffness).max(initial=0.0):
                    continue
                text = f"hydrostatic stiffness: {symbol} per {other.name}"
                variable = Variable(
                    f"{body}.hydrostatic_stiffness[{i + 1},{j + 1}]",
                    f"{unit}/{other.unit}",
                    text,
                    start=float(stiffness[i, j]),
                )
                total = total - recorder.parameter(variable) * displacement[own][j]
            force.append(total)
    return force, carried


def _record_displacement(
    recorder: Recorder,
    body: str,
    coefficients: Coefficients,
    displacement: Vector,
    k: int,
    waves: AnyWaves,
) -> None:
    """Outputs surge, heave, pitch, … from the reference pose, with the limits of small motions."""
    limits = motion_ranges(coefficients, k, waves)
    for motion, value in zip(coefficients.body_motions, displacement, strict=True):
        limit = limits[motion.name]
        text = f"{motion.name} from the reference pose"
        if not limit.is_open:
            text += f"; {limit.reason}"
        variable = Variable(
            f"{body}.{motion.name}", motion.unit, text, minimum=limit.minimum, maximum=limit.maximum
        )
        recorder.output(variable, value)


def _record_drag(
    recorder: Recorder, body: str, coefficients: Coefficients, drag: Drag, velocity: Vector
) -> Vector:
    force: Vector = []
    for motion, v in zip(coefficients.body_motions, velocity, strict=True):
        variable = Variable(
            f"{body}.drag_{motion.name}",
            motion.drag_unit,
            f"quadratic drag in {motion.name}: force -c |v| v",
            start=getattr(drag, motion.name),
            minimum=0.0,
            tunable=True,
        )
        force.append(-recorder.parameter(variable) * abs(v) * v)
    return force


def _record_outputs(
    recorder: Recorder,
    body: str,
    coefficients: Coefficients,
    parts: tuple[Vector, ...],
    axes: Axes | None,
) -> None:
    """The wrench on a body and two of its parts; `parts` as the program sums them."""
    motions = coefficients.body_motions

    def in_world(vector: Vector) -> Vector:
        return axes.to_world(vector) if axes else vector

    _, memory, excitation, _ = parts
    wrench = list(parts[0])
    for part in parts[1:]:
        wrench = [total + value for total, value in zip(wrench, part, strict=True)]
    for motion, total in zip(motions, in_world(wrench), strict=True):
        symbol, unit = motion.force, motion.force_unit
        text = f"{symbol} of the water on {body} about its centre of gravity, world frame"
        recorder.output(Variable(f"{body}.{symbol}", unit, text), total)
    for kind, part in (("excitation", excitation), ("radiation", memory)):
        for motion, value in zip(motions, in_world(part), strict=True):
            symbol, unit = motion.force, motion.force_unit
            text = f"part of {body}.{symbol}: wave {kind}"
            if kind == "radiation":
                text = f"part of {body}.{symbol}: radiation memory, without added_mass"
            recorder.output(Variable(f"{body}.{kind}_{symbol}", unit, text), value)


def _publish_added_mass(
    publish: Callable[[Variable, Scalar | float], None],
    coefficients: Coefficients,
    matrix: np.ndarray,
    axes: Axes | None,
) -> None:
    """A∞ in world axes. Connections read from the descriptions which bodies rows are for."""
    scale = np.sqrt(np.maximum(np.abs(matrix.diagonal()), 1e-300))
    kept = np.where(np.abs(matrix) > SMALL * np.outer(scale, scale), matrix, 0.0)
    in_world = axes.matrix_to_world(kept) if axes else kept.tolist()
    names, kinds = coefficients.motions, coefficients.body_motions * len(coefficients.bodies)
    for i, (row, values) in enumerate(zip(names, in_world, strict=True)):
        for j, (column, value) in enumerate(zip(names, values, strict=True)):
            variable = Variable(
                f"added_mass[{i + 1},{j + 1}]",
                mass_unit(kinds[i], kinds[j]),
                f"added mass at infinite frequency: {row} per acceleration in {column}",
            )
            publish(variable, value)
