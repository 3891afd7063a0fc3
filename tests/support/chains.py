"""Chains of equal links, and their M and K written down by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from m4e_fmi.model import Body, Joint, Model, TorsionDamper, TorsionSpring

G = 9.81


def hanging_chain(size: int, *, length: float = 0.5, mass: float = 1.5) -> Model:
    """Uniform rods on hinges, under gravity."""
    half = (0.0, -length / 2)
    bodies = {f"b{k}": Body(mass, mass * length**2 / 12) for k in range(size)}
    joints = {
        f"j{k}": Joint("revolute", f"b{k}", f"b{k - 1}", parent_to_joint=half, joint_to_child=half)
        for k in range(1, size)
    }
    joints["j0"] = Joint("revolute", "b0", joint_to_child=half)
    return Model(name="chain", bodies=bodies, joints=joints, gravity=G)


def hanging_chain_matrices(
    size: int, *, length: float = 0.5, mass: float = 1.5
) -> tuple[np.ndarray, np.ndarray]:
    """M and K of `hanging_chain` for small absolute angles, from its energies.

    Centre of gravity i is at x_i = −L (Σ_{j<i} θ_j + θ_i/2) and is raised by
    L (Σ_{j<i} θ_j²/2 + θ_i²/4).
    """
    shape = np.tril(np.ones((size, size)), -1) + 0.5 * np.eye(size)
    M = mass * length**2 * (shape.T @ shape) + np.eye(size) * mass * length**2 / 12
    K = np.diag(mass * G * length * shape.sum(axis=0))
    return M, K


def cantilever(
    segments: int, *, length: float, rigidity: float, density: float, damping: float = 0.0
) -> Model:
    """A beam along X clamped at the origin: rigid segments, torsion springs between them.

    `rigidity` EI [N·m²], `density` [kg/m]. The springs are EI/dx, at the clamp 2 EI/dx: half a
    segment bends there. `damping` [s] is that of the springs, by their stiffness.
    """
    dx = length / segments
    bodies, joints, loads = {}, {}, {}
    for k in range(segments):
        bodies[f"s{k}"] = Body(density * dx, density * dx**3 / 12)
        parent, hold = ("ground", (0.0, 0.0)) if k == 0 else (f"s{k - 1}", (dx / 2, 0.0))
        joints[f"h{k}"] = Joint("revolute", f"s{k}", parent, hold, (dx / 2, 0.0))
        stiffness = (2 if k == 0 else 1) * rigidity / dx
        loads[f"bending{k}"] = TorsionSpring((parent, f"s{k}"), stiffness)
        if damping:
            loads[f"damping{k}"] = TorsionDamper((parent, f"s{k}"), damping * stiffness)
    return Model(name="cantilever", bodies=bodies, joints=joints, loads=loads, gravity=0.0)


def sprung_chain(size: int) -> Model:
    """`hanging_chain` with a torsion spring of 20 N·m/rad at each joint, straight at rest."""
    loads = {
        f"spring{k}": TorsionSpring(("ground" if k == 0 else f"b{k - 1}", f"b{k}"), 20.0)
        for k in range(size)
    }
    return replace(hanging_chain(size), loads=loads)
