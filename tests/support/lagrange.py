"""Equations of motion from Lagrange's equation, independent of the paper's B and Eq. (5).

A mechanism is described by its positions only; velocities, energies, generalised forces and
accelerations follow by differentiation with SymPy.

Both sides of a comparison are double precision and solve a mass matrix with a condition number
below 1e4, so 1e-10 relative to the largest acceleration leaves two digits of room.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import sympy as sp
from support.programs import Evaluated

RELATIVE = 1e-10
STATES = 5
TIME = sp.Symbol("time")
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


def assert_accelerations(
    program: Evaluated, mechanism: Mechanism, states: list[str], inputs: dict[str, sp.Symbol]
) -> None:
    """Assert that accelerations at random states and inputs agree.

    `states` are the coordinates' variable names.
    """
    rng = np.random.default_rng(3)
    velocities = [_velocity(name) for name in states]
    parameters = {v.name: v.start for v in program.program.parameters}
    for _ in range(STATES):
        q = rng.uniform(-1.5, 1.5, len(states))
        u = rng.uniform(-2.0, 2.0, len(states))
        forces = rng.uniform(-5.0, 5.0, len(inputs))
        t = rng.uniform(0.0, 10.0)
        symbols = [*mechanism.q, *mechanism.u, *inputs.values(), TIME]
        numbers = [*q, *u, *forces, t]
        expected = mechanism.accelerations(dict(zip(symbols, numbers, strict=True)))
        values = dict(zip([*states, *velocities, *inputs], numbers[:-1], strict=True))
        rates = program.rates({**parameters, **values}, t=t)
        assert [rates[name] for name in states] == list(u)
        got = [rates[name] for name in velocities]
        assert got == pytest.approx(expected, rel=0, abs=RELATIVE * abs(expected).max())


def _velocity(coordinate: str) -> str:
    if coordinate.startswith("joint."):
        return coordinate.removesuffix(".q") + ".u"
    path, _, axis = coordinate.rpartition(".")
    return f"{path}.{'omega' if axis == 'theta' else 'v' + axis}"


def forces(*names: str) -> dict[str, sp.Symbol]:
    return {name: sp.Symbol(name) for name in names}
