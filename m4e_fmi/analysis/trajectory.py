"""Exact sensitivities of a trajectory: ẋ = f(t, x, p) and ṡ = (∂f/∂x) s + ∂f/∂p together.

s = ∂x/∂p is integrated beside x, by the same method and under the same error control. Its rates are
the tangent of the program (Hairer, Nørsett, Wanner, "Solving Ordinary Differential Equations I",
2nd edition, section I.14).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from m4e_fmi.analysis.points import (
    Floats,
    System,
    causes,
    observed,
    place,
    program_and_model,
    unit_by,
)
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder, Variable, tangent
from m4e_fmi.shown import span, table
from m4e_fmi.simulate import simulate, started


@dataclass(frozen=True)
class TrajectorySensitivity:
    """`values[k, i]` of of[i], and `derivatives[k, i, j]` = d of[i] / d by[j], at `time[k]` [s]."""

    time: Floats = field(repr=False)
    of: tuple[Variable, ...]
    by: tuple[Variable, ...]
    values: Floats = field(repr=False)
    derivatives: Floats = field(repr=False)

    def __getitem__(self, names: tuple[str, str]) -> Floats:
        """d of / d by over time, by the names (of, by), shape (n_times,), in their SI units."""
        return self.derivatives[:, place(names[0], self.of), place(names[1], self.by)]

    def __repr__(self) -> str:
        head = ("", "", "at the end", "largest", "")
        rows = [
            (f"d({y.name})", f"/ d({p.name})", f"{change[-1]:.6g}", f"{max(change, key=abs):.6g}",
             unit_by(y, p))
            for y, p in product(self.of, self.by)
            for change in [self[y.name, p.name]]
        ]  # fmt: skip
        return table(f"TrajectorySensitivity: {span(self.time)}", "<<>><", head, *rows)


def trajectory_sensitivity(
    system: System,
    *,
    of: Sequence[str],
    by: Sequence[str],
    stop_time: float,
    output_interval: float = 0.01,
    start_values: Mapping[str, float | str] | None = None,
    tolerance: float = 1e-8,
    method: str = "dop853",
) -> TrajectorySensitivity:
    """Derivatives over time of outputs or states `of` by parameters, inputs or start values `by`.

    `by` names parameters, inputs (held constant), or states, which means their start value; the
    start values do not change with the parameters. The rest is as for `simulate`. One integration
    for each of `by`. Raises InputError for an unknown name, RunError if the integration fails.
    """
    program, model = program_and_model(system)
    program = started(program, start_values or {}, model)
    sources = causes(program, by, states=True)
    chosen = observed(program, of)
    rates = [name for name in of if name.startswith("der(")]
    if rates:
        message = f"sensitivities over time are of outputs and states, got {', '.join(rates)}"
        raise InputError.single(message, "take the output that is the acceleration")
    augmented = _augmented(chosen, [v.name for v in sources])
    runs = [
        simulate(
            augmented,
            stop_time=stop_time,
            output_interval=output_interval,
            start_values={f"d({source.name})": 1.0},
            tolerance=tolerance,
            method=method,
        )
        for source in sources
    ]
    names = [v.name for v in chosen.outputs]
    return TrajectorySensitivity(
        time=runs[0].time,
        of=chosen.outputs,
        by=sources,
        values=np.column_stack([runs[0][name] for name in names]),
        derivatives=np.stack(
            [np.column_stack([run[f"d({name})"] for name in names]) for run in runs], axis=-1
        ),
    )


def _augmented(program: Program, by: Sequence[str]) -> Program:
    """`program` and its tangent: for every state x a state d(x), for the rest of `by` an input."""
    states = {v.name for v in program.states}
    named = zip(program.outputs, program.results, strict=True)
    outputs = {v: k for v, k in named if v.name not in states}
    program = replace(program, outputs=tuple(outputs), results=tuple(outputs.values()))
    along = [*(v.name for v in program.states), *(name for name in by if name not in states)]
    change = tangent(program, along)
    tape = program.tape
    recorder = Recorder(program.name, f"{program.description}, and its tangent", tape=tape)
    for parameter in program.parameters:
        recorder.parameter(parameter)
    moving = {f"d({name})" for name in states}
    for variable in change.inputs:
        if variable.name not in moving:
            recorder.input(variable)
    for v, rate in zip(program.states, program.rates, strict=True):
        recorder.state(v)
        recorder.rate(v.name, tape.scalar(rate))
    slopes = dict(zip((v.name for v in change.outputs), change.results, strict=True))
    for v in program.states:
        recorder.state(Variable(f"d({v.name})", v.unit, f"Change of {v.name}"))
        recorder.rate(f"d({v.name})", tape.scalar(slopes[f"d(der({v.name}))"]))
    for v, k in outputs.items():
        name = f"d({v.name})"
        recorder.output(v, tape.scalar(k))
        recorder.output(Variable(name, v.unit, f"Change of {v.name}"), tape.scalar(slopes[name]))
    return recorder.program()
