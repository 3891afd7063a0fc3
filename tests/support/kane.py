"""Accelerations by SymPy's own Kane's method, for systems in the paper's lists.

Frames, points, rigid bodies and forces of sympy.physics.mechanics; nothing of m4e_fmi. The frame N
has X right, Z up; a positive angle about N.y turns Z towards X.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp
import sympy.physics.mechanics as me

TIME: Any = me.dynamicsymbols._t


class KaneSystem:
    """`q` and `u` by the number of the child, as in the paper: X, Z, Theta of a floating body."""

    def __init__(self, lists: Mapping[str, Any]) -> None:
        self.lists = lists
        self.N = me.ReferenceFrame("N")
        self.O = me.Point("O")
        self.O.set_vel(self.N, 0)
        self.q: list[Any] = []
        self.u: list[Any] = []
        self.frames: dict[int, me.ReferenceFrame] = {0: self.N}
        self.centres: dict[int, me.Point] = {0: self.O}
        self.loads: list[tuple[Any, Any]] = []
        self.bodies = [self._body(row) for row in range(len(lists["joints"]))]
        self._add_forces()
        rates = dict(zip([q.diff(TIME) for q in self.q], self.u, strict=True))
        method = me.KanesMethod(self.N, self.q, self.u, [u - qd for qd, u in rates.items()])
        method.kanes_equations(self.bodies, [(at, v.subs(rates)) for at, v in self.loads])
        plain = {s: sp.Symbol(f"s{k}") for k, s in enumerate([*self.u, *self.q])}
        # velocities first: they contain no coordinate's symbol
        matrices = [m.subs(rates).subs(plain) for m in (method.mass_matrix, method.forcing)]
        symbols = [*(plain[s] for s in (*self.q, *self.u)), TIME]
        self._compiled = sp.lambdify(symbols, matrices, modules="numpy", cse=True)

    def accelerations(self, q: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
        mass_matrix, forcing = self._compiled(*q, *u, t)
        return np.linalg.solve(np.array(mass_matrix, float), np.array(forcing, float).ravel())

    def _coordinates(self, names: list[str]) -> list[Any]:
        fresh = [me.dynamicsymbols(name) for name in names]
        self.q += fresh
        self.u += [me.dynamicsymbols(f"u_{name}") for name in names]
        return fresh

    def _vector(self, frame: me.ReferenceFrame, row: Any) -> Any:
        return sp.nsimplify(row[0]) * frame.x + sp.nsimplify(row[1]) * frame.z

    def _body(self, row: int) -> me.RigidBody:
        lists = self.lists
        parent, child = lists["joints"][row]
        kind = lists["types"][row]
        frame = me.ReferenceFrame(f"B{child}")
        before, centre = self.frames[parent], me.Point(f"C{child}")
        to_joint, to_child = lists["parent_cg_to_joint"][row], lists["joint_to_child_cg"][row]
        if kind == "F":
            x, z, theta = self._coordinates([f"X{child}", f"Z{child}", f"Theta{child}"])
            frame.orient_axis(self.N, self.N.y, theta)
            centre.set_pos(self.O, x * self.N.x + z * self.N.z)
        elif kind == "R":
            (theta,) = self._coordinates([f"Theta{child}"])
            frame.orient_axis(self.N, self.N.y, theta)
            way = self._vector(before, to_joint) + self._vector(frame, to_child)
            centre.set_pos(self.centres[parent], way)
        else:
            (s,) = self._coordinates([f"S{child}"])
            frame.orient_axis(before, before.y, 0)
            way = self._vector(before, to_joint) + self._vector(before, to_child)
            slide = s * self._vector(before, lists["prismatic_direction"][row])
            centre.set_pos(self.centres[parent], way + slide)
        self.frames[child], self.centres[child] = frame, centre
        centre.set_vel(self.N, self._velocity(centre))
        mass, inertia = (sp.nsimplify(np.ravel(lists[k])[child - 1]) for k in ("m0", "J0"))
        weight = sp.nsimplify(lists["g"]) * mass
        self.loads.append((centre, -weight * self.N.z))
        return me.RigidBody(f"R{child}", centre, frame, mass,
                            (me.inertia(frame, 0, inertia, 0), centre))  # fmt: skip

    def _velocity(self, point: me.Point) -> Any:
        rates = dict(zip([q.diff(TIME) for q in self.q], self.u, strict=True))
        place: Any = point.pos_from(self.O)
        return place.express(self.N).dt(self.N).subs(rates)

    def _point(self, name: str) -> tuple[me.Point, int]:
        """A point in the paper's first spelling, and its body."""
        kind, body, index = name[:2], int(name[2]), int(name[3])
        points = self.lists["Initial_Points"]
        if kind == "CG":
            return self.centres[body], body
        row = points["GR"][index] if kind == "GR" else points["BD"][body][index]
        body = 0 if kind == "GR" else body
        point = self.centres[body].locatenew(name, self._vector(self.frames[body], row))
        point.set_vel(self.N, self._velocity(point))
        return point, body

    def _add_forces(self) -> None:
        force = self.lists.get("Force", {})
        t = sp.Symbol("t", real=True)
        for body, x, z, moment in force.get("CG", []):
            fx, fz, m = (sp.sympify(c).subs(t, TIME) for c in (x, z, moment))
            self.loads.append((self.centres[body], fx * self.N.x + fz * self.N.z))
            self.loads.append((self.frames[body], m * self.N.y))
        for ends, (length, stiffness) in force.get("TensionSpring", []):
            self._pull(ends, lambda now, _, k=stiffness, r=length: k * (now - r))
        for ends, damping in force.get("TensionDamper", []):
            self._pull(ends, lambda _, rate, c=damping: c * rate)
        for bodies, (angle, stiffness) in force.get("TorsionSpring", []):
            self._twist(bodies, lambda twist, _, k=stiffness, r=angle: k * (twist - r))
        for bodies, damping in force.get("TorsionDamper", []):
            self._twist(bodies, lambda _, rate, c=damping: c * rate)

    def _pull(self, ends: tuple[str, str], law: Any) -> None:
        (first, _), (second, _) = (self._point(name) for name in ends)
        line: Any = second.pos_from(first).express(self.N)
        length = sp.sqrt(line.dot(line))
        apart: Any = second.vel(self.N) - first.vel(self.N)
        rate = apart.express(self.N).dot(line) / length
        pull = law(length, rate) / length
        self.loads += [(first, pull * line), (second, -pull * line)]

    def _twist(self, bodies: tuple[int, int], law: Any) -> None:
        angles = [self._angle(body) for body in bodies]
        twist = angles[1] - angles[0]
        moment = law(twist, twist.diff(TIME)) * self.N.y
        for body, sign in zip(bodies, (1, -1), strict=True):
            if body:
                self.loads.append((self.frames[body], sign * moment))

    def _angle(self, body: int) -> Any:
        """Absolute angle of a body; one that slides has its parent's."""
        if body == 0:
            return sp.Integer(0)
        for row, (parent, child) in enumerate(self.lists["joints"]):
            if child == body and self.lists["types"][row] == "P":
                return self._angle(parent)
        return me.dynamicsymbols(f"Theta{body}")
