"""SymPy: Kane's method, then lambdify with common subexpressions, and a solve by NumPy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmark.engine import Prepared, UnavailableError
from benchmark.native_code import Floats
from benchmark.systems import GRAVITY, GROUND, System
from benchmark.timing import cpu_seconds, python_batch


def kane(system: System, gravity: Any) -> tuple[Any, list[Any], list[Any]]:
    """KanesMethod with its equations formed, and its coordinates and speeds."""
    import sympy
    from sympy.physics import mechanics as me

    n = system.size
    if system.springs or system.torsions or not all(link.revolute for link in system.links):
        raise UnavailableError("derived here for pendulums only")
    q = me.dynamicsymbols(f"q:{n}")
    u = me.dynamicsymbols(f"u:{n}")
    world = me.ReferenceFrame("N")
    origin = me.Point("O")
    origin.set_vel(world, 0)
    frames, centres = {GROUND: world}, {GROUND: origin}
    bodies, loads = [], []
    for k, link in enumerate(system.links):
        frame = world.orientnew(f"F{k}", "Axis", [q[k], world.y])
        frame.set_ang_vel(world, u[k] * world.y)
        mother = frames[link.parent]
        x, z = link.parent_to_joint
        joint = centres[link.parent].locatenew(f"J{k}", x * mother.x + z * mother.z)
        joint.v2pt_theory(centres[link.parent], world, mother)
        x, z = link.joint_to_child
        centre = joint.locatenew(f"C{k}", x * frame.x + z * frame.z)
        centre.v2pt_theory(joint, world, frame)
        inertia = me.inertia(frame, 0, link.inertia, 0)
        bodies.append(me.RigidBody(f"B{k}", centre, frame, link.mass, (inertia, centre)))
        loads.append((centre, -link.mass * gravity * world.z))
        frames[k], centres[k] = frame, centre
    t = sympy.Symbol("t")
    kinematic = [q[k].diff(t) - u[k] for k in range(n)]
    method = me.KanesMethod(world, q_ind=q, u_ind=u, kd_eqs=kinematic)
    method.kanes_equations(bodies, loads)
    return method, q, u


class SympyKane:
    name = "SymPy Kane, lambdify"
    largest = 10
    largest_with_loads = 0

    def prepare(self, system: System) -> Prepared:
        try:
            import sympy
        except ImportError as error:
            raise UnavailableError("the package sympy is not installed") from error
        began = cpu_seconds()
        method, q, u = kane(system, GRAVITY)
        names = sympy.symbols(f"x:{2 * system.size}")
        exchange = dict(zip([*q, *u], names, strict=True))
        matrices = [m.xreplace(exchange) for m in (method.mass_matrix, method.forcing)]
        function: Callable[..., Any] = sympy.lambdify([names], matrices, cse=True)
        preparation = cpu_seconds() - began

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Floats:
            matrix, forcing = function([*q, *u])
            return np.linalg.solve(matrix, forcing)[:, 0]

        x = [*system.q, *system.u]
        n = system.size
        return Prepared(
            accelerations, python_batch(lambda: accelerations(x[:n], x[n:])), preparation
        )
