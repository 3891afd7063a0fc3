"""Equations of motion from Lagrange's equation, independent of the paper's B and Eq. (5).

A mechanism is described by its positions only; velocities, energies, generalised forces and
accelerations follow by differentiation with SymPy.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp

Displacement = Any
Force = Any


class Mechanism:
    """Coordinates `q` with velocities `u`, both symbols; energies and forces are added up.

    d/dt ∂T/∂u − ∂T/∂q = −∂V/∂q − ∂R/∂u + Σ F ∂s/∂q, with Rayleigh's dissipation function R and
    forces F that do work along displacements s.
    """

    def __init__(self, names: str) -> None:
        self.q = list(sp.symbols(names))
        self.u = list(sp.symbols([f"{symbol}_rate" for symbol in self.q]))
        self.kinetic: Any = sp.Integer(0)
        self.potential: Any = sp.Integer(0)
        self.dissipation: Any = sp.Integer(0)
        self.work: list[tuple[Force, Displacement]] = []

    def rate(self, quantity: Any) -> Any:
        """Time derivative of something that depends on the coordinates."""
        pairs = zip(self.q, self.u, strict=True)
        return sum((sp.diff(quantity, q) * u for q, u in pairs), sp.Integer(0))

    def body(self, x: Any, z: Any, theta: Any, *, mass: float, inertia: float, g: float) -> None:
        """A rigid body with its centre of gravity at (x, z), turned by theta."""
        vx, vz, omega = (self.rate(s) for s in (x, z, theta))
        self.kinetic += mass * (vx**2 + vz**2) / 2 + inertia * omega**2 / 2
        self.potential += mass * g * z

    def added_mass(self, matrix: Any, motion: Sequence[Any]) -> None:
        """Fluid that moves with constant `matrix` in the world axes of `motion` (x, z, θ, …)."""
        velocity = sp.Matrix([self.rate(s) for s in motion])
        self.kinetic += (velocity.T * sp.Matrix(matrix) * velocity)[0] / 2

    def spring(self, stiffness: float, extension: Any) -> None:
        self.potential += stiffness * extension**2 / 2

    def damper(self, damping: float, extension: Any) -> None:
        self.dissipation += damping * self.rate(extension) ** 2 / 2

    def force(self, *pairs: tuple[Force, Displacement]) -> None:
        self.work += pairs

    def accelerations(self, values: dict[Any, float]) -> np.ndarray:
        """u̇ where every symbol (q, u, forces, time) has the value given."""
        if not hasattr(self, "_compiled"):
            self._symbols = sorted(values, key=str)
            self._compiled = sp.lambdify(self._symbols, self._system(), modules="numpy", cse=True)
        mass_matrix, forcing = self._compiled(*(values[symbol] for symbol in self._symbols))
        return np.linalg.solve(np.array(mass_matrix, float), np.array(forcing, float).ravel())

    def _system(self) -> tuple[Any, Any]:
        momentum = [sp.diff(self.kinetic, u) for u in self.u]
        lagrangian = self.kinetic - self.potential
        forcing = [
            sp.diff(lagrangian, q)
            - self.rate(p)
            - sp.diff(self.dissipation, u)
            + sum(force * sp.diff(s, q) for force, s in self.work)
            for q, u, p in zip(self.q, self.u, momentum, strict=True)
        ]
        return sp.Matrix(momentum).jacobian(self.u), sp.Matrix(forcing)


def turned(x: float, z: float, theta: Any) -> tuple[Any, Any]:
    """(x, z) in body axes as a world vector: R(θ) = [[cos θ, sin θ], [−sin θ, cos θ]]."""
    return sp.cos(theta) * x + sp.sin(theta) * z, sp.cos(theta) * z - sp.sin(theta) * x


def distance(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return sp.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2)
