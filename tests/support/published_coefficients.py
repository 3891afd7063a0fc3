"""Coefficients by others, and the linear system that a body makes with a fitted memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory.group_fit import RadiationGroup
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory

DATA = Path(__file__).parents[1] / "data" / "hydrodynamics"
RHO, G = 1000.0, 9.81
FLAP_ARM = 5.0  # m, of the flap's centre of gravity above its hinge
RM3_MASS = np.array([725834.0, 725834.0, 21306090.66, 886691.0, 886691.0, 94407091.24])
"""kg, kg, kg.m2 of float and spar."""


def _tables(name: str, motions: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """ω (n,), added mass and damping (n, m, m)."""
    rows = np.loadtxt(DATA / name, delimiter=",")
    a, b = rows[:, 1:].reshape(len(rows), 2, motions, motions).swapaxes(0, 1)
    return rows[:, 0], a, b


def sphere() -> Coefficients:
    """IEA OES Task 10 sphere by WAMIT, heave only; depth 200 m is deep here."""
    omega, mass, damping, real, imaginary = np.loadtxt(
        DATA / "oes10_sphere_wamit_heave.csv", delimiter=",", unpack=True
    )
    unit, radius = np.diag([0.0, 1.0, 0.0]), 5.0
    return Coefficients(
        bodies=("ball",),
        centers=np.array([[0.0, -2.0]]),
        omega=omega,
        added_mass=mass[:, None, None] * unit,
        radiation_damping=damping[:, None, None] * unit,
        added_mass_inf=130876.8 * unit,
        excitation=(real + 1j * imaginary)[:, None] * np.array([0.0, 1.0, 0.0]),
        hydrostatic_stiffness=RHO * G * np.pi * radius**2 * unit,
        buoyancy=np.array([0.0, RHO * G * 2 / 3 * np.pi * radius**3, 0.0]),
        density=RHO,
        gravity=G,
    )


def flap() -> Coefficients:
    """The OSWEC's flap; nobody gives its A∞, and that at 20 rad/s stands for it."""
    omega, mass, damping = _tables("oswec_flap_planar.csv", 3)
    return Coefficients(
        bodies=("flap",),
        centers=np.array([[0.0, -3.9]]),
        omega=omega[:-1],
        added_mass=mass[:-1],
        radiation_damping=damping[:-1],
        added_mass_inf=mass[-1],
        excitation=np.zeros((len(omega) - 1, 3), dtype=complex),
        hydrostatic_stiffness=np.diag([0.0, 317844.0, -1.9335e6]),
        buoyancy=np.array([0.0, RHO * G * 297.376, 0.0]),
        density=RHO,
        depth=10.9,
        gravity=G,
    )


def rm3() -> Coefficients:
    """Float and spar of RM3, in all planar motions."""
    omega, mass, damping = _tables("rm3_wamit_planar.csv", 6)
    return Coefficients(
        bodies=("float", "spar"),
        centers=np.array([[0.0, -0.72], [0.0, -21.29]]),
        omega=omega[:-1],
        added_mass=mass[:-1],
        radiation_damping=damping[:-1],
        added_mass_inf=mass[-1],
        excitation=np.zeros((len(omega) - 1, 6), dtype=complex),
        hydrostatic_stiffness=np.diag([0.0, 2_800_981.0, 0.0, 0.0, 277_019.0, 0.0]),
        buoyancy=G * np.array([0.0, 725834.0, 0.0, 0.0, 886691.0, 0.0]),
        density=RHO,
        gravity=G,
    )


def transfer(memory: RadiationMemory, omega: np.ndarray) -> np.ndarray:
    """K(jω) of all motions, (n, m, m)."""
    size = len(memory.added_mass_inf)
    found = np.zeros((len(omega), size, size), dtype=complex)
    for group in memory.groups:
        found[np.ix_(range(len(omega)), group.motions, group.motions)] += group.transfer(omega)
    return found


def linear_system(
    memory: RadiationMemory, *, mass: np.ndarray, stiffness: np.ndarray, damping: np.ndarray
) -> np.ndarray:
    """Matrix of ẏ = A y, y = displacements, velocities, memory, of bodies in still water.

    `mass` (m, m) is that of the dry bodies, `stiffness` and `damping` (m, m) are of all else.
    """
    size = len(mass)
    blocks = []
    for group in memory.groups:
        assert isinstance(group, RadiationGroup)
        for column, motion in enumerate(group.motions):
            for pole, residue in zip(group.poles, group.residues, strict=True):
                force = np.zeros(size, dtype=complex)
                force[list(group.motions)] = residue[:, column]
                blocks.append((motion, pole, force))
    orders = [2 if pole.imag > 0 else 1 for _, pole, _ in blocks]
    inverse = np.linalg.inv(mass + memory.added_mass_inf)
    found = np.zeros((2 * size + sum(orders),) * 2)
    found[:size, size : 2 * size] = np.eye(size)
    found[size : 2 * size, :size] = -inverse @ stiffness
    found[size : 2 * size, size : 2 * size] = -inverse @ damping
    at = 2 * size
    for (motion, pole, force), order in zip(blocks, orders, strict=True):
        own = np.array([[pole.real, pole.imag], [-pole.imag, pole.real]])[:order, :order]
        found[at : at + order, at : at + order] = own
        found[at, size + motion] = order
        found[size : 2 * size, at] = -inverse @ force.real
        if order == 2:
            found[size : 2 * size, at + 1] = -inverse @ force.imag
        at += order
    return found
