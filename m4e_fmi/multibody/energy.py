"""Energies of an assembled model and the power of its loads, over any scalar."""

from __future__ import annotations

from m4e_fmi.multibody.assembly import Assembly
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import dot, plus, quadratic, scaled, times


def kinetic_energy(assembly: Assembly) -> AnyScalar:
    """½ vᵀ(𝓜 + A)v [J]."""
    total: AnyScalar = 0
    for (mass, inertia), frame in zip(assembly.masses, assembly.frames, strict=True):
        total = total + mass * dot(frame.velocity, frame.velocity)
        # J is in body axes, and so is what it is applied to
        spin = frame.omega if frame.rotation.about is not None else frame.rotation.back(frame.omega)
        total = plus(total, quadratic(inertia, spin))
    for (i, j), block in assembly.added_mass.items():
        left, right = ((*f.velocity, *f.omega) for f in (assembly.frames[i], assembly.frames[j]))
        for row, v in zip(block, left, strict=True):
            total = plus(total, times(v, dot(row, right)))
    return total / 2


def potential_energy(assembly: Assembly) -> AnyScalar:
    """Potential energy [J] of gravity on the dry masses (zero at the origin) and of the springs.

    A spring counts if its quantities depend on parameters only, and a law if its integral is known:
    see `loads`.
    """
    total: AnyScalar = 0
    for (mass, _), frame in zip(assembly.masses, assembly.frames, strict=True):
        total = plus(total, dot(scaled(mass, assembly.gravity), frame.position))
    for load in assembly.loads.values():
        total = total + load.potential
    return total


def input_power(assembly: Assembly) -> AnyScalar:
    """Power [W] of what acts from outside; the integer 0 if nothing does."""
    total: AnyScalar = 0
    outside = assembly.scalars
    for body, wrench in outside.body_wrench.items():
        frame = assembly.frame(body)
        total = plus(total, dot(wrench, (*frame.velocity, *frame.omega)))
    for name, force in outside.point_force.items():
        total = plus(total, dot(force, assembly.points[name].velocity))
    for joint, efforts in outside.effort.items():
        for number, effort in enumerate(efforts):
            _, rate = assembly.values.state.joint(joint, number)
            total = plus(total, times(effort, rate))
    return total


def load_powers(assembly: Assembly) -> dict[str, AnyScalar]:
    """Power [W] by which each load changes the sum of kinetic and potential energy, by its name.

    A load that has a potential and nothing else is left out. Together with the power of what acts
    from outside these are d(energy)/dt.
    """
    powers = {name: load.power for name, load in assembly.loads.items()}
    return {name: power for name, power in powers.items() if not isinstance(power, int)}
