"""CasADi: Lagrange's equations in SX as a user writes them, on its virtual machine or as C.

The mass matrix and the forcing come from CasADi's own derivatives of the energies, the solution
from its symbolic LDLᵀ; the C is CasADi's generated code.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmark.engine import Batch, Prepared, UnavailableError
from benchmark.native_code import BUILD, Floats, compiled
from benchmark.systems import GRAVITY, System
from benchmark.timing import cpu_seconds, empty_call, python_batch


def function_of(system: System) -> Any:
    """casadi.Function (q, u) → u̇."""
    try:
        import casadi as ca
    except ImportError as error:
        raise UnavailableError("the package casadi is not installed") from error
    if system.springs or system.torsions or not all(link.revolute for link in system.links):
        raise UnavailableError("written here for pendulums only")
    n = system.size
    q, u = ca.SX.sym("q", n), ca.SX.sym("u", n)

    def turned(k: int, v: Any) -> Any:
        if k < 0:
            return ca.DM(v)
        c, s = ca.cos(q[k]), ca.sin(q[k])
        return ca.vertcat(c * v[0] + s * v[1], c * v[1] - s * v[0])

    def moved(k: int, v: Any) -> Any:
        """Velocity of the end of an arm of link k relative to its beginning."""
        return u[k] * ca.vertcat(v[1], -v[0]) if k >= 0 else ca.SX.zeros(2)

    centres, velocities = {-1: ca.SX.zeros(2)}, {-1: ca.SX.zeros(2)}
    kinetic = potential = ca.SX(0)
    for k, link in enumerate(system.links):
        inner, outer = turned(link.parent, link.parent_to_joint), turned(k, link.joint_to_child)
        centres[k] = centres[link.parent] + inner + outer
        velocities[k] = velocities[link.parent] + moved(link.parent, inner) + moved(k, outer)
        kinetic += link.mass * ca.sumsqr(velocities[k]) / 2 + link.inertia * u[k] ** 2 / 2
        potential += link.mass * GRAVITY * centres[k][1]
    momentum = ca.gradient(kinetic, u)
    mass_matrix = ca.jacobian(momentum, u)
    forcing = ca.gradient(kinetic - potential, q) - ca.jtimes(momentum, q, u)
    factors = ca.ldl(mass_matrix, False)
    return ca.Function("rates", [q, u], [ca.ldl_solve(forcing, *factors)])


class CasadiSx:
    largest_with_loads = 0

    def __init__(self, *, generated: bool) -> None:
        self.generated = generated
        self.name = "CasADi generated C" if generated else "CasADi virtual machine"
        self.largest = 10 if generated else 20

    def prepare(self, system: System) -> Prepared:
        began = cpu_seconds()
        function = function_of(system)
        if self.generated:
            function = _compiled(function, system.name)
        preparation = cpu_seconds() - began

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Floats:
            return np.array(function(q, u))[:, 0]

        return Prepared(accelerations, _batch(function, system), preparation)


def _compiled(function: Any, name: str) -> Any:
    """The function as generated C, compiled with -O2."""
    import casadi as ca

    generator = ca.CodeGenerator(f"casadi_{name}.c")
    generator.add(function)
    BUILD.mkdir(parents=True, exist_ok=True)
    source = BUILD / f"casadi_{name}.c"
    source.write_text(generator.dump())
    return ca.external("rates", compiled(source, ["-O2"])._name)


def _batch(function: Any, system: System) -> Batch:
    """Batch of CasADi's buffered call; the time of a call that does nothing is taken off."""
    import casadi as ca

    arguments = [np.array(system.q), np.array(system.u)]
    buffer, trigger = function.buffer()
    for k, values in enumerate(arguments[:]):
        buffer.set_arg(k, values.data)
    arguments.append(np.empty(system.size))
    buffer.set_res(0, arguments[-1].data)
    idle, empty = ca.Function("empty", [], []).buffer()
    overhead = empty_call(empty)
    kept = [buffer, idle, *arguments]  # a trigger does not keep its buffer alive

    def batch(calls: int) -> float:
        return python_batch(trigger, overhead=overhead)(calls * bool(kept))

    return batch
