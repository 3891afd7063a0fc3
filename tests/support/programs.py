"""A program's Python form, called with values by name."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping

from m4e_fmi.program import Program, Variable
from m4e_fmi.program.python_form import load_python

Values = Mapping[str, float]


def random_values(program: Program, seed: int) -> dict[str, float]:
    """Random states, inputs and added mass, which is not symmetric, but positive definite."""
    r = random.Random(seed)
    values = {v.name: r.uniform(-1, 1) for v in (*program.inputs, *program.states)}
    for name in (v.name for v in program.parameters if v.name.startswith("added_mass")):
        i, j = name.removeprefix("added_mass[").removesuffix("]").split(",")
        values[name] = r.uniform(2, 3) if i == j else r.uniform(-0.1, 0.1)
    return values


class Evaluated:
    """Outputs of `program` for values by name; all others have their start value."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self._form = load_python(program)

    def rates(self, values: Values, *, t: float = 0.0) -> dict[str, float]:
        """Time derivative of each state."""
        return self._named(self.program.states, self._form.rates(t, *self._vectors(values)))

    def outputs(self, values: Values, *, t: float = 0.0) -> dict[str, float]:
        return self._named(self.program.outputs, self._form.outputs(t, *self._vectors(values)))

    def calculated(self, values: Values) -> dict[str, float]:
        _, _, p, c = self._vectors(values)
        return self._named(self.program.calculated, self._form.calculated(p, c))

    def _vectors(self, values: Values) -> tuple[list[float], ...]:
        program = self.program
        groups = (program.states, program.inputs, program.parameters)
        unknown = set(values) - {v.name for group in groups for v in group}
        assert not unknown, f"the program has no {unknown}"
        x, u, p = ([values.get(v.name, v.start) for v in group] for group in groups)
        return x, u, p, self._form.constants(p)

    @staticmethod
    def _named(variables: Iterable[Variable], values: Iterable[float]) -> dict[str, float]:
        return {v.name: value for v, value in zip(variables, values, strict=True)}
