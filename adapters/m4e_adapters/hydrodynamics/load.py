"""The hydrodynamic load on floating bodies as a Program.

    F = F_b − K ξ − ∫ K(t − τ) v(τ) dτ + r(t) Re Σ X a_k e^{−i(ω_k t + φ_k)} − c |v| v

about each body's centre of gravity, world frame: ξ is the displacement (surge, heave, pitch) from
the reference pose, v its rate, F_b the buoyancy in the reference pose, r the ramp. The dry weight
and A∞ times the acceleration are *not* in F: both belong to whoever holds the body's mass, to whom
A∞ is published as `added_mass[i,j]`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import MOTIONS, Coefficients
from m4e_adapters.hydrodynamics.config import Drag, Radiation, Still
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation
from m4e_adapters.hydrodynamics.memory.radiation_group import RadiationGroup
from m4e_adapters.hydrodynamics.sea import AnyWaves, record_sea
from m4e_adapters.hydrodynamics.small_motions import motion_ranges
from m4e_fmi.program import Program, Recorder, Scalar, Variable

Vector = list[Scalar | float]

POSITION = (("x", "m"), ("z", "m"), ("theta", "rad"))
VELOCITY = (("vx", "m/s"), ("vz", "m/s"), ("omega", "rad/s"))
WRENCH = (("force_x", "N"), ("force_z", "N"), ("moment_y", "N.m"))
DRAG_UNIT = ("N.s2/m2", "N.s2/m2", "N.m.s2/rad2")
STATE_UNIT = ("m", "m", "rad")
MASS_UNIT = (("kg", "kg", "kg.m"), ("kg", "kg", "kg.m"), ("kg.m", "kg.m", "kg.m2"))
STIFFNESS_UNIT = (
    ("N/m", "N/m", "N/rad"),
    ("N/m", "N/m", "N/rad"),
    ("N.m/m", "N.m/m", "N.m/rad"),
)
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
    progress: Callable[[str], object] = _silent,
) -> Program:
    """The load on all bodies of `coefficients`, from any source of these.

    Parameters
    ----------
    waves : None for still water; otherwise it must travel in `coefficients.wave_direction`.
    drag : quadratic drag by body name; bodies left out start with none (it stays tunable).
    radiation : order of the radiation memory; None: automatic.
    progress : is told the accuracy of the memory.

    Returns
    -------
    Program
        Inputs `<body>.{x,z,theta,vx,vz,omega}` of the centre of gravity, outputs
        `<body>.{force_x,force_z,moment_y}` about it, `wave.elevation`, and the parts
        `<body>.excitation_…`, `<body>.radiation_…` of the force.
    """
    bodies = coefficients.bodies
    recorder = Recorder(name, f"linear hydrodynamics of {', '.join(bodies)}")
    displacement: Vector = []
    velocity: Vector = []
    for k, body in enumerate(bodies):
        xi, v = _record_motion(recorder, body, coefficients.centers[k])
        displacement += xi
        velocity += v
    fitted = fit_radiation(
        coefficients, order=radiation.order if radiation else None, progress=progress
    )
    memory = _record_memory(recorder, fitted.groups, bodies, velocity)
    excitation = record_sea(recorder, waves or Still(), coefficients)
    restoring, carried = _record_hydrostatics(recorder, coefficients, displacement)
    for k, body in enumerate(bodies):
        own = slice(3 * k, 3 * k + 3)
        resistance = _record_drag(recorder, body, (drag or {}).get(body, Drag()), velocity[own])
        parts = (restoring[own], memory[own], excitation[own], resistance)
        _record_outputs(recorder, body, parts)
        _record_displacement(recorder, body, coefficients, displacement[own], k, waves or Still())
        text = f"mass of the water that {body} displaces in the reference pose"
        neutral = Variable(f"{body}.neutral_mass", "kg", text)
        recorder.calculate(neutral, carried[k] / coefficients.gravity)
    _publish_added_mass(recorder, coefficients, fitted.added_mass_inf)
    return recorder.program()


def _record_motion(recorder: Recorder, body: str, center: np.ndarray) -> tuple[Vector, Vector]:
    """Inputs of a body; its displacement from the reference pose, and its velocity."""
    reference = (float(center[0]), float(center[1]), 0.0)
    displacement: Vector = []
    velocity: Vector = []
    for (symbol, unit), start in zip(POSITION, reference, strict=True):
        text = "pitch angle" if symbol == "theta" else f"{symbol} of the centre of gravity"
        variable = Variable(f"{body}.{symbol}", unit, f"{text}, world frame", start=start)
        displacement.append(recorder.input(variable) - start)
    for (symbol, unit), (position, _) in zip(VELOCITY, POSITION, strict=True):
        variable = Variable(f"{body}.{symbol}", unit, f"rate of {body}.{position}, world frame")
        velocity.append(recorder.input(variable))
    return displacement, velocity


def _record_memory(
    recorder: Recorder,
    groups: tuple[RadiationGroup, ...],
    bodies: tuple[str, ...],
    velocity: Vector,
) -> Vector:
    """States of the radiation memory and the force they make, −∫ K v dτ.

    Each pole p = σ ± jω of a group has, for each of its motions' velocities v, the block
    ẋ₁ = σ x₁ + ω x₂ + 2 v, ẋ₂ = −ω x₁ + σ x₂ (a real pole: ẋ = σ x + v); the residue r of a force
    adds Re r x₁ + Im r x₂ to it.
    """
    force: Vector = [0.0] * len(velocity)
    count = dict.fromkeys(bodies, 0)

    def state(motion: int) -> tuple[str, Scalar]:
        body = bodies[motion // 3]
        count[body] += 1
        name = f"{body}.radiation_state[{count[body]}]"
        text = f"memory of {body}'s {MOTIONS[motion % 3]}"
        return name, recorder.state(Variable(name, STATE_UNIT[motion % 3], text, local=True))

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
        own = slice(3 * k, 3 * k + 3)
        stiffness = coefficients.hydrostatic_stiffness[own, own]
        buoyancy = coefficients.buoyancy[own]
        for i, (symbol, unit) in enumerate(WRENCH):
            total: Scalar | float = 0.0
            if abs(buoyancy[i]) > SMALL * max(abs(coefficients.buoyancy).max(), 1e-300):
                text = f"{symbol} of the still water in the reference pose"
                start = float(buoyancy[i])
                total = recorder.parameter(
                    Variable(f"{body}.buoyancy_{symbol}", unit, text, start=start)
                )
                if symbol == "force_z":
                    carried[k] = total
            for j in range(3):
                if abs(stiffness[i, j]) <= SMALL * abs(stiffness).max(initial=0.0):
                    continue
                text = f"hydrostatic stiffness: {symbol} per {MOTIONS[j]}"
                variable = Variable(
                    f"{body}.hydrostatic_stiffness[{i + 1},{j + 1}]",
                    STIFFNESS_UNIT[i][j],
                    text,
                    start=float(stiffness[i, j]),
                )
                total = total - recorder.parameter(variable) * displacement[3 * k + j]
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
    """Outputs surge, heave and pitch from the reference pose, with the limits of small motions."""
    limits = motion_ranges(coefficients, k, waves)
    for (motion, limit), value, unit in zip(limits.items(), displacement, STATE_UNIT, strict=True):
        text = f"{motion} from the reference pose"
        if not limit.is_open:
            text += f"; {limit.reason}"
        variable = Variable(
            f"{body}.{motion}", unit, text, minimum=limit.minimum, maximum=limit.maximum
        )
        recorder.output(variable, value)


def _record_drag(recorder: Recorder, body: str, drag: Drag, velocity: Vector) -> Vector:
    force: Vector = []
    for motion, unit, v in zip(MOTIONS, DRAG_UNIT, velocity, strict=True):
        variable = Variable(
            f"{body}.drag_{motion}",
            unit,
            f"quadratic drag in {motion}: force -c |v| v",
            start=getattr(drag, motion),
            minimum=0.0,
            tunable=True,
        )
        force.append(-recorder.parameter(variable) * abs(v) * v)
    return force


def _record_outputs(recorder: Recorder, body: str, parts: tuple[Vector, ...]) -> None:
    """The wrench on a body and two of its parts; `parts` as the program sums them."""
    _, memory, excitation, _ = parts
    for i, (symbol, unit) in enumerate(WRENCH):
        total = parts[0][i]
        for part in parts[1:]:
            total = total + part[i]
        text = f"{symbol} of the water on {body} about its centre of gravity, world frame"
        recorder.output(Variable(f"{body}.{symbol}", unit, text), total)
    for kind, part in (("excitation", excitation), ("radiation", memory)):
        for (symbol, unit), value in zip(WRENCH, part, strict=True):
            text = f"part of {body}.{symbol}: wave {kind}"
            if kind == "radiation":
                text = f"part of {body}.{symbol}: radiation memory, without added_mass"
            recorder.output(Variable(f"{body}.{kind}_{symbol}", unit, text), value)


def _publish_added_mass(recorder: Recorder, coefficients: Coefficients, matrix: np.ndarray) -> None:
    scale = [math.sqrt(max(abs(value), 1e-300)) for value in matrix.diagonal()]
    motions = coefficients.motions
    for i, row in enumerate(motions):
        for j, column in enumerate(motions):
            value = float(matrix[i, j])
            variable = Variable(
                f"added_mass[{i + 1},{j + 1}]",
                MASS_UNIT[i % 3][j % 3],
                f"added mass at infinite frequency: {row} per acceleration in {column}",
            )
            recorder.calculate(variable, value if abs(value) > SMALL * scale[i] * scale[j] else 0.0)
