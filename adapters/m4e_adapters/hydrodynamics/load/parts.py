"""The parts of the load: memory, hydrostatics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory.convolution import ConvolutionGroup
from m4e_adapters.hydrodynamics.memory.group_fit import RadiationGroup
from m4e_fmi.program import Recorder, Scalar, Variable


def record_past(
    recorder: Recorder,
    past: Sequence[tuple[str, Scalar]],
    velocity: Scalar | float,
    *,
    duration: float,
) -> None:
    """Rates of the states `past`, by name, that are the velocity over the last `duration` [s]."""
    end: Scalar | float = 0.0
    for _, value in past:
        end = end + value
    sums: list[Scalar | float] = [velocity - end, -velocity - end]  # of even, of odd polynomials
    for n, (name, value) in enumerate(past):
        recorder.rate(name, (2 * n + 1) / duration * sums[n % 2])
        sums[1 - n % 2] = sums[1 - n % 2] + 2.0 * value


Vector = list[Scalar | float]

SMALL = 1e-9  # relative to the largest: panels' noise


def record_memory(
    recorder: Recorder,
    groups: tuple[RadiationGroup | ConvolutionGroup, ...],
    coefficients: Coefficients,
    velocity: Vector,
) -> Vector:
    """States of the radiation memory and the force they make, −∫ K v dτ.

    Each pole p = σ ± jω of a group has, for each of its motions' velocities v, the block
    ẋ₁ = σ x₁ + ω x₂ + 2 v, ẋ₂ = −ω x₁ + σ x₂ (a real pole: ẋ = σ x + v); the residue r of a force
    adds Re r x₁ + Im r x₂ to it. A convolution has the past of each velocity as a polynomial.
    """
    force: Vector = [0.0] * len(velocity)
    count = dict.fromkeys(coefficients.bodies, 0)

    def state(place: int, per: str = "") -> tuple[str, Scalar]:
        k, own = divmod(place, coefficients.per_body)
        body, motion = coefficients.bodies[k], coefficients.body_motions[own]
        count[body] += 1
        name = f"{body}.radiation_state[{count[body]}]"
        text = f"memory of {body}'s {motion.name}"
        return name, recorder.state(Variable(name, motion.unit + per, text, local=True))

    for group in groups:
        for column, motion in enumerate(group.motions):
            v = velocity[motion]
            if isinstance(group, ConvolutionGroup):
                past = [state(motion, "/s") for _ in range(group.order)]
                record_past(recorder, past, v, duration=group.duration)
                force[motion] = force[motion] - float(group.damping[column]) * v
                for row, target in enumerate(group.motions):
                    weights = group.weights[:, row, column]
                    if not np.any(weights):
                        continue
                    total: Scalar | float = 0.0
                    for weight, (_, value) in zip(weights.tolist(), past, strict=True):
                        total = total + weight * value
                    force[target] = force[target] - total
                continue
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


def record_hydrostatics(
    recorder: Recorder, coefficients: Coefficients, displacement: Vector
) -> Vector:
    """Buoyancy in the reference pose less stiffness times displacement; both are parameters.

    The mass of the displaced water, `<body>.neutral_mass`, is calculated.
    """
    force: Vector = []
    for k, body in enumerate(coefficients.bodies):
        own, motions = coefficients.own(k), coefficients.body_motions
        stiffness = coefficients.hydrostatic_stiffness[own, own]
        buoyancy = coefficients.buoyancy[own]
        carried: Scalar | float = 0.0
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
                    carried = total
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
        text = f"mass of the water that {body} displaces in the reference pose"
        neutral = Variable(f"{body}.neutral_mass", "kg", text)
        recorder.calculate(neutral, carried / coefficients.gravity)
    return force
