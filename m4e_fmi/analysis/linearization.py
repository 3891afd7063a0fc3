"""Linear equations about an operating point, from exact derivatives.

With x = (q, u, other states) a program ẋ = f(t, x, inputs), y = g(t, x, inputs) becomes

    δẋ = A δx + B δinput,        δy = C δx + D δinput

and a multibody system, whose mass matrix M is known,

    M δq̈ + C δq̇ + K δq = F δinput

with K = −M ∂q̈/∂q, C = −M ∂q̈/∂q̇, F = M ∂q̈/∂input. That is the derivative of M q̈ − f(t, q, q̇, input)
itself, (∂M/∂q) q̈ included, so both forms are exact about any point: moving, accelerated, loaded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from m4e_fmi.analysis.attitudes import attitudes, tangent_of
from m4e_fmi.analysis.points import (
    At,
    Evaluation,
    Floats,
    Lines,
    Matrix,
    OperatingPoint,
    System,
    causes,
    motion,
    observed,
    operating_point,
    program_and_model,
)
from m4e_fmi.errors import RunError
from m4e_fmi.multibody import mass_matrix_program
from m4e_fmi.program import Variable, jacobian, tangent
from m4e_fmi.shown import listing, short

if TYPE_CHECKING:
    import control


Coefficients = Any
"""An array, or a SymPy matrix."""


@short
@dataclass(frozen=True)
class Mechanical:
    """M δq̈ + C δq̇ + K δq = F δinput: n×n, n×n, n×n, n×m, of the coordinates' generalised forces.

    Rows of a revolute coordinate are in N·m, of any other in N.
    """

    M: Coefficients
    C: Coefficients
    K: Coefficients
    F: Coefficients


@dataclass(frozen=True)
class Linearization:
    """δẋ = A δx + B δinput, δy = C δx + D δinput about `point`.

    `states` are in the order of x: coordinates, their velocities, other states. `rates` = ẋ and
    `values` = y at the point itself, of which the equations give the change. `mechanical` is None
    of a program that comes from no model.
    """

    point: OperatingPoint
    states: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    A: Floats = field(repr=False)
    B: Floats = field(repr=False)
    C: Floats = field(repr=False)
    D: Floats = field(repr=False)
    rates: Floats = field(repr=False)
    values: Floats = field(repr=False)
    mechanical: Mechanical | None = field(repr=False)
    degrees_of_freedom: int

    @cached_property
    def coordinates(self) -> tuple[Variable, ...]:
        """The states that have a velocity among the states; of a free attitude small rotations."""
        return self.states[: self.degrees_of_freedom]

    def to_control(self) -> control.StateSpace:
        """A, B, C, D for python-control, names with _ where they have a dot.

        RunError if python-control is not installed.
        """
        try:
            import control
        except ImportError:
            message = "python-control is not installed"
            raise RunError(message, "pip install 'm4e_fmi[control]'") from None

        def names(variables: Sequence[Variable]) -> list[str]:
            return [v.name.replace(".", "_") for v in variables]

        return control.StateSpace(
            self.A,
            self.B,
            self.C,
            self.D,
            states=names(self.states),
            inputs=names(self.inputs),
            outputs=names(self.outputs),
            name=self.point.program.name,
        )

    def __repr__(self) -> str:
        return listing(
            f"Linearization of {self.point.program.name!r} at t = {self.point.time:g} s: "
            f"A {_shape(self.A)}, B {_shape(self.B)}, C {_shape(self.C)}, D {_shape(self.D)}"
            f"{', mechanical M, C, K, F' if self.mechanical else ''}",
            states=self.states,
            inputs=self.inputs,
            outputs=self.outputs,
        )


class Linearizer:
    """Linearises one system wherever it is asked to; the derivatives are recorded once.

    `inputs` names inputs or parameters of the system, `outputs` outputs or states; without them
    there are no inputs, and the outputs are the states. InputError names what is unknown.
    """

    def __init__(
        self,
        system: System,
        *,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] | None = None,
    ) -> None:
        self.program, self._model = program_and_model(system)
        pairs, known = motion(self.program), self.program.states
        self._attitudes = attitudes(self.program)
        turning = [k for a in self._attitudes for k in a.turning]
        quaternions = [k for a in self._attitudes for k in a.quaternion]
        positions, velocities = [k for k, _ in pairs], [*(v for _, v in pairs), *turning]
        passed = {*positions, *velocities, *quaternions}
        rest = [k for k in range(len(known)) if k not in passed]
        self._pairs = len(positions)
        self._order = order = [*positions, *quaternions, *velocities, *rest]
        rotations = [v for a in self._attitudes for v in a.rotations]
        self.states = (
            *(known[k] for k in positions), *rotations, *(known[k] for k in (*velocities, *rest))
        )  # fmt: skip
        """Coordinates (of a free attitude small rotations), their velocities, other states."""
        self._coordinates = self._pairs + len(rotations)
        self.inputs = causes(self.program, inputs, states=False)
        names = [known[k].name for k in order]
        wanted = names if outputs is None else list(outputs)
        self.outputs = observed(self.program, wanted).outputs
        rows = list(dict.fromkeys([*(f"der({name})" for name in names), *wanted]))
        self._rows = [rows.index(name) for name in wanted]
        everything = observed(self.program, rows)
        self._values = Evaluation(everything)
        self._lines = Lines(self.program)
        by = [*names, *(v.name for v in self.inputs)]
        self._slopes = Matrix(jacobian(everything, "outputs", by))
        self._changes: dict[tuple[str, ...], Evaluation] = {}
        mass = mass_matrix_program(self._model) if self._model else None
        self._mass = Evaluation(mass) if mass else None

    def at(self, at: At = None, *, time: float | None = None) -> Linearization:
        """The linear equations about a point; RunError where a force has no derivative."""
        point = operating_point(self.program, at, time=time, model=self._model)
        self._lines.check(point)
        n = len(self._order)
        values, slopes = self._values.at(point), self._slopes.at(point)
        T, back, turning = self._tangent(point, values[:n])
        A, B = back @ (slopes[:n, :n] @ T - turning), back @ slopes[:n, n:]
        return Linearization(
            point=point,
            states=self.states,
            inputs=self.inputs,
            outputs=self.outputs,
            A=A,
            B=B,
            C=slopes[self._rows, :n] @ T,
            D=slopes[self._rows, n:],
            rates=back @ values[:n],
            values=values[self._rows],
            mechanical=self._mechanical(point, A, B),
            degrees_of_freedom=self._coordinates,
        )

    def _tangent(self, point: OperatingPoint, rates: Floats) -> tuple[Floats, Floats, Floats]:
        """T, of a change of `states` that of the program's states; its inverse; dT/dt.

        RunError if a quaternion is none.
        """
        T, back = np.eye(len(self._order)), np.eye(len(self._order))
        rate = np.zeros(T.shape)
        for rows, columns, e in self._quaternions(point.states[self._order]):
            length = float(np.linalg.norm(e))
            if not length > 0:
                owner = self.program.states[self._order[rows.start]].name.rpartition(".")[0]
                message = f"the quaternion of {owner} is zero"
                raise RunError(message, "give its four numbers, or roll, pitch and yaw")
            T[rows, rows], back[rows, rows] = 0.0, 0.0
            T[rows, columns] = tangent_of(e)
            back[columns, rows] = 4 / length**2 * tangent_of(e).T
            rate[rows, columns] = tangent_of(rates[rows])
        kept = self._kept
        return T[:, kept], back[kept], rate[:, kept]

    def _quaternions(self, states: Floats) -> list[tuple[slice, slice, Floats]]:
        """Of each quaternion in `states` (n,) in their order here: rows, columns of θ, value."""
        firsts = [self._pairs + 4 * number for number in range(len(self._attitudes))]
        return [(slice(k, k + 4), slice(k, k + 3), states[k : k + 4]) for k in firsts]

    @cached_property
    def _kept(self) -> list[int]:
        """Columns that are left where three rotations take the place of four numbers."""
        spare = [self._pairs + 4 * number + 3 for number in range(len(self._attitudes))]
        return [k for k in range(len(self._order)) if k not in spare]

    def change(self, point: OperatingPoint, direction: Mapping[str, float]) -> Floats:
        """Derivative of A along a change of parameters, inputs, states, shape (n, n), in SI.

        Exact second derivatives. Variables that `direction` does not name do not change; of a
        quaternion these are its four numbers.
        """
        n = len(self._order)
        slopes = self._slopes.at(point)[:n, :n]
        rates, slopes_change = self._changed(point, direction)
        names = [self.program.states[k].name for k in self._order]
        moved = np.array([direction.get(name, 0.0) for name in names])
        T, back, _ = self._tangent(point, np.zeros(n))
        T_change, turning_change, back_change = (np.zeros((n, n)) for _ in range(3))
        for rows, columns, e in self._quaternions(point.states[self._order]):
            square, step = float(e @ e), moved[rows]
            T_change[rows, columns] = tangent_of(step)
            turning_change[rows, columns] = tangent_of(rates[rows])
            shrunk = 8 * float(e @ step) / square**2
            back_change[columns, rows] = 4 / square * tangent_of(step).T - shrunk * tangent_of(e).T
        kept = self._kept
        result = back @ (slopes_change @ T + (slopes @ T_change - turning_change)[:, kept])
        if self._attitudes:
            values = self._values.at(point)[:n]
            _, _, turning = self._tangent(point, values)
            result += back_change[kept] @ (slopes @ T - turning)
        return result

    def _changed(
        self, point: OperatingPoint, direction: Mapping[str, float]
    ) -> tuple[Floats, Floats]:
        """Changes of the rates (n,) and of their slopes (n, n) along a direction, in order here."""
        along, n = tuple(direction), len(self._order)
        slopes = self._slopes.derivatives
        places = enumerate(zip(slopes.row_indices, slopes.column_indices, strict=True))
        kept = {k: place for k, place in places if max(place) < n}
        if along not in self._changes:
            outputs = tuple(slopes.program.outputs[k] for k in kept)
            results = tuple(slopes.program.results[k] for k in kept)
            change = tangent(replace(slopes.program, outputs=outputs, results=results), along)
            self._changes[along] = Evaluation(change)
        changes = self._changes[along].at(point, *direction.values())
        result = np.zeros((n, n))
        for place, entry in zip(kept.values(), changes[n:], strict=True):
            result[place] = entry
        return changes[:n][self._order], result

    def _mechanical(self, point: OperatingPoint, A: Floats, B: Floats) -> Mechanical | None:
        if self._mass is None:
            return None
        n = len(self.states) // 2
        M = self._mass.at(point).reshape(n, n)
        return Mechanical(M, C=-M @ A[n:, n:], K=-M @ A[n:, :n], F=M @ B[n:])

    def __repr__(self) -> str:
        return listing(
            f"Linearizer of {self.program.name!r}",
            states=self.states,
            inputs=self.inputs,
            outputs=self.outputs,
        )


def _shape(matrix: Floats) -> str:
    return "×".join(map(str, matrix.shape))


def linearize(
    system: System,
    *,
    at: At = None,
    time: float | None = None,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] | None = None,
) -> Linearization:
    """The linear equations of a system about a point.

    `system` is a Model, a model file or a Program. `at` has values of states, inputs and
    parameters by name (SI; start values if absent), or is the result of `equilibrium`; `time` in s.
    `inputs` names inputs or parameters, `outputs` outputs or states: none, and the states, if not
    said. Raises InputError for an unknown name.
    """
    return Linearizer(system, inputs=inputs, outputs=outputs).at(at, time=time)
