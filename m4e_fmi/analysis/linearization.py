"""Linear equations about an operating point, from exact derivatives.

With x = (q, u, other states) a program ẋ = f(t, x, inputs), y = g(t, x, inputs) becomes

    δẋ = A δx + B δinput,        δy = C δx + D δinput

and a multibody system, whose mass matrix M is known,

    M δq̈ + C δq̇ + K δq = F δinput

with K = −M ∂q̈/∂q, C = −M ∂q̈/∂q̇, F = M ∂q̈/∂input. That is the derivative of M q̈ − f(t, q, q̇, input)
itself, (∂M/∂q) q̈ included, so both forms are exact about any point: moving, accelerated, loaded.
A system of several programs has other states s, too, such as the memory of water: then S δs with
S = −M ∂q̈/∂s is added on the left.

States that are integrals of others and on which nothing depends, such as an energy that is counted,
would be eigenvalues of zero; they are left out, unless an output asks for them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from m4e_fmi.analysis.attitudes import SmallRotations, attitudes
from m4e_fmi.analysis.points import (
    At,
    Evaluation,
    Floats,
    Lines,
    Matrix,
    OperatingPoint,
    System,
    causes,
    integrals,
    motion,
    observed,
    operating_point,
    program_and_model,
)
from m4e_fmi.model import Model
from m4e_fmi.multibody import mass_matrix_program
from m4e_fmi.program import Jacobian, Part, Program, Variable, jacobian, tangent
from m4e_fmi.shown import listing, short

MassMatrix = Callable[[OperatingPoint], Floats]
"""The mass matrix (n, n) [kg, kg.m, kg.m2] at a point, in the order of the coordinates."""


def mass_matrix(program: Program, model: Model | None, size: int) -> MassMatrix | None:
    """The mass matrix of a program with `size` coordinates; None unless models have all of them.

    It is that of `model`, or of the parts of `program` that come from models, one after the other.
    """
    if model is not None:
        evaluation = Evaluation(mass_matrix_program(model))
        return lambda point: evaluation.at(point).reshape(size, size)
    masses = [_of_part(program, part) for part in program.parts if isinstance(part.origin, Model)]
    if not masses or sum(count for _, count in masses) != size:
        return None
    return lambda point: np.asarray(block_diag(*(mass(point) for mass, _ in masses)), dtype=float)


def _of_part(program: Program, part: Part) -> tuple[MassMatrix, int]:
    """The mass matrix of a part, whose values follow from those of `program`; its size."""
    assert isinstance(part.origin, Model)
    mass = mass_matrix_program(part.origin)
    names = [v.name for v in (*mass.parameters, *mass.inputs, *mass.states)]
    variables = tuple(Variable(f"{part.name}.{name}", "1", "value in the part") for name in names)
    nodes = tuple(part.nodes[name] for name in names)
    values = Evaluation(replace(program, outputs=variables, results=nodes))
    evaluation = Evaluation(mass)
    count = round(len(mass.outputs) ** 0.5)

    def at(point: OperatingPoint) -> Floats:
        own = dict(zip(names, values.at(point).tolist(), strict=True))
        inner = operating_point(mass, own, time=point.time)
        return evaluation.at(inner).reshape(count, count)

    return at, count


Coefficients = Any
"""An array, or a SymPy matrix."""


@short
@dataclass(frozen=True)
class Mechanical:
    """M δq̈ + C δq̇ + K δq + S δs = F δinput, of the coordinates' generalised forces.

    For n coordinates, m inputs and k other states M, C, K are n×n, F n×m, S n×k. Rows of angles and
    small rotations are in N·m, others in N. Of a free attitude δq̇ is that of its angular velocity.
    """

    M: Coefficients
    C: Coefficients
    K: Coefficients
    F: Coefficients
    S: Coefficients


@dataclass(frozen=True)
class Linearization:
    """δẋ = A δx + B δinput, δy = C δx + D δinput about `point`.

    `states` are in the order of x: coordinates, their velocities, other states. `rates` = ẋ and
    `values` = y at the point itself, of which the equations give the change. `mechanical` is None
    where a coordinate belongs to no model.
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
        self._attitudes = attitudes(self.program)
        known = self.program.states
        rotations = {a.quaternion: a.rotations for a in self._attitudes}
        turned = [(a.quaternion, a.turning) for a in self._attitudes]
        # in the order of the mass matrix
        pairs = sorted([*(((q,), (u,)) for q, u in motion(self.program)), *turned])
        moved = [k for pair in zip(*pairs, strict=True) for part in pair for k in part]
        counted = integrals(self.program, outputs or ()) - set(moved)
        rest = [k for k in range(len(known)) if k not in counted.union(moved)]
        self.order = [*moved, *rest]
        """Indices of the program's states that are linearised, with all numbers of quaternions."""
        self.small = SmallRotations(self._attitudes, self.order)
        coordinates = [v for q, _ in pairs for v in rotations.get(q) or (known[q[0]],)]
        self._coordinates = len(coordinates)
        self.states = (
            *coordinates,
            *(known[k] for _, u in pairs for k in u),
            *(known[k] for k in rest),
        )
        """Coordinates (of a free attitude small rotations), their velocities, other states."""
        self.inputs = causes(self.program, inputs, states=False)
        names = [known[k].name for k in self.order]
        wanted = names if outputs is None else list(outputs)
        self.outputs = observed(self.program, wanted).outputs
        rows = list(dict.fromkeys([*(f"der({name})" for name in names), *wanted]))
        self.rows = [rows.index(name) for name in wanted]
        """Places of `outputs` among those of `everything`."""
        self.everything = observed(self.program, rows)
        """The program with the rates of the states of `order` as outputs, then `outputs`."""
        self._values = Evaluation(self.everything)
        self._lines = Lines(self.program)
        by = [*names, *(v.name for v in self.inputs)]
        self._slopes = Matrix(jacobian(self.everything, "outputs", by))
        self._changes: dict[tuple[str, ...], Evaluation] = {}
        self._mass = mass_matrix(self.program, self._model, len(coordinates))

    @property
    def derivatives(self) -> Jacobian:
        """Those of the outputs of `everything` by the states of `order`, then by `inputs`."""
        return self._slopes.derivatives

    def at(self, at: At = None, *, time: float | None = None) -> Linearization:
        """The linear equations about a point; RunError where a force has no derivative."""
        point = operating_point(self.program, at, time=time, model=self._model)
        self._lines.check(point)
        n = len(self.order)
        values, slopes = self._values.at(point), self._slopes.at(point)
        x, turning = point.states[self.order], self.small.turns(values[:n])
        T, back = self.small.tangent(x), self.small.inverse(x)
        A, B = back @ (slopes[:n, :n] @ T - turning), back @ slopes[:n, n:]
        mechanical = None
        if self._mass is not None:
            q = self._coordinates
            M, speeds = self._mass(point), slice(q, 2 * q)
            columns = (slice(q), speeds, slice(2 * q, None))
            K, C, S = (-M @ A[speeds, part] for part in columns)
            mechanical = Mechanical(M, C=C, K=K, F=M @ B[speeds], S=S)
        return Linearization(
            point=point,
            states=self.states,
            inputs=self.inputs,
            outputs=self.outputs,
            A=A,
            B=B,
            C=slopes[self.rows, :n] @ T,
            D=slopes[self.rows, n:],
            rates=back @ values[:n],
            values=values[self.rows],
            mechanical=mechanical,
            degrees_of_freedom=self._coordinates,
        )

    def change(self, point: OperatingPoint, direction: Mapping[str, float]) -> Floats:
        """Derivative of A along a change of parameters, inputs, states, shape (n, n), in SI.

        Exact second derivatives. Variables that `direction` does not name do not change; a free
        attitude changes by the numbers of its quaternion.
        """
        n = len(self.order)
        rates, slopes = self._changed(point, direction)
        if not self._attitudes:
            return slopes
        small, x = self.small, point.states[self.order]
        moved = np.array([direction.get(self.program.states[k].name, 0.0) for k in self.order])
        T, back = small.tangent(x), small.inverse(x)
        still = self._slopes.at(point)[:n, :n]
        inner = still @ T - small.turns(self._values.at(point)[:n])
        change = slopes @ T + still @ small.turns(moved) - small.turns(rates)
        return small.inverse_change(x, moved) @ inner + back @ change

    def _changed(
        self, point: OperatingPoint, direction: Mapping[str, float]
    ) -> tuple[Floats, Floats]:
        """Changes of the rates (n,) of the program's states and of ∂rates/∂states (n, n)."""
        along, n = tuple(direction), len(self.order)
        slopes = self._slopes.derivatives
        places = enumerate(zip(slopes.row_indices, slopes.column_indices, strict=True))
        kept = {k: place for k, place in places if max(place) < n}
        if along not in self._changes:
            outputs = tuple(slopes.program.outputs[k] for k in kept)
            results = tuple(slopes.program.results[k] for k in kept)
            change = tangent(replace(slopes.program, outputs=outputs, results=results), along)
            self._changes[along] = Evaluation(change)
        found = self._changes[along].at(point, *direction.values())
        result, count = np.zeros((n, n)), len(self.program.states)  # with those that are left out
        for place, entry in zip(kept.values(), found[count:], strict=True):
            result[place] = entry
        return found[:count][self.order], result

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
    """The linear equations of a model or system about a point.

    `system` is a Model, a model file, or the Program of a system (`system_program`). `at` has
    values of states, inputs and parameters by name (SI; start values if absent), or is the result
    of `equilibrium`; `time` in s.
    `inputs` names inputs or parameters, `outputs` outputs or states: none, and the states, if not
    said. Raises InputError for an unknown name.
    """
    return Linearizer(system, inputs=inputs, outputs=outputs).at(at, time=time)
