"""Kinetic and potential energy of an assembled model, over any scalar."""

from __future__ import annotations

from typing import Any

from m4e_fmi.multibody.assembly import Assembly
from m4e_fmi.multibody.loads import potential
from m4e_fmi.multibody.planar import dot


def kinetic_energy(assembly: Assembly) -> Any:
    """½ vᵀ(𝓜 + A)v [J]."""
    total: Any = 0
    for (mass, inertia), frame in zip(assembly.masses, assembly.frames, strict=True):
        total = total + mass * dot(frame.velocity, frame.velocity)
        total = total + inertia * (frame.omega * frame.omega)
    for (i, j), block in assembly.added_mass.items():
        left, right = ((*f.velocity, f.omega) for f in (assembly.frames[i], assembly.frames[j]))
        for row, v in zip(block, left, strict=True):
            total = total + v * sum(a * w for a, w in zip(row, right, strict=True))
    return total / 2


def potential_energy(assembly: Assembly) -> Any:
    """Potential energy [J] of gravity on the dry masses (zero at Z = 0) and of the springs."""
    total: Any = 0
    for (mass, _), frame in zip(assembly.masses, assembly.frames, strict=True):
        total = total + mass * assembly.gravity * frame.position[1]
    for load in assembly.model.loads.values():
        total = total + potential(load, assembly.frame, assembly.points, assembly.values)
    return total
