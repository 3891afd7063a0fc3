"""Linear equations as SymPy expressions, for small models."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from m4e_fmi.analysis.attitudes import twice_tangent
from m4e_fmi.analysis.linearization import Mechanical
from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.model import Model
from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.model_program.declaration import state_names
from m4e_fmi.multibody.topology import Link
from m4e_fmi.shown import listing

if TYPE_CHECKING:
    import sympy


class SymbolicLinearization:
    """M δq̈ + C δq̇ + K δq = F δinput and A, B, C, D of a model, for any point.

    The matrices are functions of the symbols of `equations`: coordinates, velocities, parameters,
    the chosen inputs, and where the system accelerates at the point, `equations.u_dot`. States are
    (q, u), with three small rotations in place of a quaternion. `inputs` and `outputs` are as for
    `linearize`, parameters apart. Everything is computed when it is asked for and never simplified;
    InputError for an unknown name.
    """

    def __init__(
        self, model: Model, *, inputs: Sequence[str] = (), outputs: Sequence[str] | None = None
    ) -> None:
        self.equations = Equations(model, inputs)
        self._outputs = outputs

    @cached_property
    def mechanical(self) -> Mechanical:
        """M, C, K, F: derivatives of M(q) q̈ − f(t, q, q̇, input)."""
        e = self.equations
        rest = e.mass_matrix * e.u_dot - e.forcing
        F = -rest.jacobian(self._inputs) if self._inputs else _empty(rest.rows, 0)
        K = rest.jacobian(e.q) * self._tangent
        return Mechanical(e.mass_matrix, rest.jacobian(e.u), K, F, _empty(rest.rows, 0))

    @cached_property
    def A(self) -> sympy.Matrix:
        """2n×2n."""
        import sympy

        u = self.equations.u
        turning = sympy.zeros(len(u), len(u))
        for link in self._free:
            x, y, z = (u.flat()[k] for k in link.speeds[-3:])
            skew = sympy.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])  # rates of rotations: ω × θ
            turning[link.speeds[-3], link.speeds[-3]] = skew
        return turning.row_join(sympy.eye(len(u))).col_join(self._accelerations)

    @cached_property
    def B(self) -> sympy.Matrix:
        """2n×m."""
        return _empty(len(self.equations.u), len(self._inputs)).col_join(self._forced)

    @cached_property
    def C(self) -> sympy.Matrix:
        """Rows of the outputs, 2n columns."""
        e = self.equations
        direct = (self._y.jacobian(e.q) * self._tangent).row_join(self._y.jacobian(e.u))
        return direct + self._y.jacobian(e.u_dot) * self._accelerations

    @cached_property
    def D(self) -> sympy.Matrix:
        """Rows of the outputs, m columns."""
        direct = self._y.jacobian(self._inputs) if self._inputs else _empty(self._y.rows, 0)
        return direct + self._y.jacobian(self.equations.u_dot) * self._forced

    @property
    def _free(self) -> list[Link]:
        """Links with free attitudes."""
        return [link for link in self.equations.topology.links if link.joint_type.has_quaternion]

    @cached_property
    def _tangent(self) -> sympy.Matrix:
        """Change of q by small rotations and the other coordinates, in the order of u."""
        import sympy

        e = self.equations
        turned = {k for link in self._free for k in link.coordinates[-4:]}
        T = sympy.zeros(len(e.q), len(e.u))
        for link in e.topology.links:
            for k, j in zip(link.coordinates, link.speeds, strict=False):
                T[k, j] = int(k not in turned)
        for link in self._free:
            quaternion = [e.q[k] for k in link.coordinates[-4:]]
            T[link.coordinates[-4], link.speeds[-3]] = sympy.Matrix(twice_tangent(quaternion)) / 2
        return T

    @cached_property
    def _inputs(self) -> list[sympy.Symbol]:
        import sympy

        return [sympy.Symbol(name, real=True) for name in self.equations.inputs]

    @cached_property
    def _accelerations(self) -> sympy.Matrix:
        """∂q̈/∂(q, q̇)."""
        m = self.mechanical
        return m.M.LUsolve(-m.K.row_join(m.C))

    @cached_property
    def _forced(self) -> sympy.Matrix:
        """∂q̈/∂input."""
        m = self.mechanical
        return m.M.LUsolve(m.F) if self._inputs else m.F

    @cached_property
    def _y(self) -> sympy.Matrix:
        """The outputs as functions of q, u, u̇ and inputs."""
        import sympy

        e = self.equations
        pairs = [state_names(link) for link in e.topology.links]
        states = [name for half in zip(*pairs, strict=True) for names in half for name in names]
        known = dict(zip(states, [*e.q, *e.u], strict=True))
        names = list(known) if self._outputs is None else self._outputs
        if not set(names) <= set(known):
            known |= e.outputs
        unknown = [name for name in names if name not in known]
        if unknown:
            message = f"{e.model.name} has no output or state {', '.join(unknown)}"
            raise InputError.single(message, suggestion(unknown[0], known))
        return sympy.Matrix([known[name] for name in names])

    def __repr__(self) -> str:
        e = self.equations
        names = [] if self._outputs is None else self._outputs
        title = f"SymbolicLinearization of {e.model.name!r}"
        return listing(title, q=e.topology.coordinate_names, inputs=e.inputs, outputs=names)


def _empty(rows: int, columns: int) -> sympy.Matrix:
    import sympy

    return sympy.zeros(rows, columns)
