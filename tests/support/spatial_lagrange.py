"""Lagrange's equations of small trees in space, derived by SymPy from where the bodies are."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import sympy as sp
from support.programs import Evaluated
from support.spatial_trees import spatial_tree

from m4e_fmi.model import Model
from m4e_fmi.model.elements import inertia_of, parameter_values, quantity, vector
from m4e_fmi.model.groups import gravity_of
from m4e_fmi.multibody import topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion

KINDS = ("revolute", "prismatic", "universal", "cylindrical", "planar", "fixed")


class Lagrange:
    """M u̇ = f of a model whose velocities are its coordinates' rates, as functions of NumPy."""

    def __init__(self, model: Model) -> None:
        self.model, self.tree = model, topology(model)
        self.values = parameter_values(model.parameters)
        n = len(self.tree.coordinate_names)
        self.q: list[Any] = list(sp.symbols(f"q:{n}"))
        self.u: list[Any] = list(sp.symbols(f"u:{n}"))
        kinetic, potential = self._energies()
        momenta = [sp.diff(kinetic, u) for u in self.u]
        M = [[sp.diff(momentum, u) for u in self.u] for momentum in momenta]
        f = [
            sp.diff(kinetic - potential, q)
            - sum(sp.diff(momentum, p) * u for p, u in zip(self.q, self.u, strict=True))
            for momentum, q in zip(momenta, self.q, strict=True)
        ]
        arguments = [*self.q, *self.u]
        self._M, self._f = (sp.lambdify(arguments, part, "numpy", cse=True) for part in (M, f))

    def accelerations(self, q: list[float], u: list[float]) -> np.ndarray:
        return np.linalg.solve(np.array(self._M(*q, *u)), np.array(self._f(*q, *u)))

    def _column(self, owner: object, field: str) -> Any:
        parts = [float(part.evaluate(self.values)) for part in vector(owner, field)]
        return sp.Matrix(parts if len(parts) == 3 else [0, 0, 0])

    def _unit(self, owner: object, field: str) -> Any:
        found = self._column(owner, field)
        return found / found.norm()

    def _energies(self) -> tuple[Any, Any]:
        kinetic, potential, poses = sp.Integer(0), sp.Integer(0), []
        up = sp.Matrix([float(part.evaluate(self.values)) for part in gravity_of(self.model)])
        for link in self.tree.links:
            parent = poses[link.parent] if link.parent >= 0 else (sp.zeros(3, 1), sp.eye(3))
            place, R = self._pose(link, *parent)
            poses.append((place, R))
            body = self.model.bodies[link.body]
            mass = float(quantity(body, "mass").evaluate(self.values))
            given = [float(part.evaluate(self.values)) for part in inertia_of(body)]
            xx, yy, zz, xy, yz, zx = [*given, 0.0, 0.0, 0.0][:6]
            v = place.jacobian(self.q) * sp.Matrix(self.u)
            turning = sp.zeros(3, 3)
            for q, u in zip(self.q, self.u, strict=True):
                turning += R.T * R.diff(q) * u
            omega = sp.Matrix([turning[2, 1], turning[0, 2], turning[1, 0]])
            J = sp.Matrix([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
            kinetic += mass * v.dot(v) / 2 + (omega.T * J * omega)[0] / 2
            potential += mass * up.dot(place)
        return kinetic, potential

    def _pose(self, link: Any, place: Any, R: Any) -> tuple[Any, Any]:
        joint, kind, q = link.joint, link.joint.type, [self.q[k] for k in link.coordinates]
        place = place + R * self._column(joint, "parent_to_joint")
        angles: list[tuple[str, Any]] = []
        if kind == "prismatic":
            place = place + q[0] * (R * self._unit(joint, "direction"))
        if kind == "cylindrical":
            place = place + q[0] * (R * self._unit(joint, "axis"))
        if kind == "planar":
            first = self._unit(joint, "direction")
            across = self._unit(joint, "axis").cross(first)
            place = place + R * (q[0] * first + q[1] * across)
        if kind in ("revolute", "cylindrical", "planar"):
            angles = [("axis", q[-1])]
        if kind == "universal":
            angles = [("axis", q[0]), ("second_axis", q[1])]
        for field, angle in angles:
            x, y, z = self._unit(joint, field)
            K = sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            R = R * (sp.eye(3) + sp.sin(angle) * K + (1 - sp.cos(angle)) * K * K)
        return place + R * self._column(joint, "joint_to_child"), R


def check_tree(seed: int) -> None:
    """Both algorithms of ours give the accelerations of a random tree of two or three bodies."""
    model = spatial_tree(500 + seed, size=2 + seed % 2, loads=False, kinds=KINDS)
    reference, r = Lagrange(model), random.Random(seed)
    n = len(reference.q)
    q, u = ([r.uniform(-1, 1) for _ in range(n)] for _ in range(2))
    expected = reference.accelerations(q, u)
    for algorithm in (Recursion, ClosedForm):
        program = recorded(model, reference.tree, algorithm, ())
        states = [v.name for v in program.states]
        values = dict(zip(states, (value for pair in zip(q, u, strict=True) for value in pair),
                          strict=True))  # fmt: skip
        rates = list(Evaluated(program).rates(values).values())
        assert np.abs(np.array(rates[1::2]) - expected).max() < 1e-10 * np.abs(expected).max()
