"""Rates and outputs of a program around a point, and their averages over motions.

A motion is rows of steps from the point: of coordinates (free attitudes by rotation vectors), their
velocities and other states, in the order of `Linearization.states`. Of free attitudes rates are
angular velocities, which are those of the rotation vector to second order of the angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.analysis.attitudes import attitudes, rotated
from m4e_fmi.analysis.linearization import Linearization, Linearizer
from m4e_fmi.analysis.points import Evaluation, Floats, OperatingPoint
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program

Complex = NDArray[np.complex128]


class LocalEquations:
    """The equations of `program` around `point`, with `inputs` and `outputs` by name.

    Below n is the number of `states`, m of inputs, k of outputs, s of rows. All are in SI.
    """

    def __init__(
        self,
        program: Program,
        point: OperatingPoint,
        *,
        inputs: Sequence[str],
        outputs: Sequence[str],
    ) -> None:
        self.point = point
        names = list(dict.fromkeys(outputs))
        self._linear = linear = Linearizer(program, inputs=inputs, outputs=names)
        self.states, self.inputs, self.outputs = linear.states, linear.inputs, linear.outputs
        if not (self.outputs and self.states):
            what = "state that moves" if self.outputs else "output to show"
            message = f"{program.name}: it has no {what}"
            raise InputError.single(message, "name outputs of what moves: --outputs NAME")
        self._attitudes = attitudes(program)

    @cached_property
    def _values(self) -> _Many:
        return _Many(self._linear.everything, [v.name for v in self.inputs])

    @cached_property
    def _entries(self) -> _Many:
        return _Many(self._linear.derivatives.program, [v.name for v in self.inputs])

    @cached_property
    def at_rest(self) -> Linearization:
        """The linear equations about the point itself."""
        return self._linear.at(self.point)

    @property
    def n(self) -> int:
        """The number of states."""
        return len(self.states)

    @cached_property
    def curved(self) -> list[int]:
        """Columns of states, then inputs, that the derivatives depend on."""
        program = self._linear.derivatives.program
        names = program.tape.symbols_of_each(list(program.results)).values()
        needed = set[str]().union(*names)
        known = self._linear.program.states
        turned = {k for a in self._attitudes for k in a.quaternion}
        if any(known[k].name in needed for k in turned):
            needed |= {known[k].name for k in turned}
        columns = [v.name for v in (*self.states, *self.inputs)]
        for a in self._attitudes:
            if known[a.quaternion[0]].name in needed:
                needed |= {v.name for v in a.rotations}
        return [k for k, name in enumerate(columns) if name in needed]

    def values(self, steps: Floats, forces: Floats) -> Floats:
        """Rates, then outputs (s, n + k), at `steps` (s, n) with inputs `forces` (s, m), in SI."""
        linear = self._linear
        states = self._moved(steps)
        found = self._values.over(self.point, states, forces)
        full = len(linear.order)
        rates, outputs = found[:, :full], found[:, linear.rows]
        if self._attitudes:
            pairs = zip(states[:, linear.order], rates, strict=True)
            rates = np.array([linear.small.inverse(x) @ rate for x, rate in pairs])
        return np.concatenate([rates, outputs], axis=1)

    def averages(self, steps: Floats, forces: Floats, weights: Complex) -> Complex:
        """Derivatives (w, n + k, n + m) of rates and outputs by states and inputs, SI, weighted.

        The sum over the rows of `steps` (s, n) and `forces` (s, m), in SI, times each of `weights`
        (w, s) [1].
        """
        linear = self._linear
        states = self._moved(steps)
        entries = self._entries.over(self.point, states, forces).astype(complex)
        if not self._attitudes:
            return np.array([self._matrix(row) for row in weights @ entries])
        full = len(linear.order)
        rates = self._values.over(self.point, states, forces)[:, :full]
        shape = (len(weights), self.n + len(self.outputs), self.n + len(self.inputs))
        found = np.zeros(shape, complex)
        for state, rate, row, weight in zip(states, rates, entries, weights.T, strict=True):
            x = state[linear.order]
            T, back, matrix = linear.small.tangent(x), linear.small.inverse(x), self._matrix(row)
            matrix = np.concatenate([matrix[:, :full] @ T, matrix[:, full:]], axis=1)
            matrix[:full, : self.n] -= linear.small.turns(rate)
            matrix = np.concatenate([back @ matrix[:full], matrix[full:]])
            found += weight[:, None, None] * matrix
        return found

    def _matrix(self, entries: Complex) -> Complex:
        """The derivatives that have these `entries`: rates, then outputs, by numbers of states."""
        places, full = self._linear.derivatives, len(self._linear.order)
        matrix = np.zeros((len(places.rows), len(places.columns)), complex)
        matrix[list(places.row_indices), list(places.column_indices)] = entries
        return np.concatenate([matrix[:full], matrix[self._linear.rows]])

    def _moved(self, steps: Floats) -> Floats:
        """The program's states (s, n) at the `steps`."""
        states = np.tile(self.point.states, (len(steps), 1))
        turned = {k for a in self._attitudes for k in a.quaternion}
        plain = [k for k in self._linear.order if k not in turned]
        names = [v.name for v in self.states]
        known = self._linear.program.states
        columns = [names.index(known[k].name) for k in plain]
        states[:, plain] += steps[:, columns]
        for a in self._attitudes:
            first = names.index(a.rotations[0].name)
            for row, step in zip(states, steps, strict=True):
                places = list(a.quaternion)
                row[places] = rotated(row[places], step[first : first + 3])
        return states


class _Many(Evaluation):
    """Outputs of a program for many rows of its states and of the inputs `names`."""

    def __init__(self, program: Program, names: Sequence[str]) -> None:
        moved = {v.name: v for v in program.inputs}
        zero = program.tape.constant(0.0).index
        self._kept = [k for k, v in enumerate(program.inputs) if v.name not in names]
        places = {v.name: k for k, v in enumerate(program.inputs)}
        self._moved = [places[name] for name in names]
        super().__init__(
            replace(
                program,
                inputs=tuple(program.inputs[k] for k in self._kept),
                states=(*program.states, *(moved[name] for name in names)),
                rates=(*program.rates, *(zero for _ in names)),
            )
        )

    def over(self, point: OperatingPoint, states: Floats, forces: Floats) -> Floats:
        """Outputs (s, outputs) for `states` (s, n), and `forces` (s, m) beside those of `point`."""
        forces, inputs = forces + point.inputs[self._moved], point.inputs[self._kept]
        rows = np.concatenate([states, forces], axis=1)
        if self._engine is not None:
            self._engine.set_parameters(point.parameters)
            self._engine.set_inputs(inputs)
            return self._engine.outputs_over(np.full(len(rows), point.time), rows)
        assert self._form is not None
        parameters = point.parameters.tolist()
        constants = self._form.constants(parameters)
        given = (inputs.tolist(), parameters, constants)
        return np.array([self._form.outputs(point.time, row, *given) for row in rows.tolist()])
