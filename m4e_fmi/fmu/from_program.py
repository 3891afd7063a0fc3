"""A program as an FMU's variables and as the source of a Python slave."""

from __future__ import annotations

import json
from pathlib import Path

from m4e_fmi.fmu.description import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.program import Program, Variable
from m4e_fmi.program.python_form import python_source
from m4e_fmi.runtime import dormand_prince

EMBEDDED = Path(__file__).parent / "embedded"


def describe(
    program: Program, *, stop_time: float = 10.0, step_size: float = 0.01
) -> ModelDescription:
    """The FMU variables of `program`: parameters, calculated, inputs, states, outputs."""
    inputs = {v.name for v in program.inputs}
    knowns = inputs | {v.name for v in (*program.parameters, *program.states)}

    def parameter(v: Variable) -> FmuVariable:
        variability = "tunable" if v.tunable else "fixed"
        return _variable(v, "parameter", variability, "exact", start=v.start)

    def calculated(v: Variable, node: int) -> FmuVariable:
        needs = program.dependencies(node)
        tunable = any(p.tunable for p in program.parameters if p.name in needs)
        variability = "tunable" if tunable else "fixed"
        names = tuple(sorted(needs))
        return _variable(v, "calculatedParameter", variability, "calculated", first=names)

    def state(v: Variable) -> FmuVariable:
        return _variable(v, _causality(v), "continuous", "exact", start=v.start)

    def output(v: Variable, node: int) -> FmuVariable:
        needs = program.dependencies(node)
        return _variable(
            v,
            _causality(v),
            "continuous",
            "calculated",
            now=tuple(sorted(needs & inputs)),
            first=tuple(sorted(needs & knowns)),
        )

    variables = (
        *(parameter(v) for v in program.parameters),
        *(calculated(v, n) for v, n in zip(program.calculated, program.constants, strict=True)),
        *(_variable(v, "input", "continuous", None, start=v.start) for v in program.inputs),
        *(state(v) for v in program.states),
        *(output(v, n) for v, n in zip(program.outputs, program.results, strict=True)),
    )
    return ModelDescription(
        program.name, program.description, variables, stop_time=stop_time, step_size=step_size
    )


def python_slave(program: Program, description: ModelDescription) -> PythonSource:
    """The Python slave that runs `program`."""
    index = {v.name: k for k, v in enumerate(description.variables)}
    groups = ("parameters", "calculated", "inputs", "states", "outputs")
    layout = {group: [index[v.name] for v in getattr(program, group)] for group in groups}
    return PythonSource(
        description=description,
        slave="program_slave:ProgramSlave",
        modules={
            "program_slave.py": EMBEDDED / "program_slave.py",
            "dormand_prince.py": Path(dormand_prince.__file__),
        },
        data={
            "model.py": python_source(program).encode(),
            "layout.json": json.dumps(layout).encode(),
        },
    )


def _causality(v: Variable) -> str:
    return "local" if v.local else "output"


def _variable(
    v: Variable,
    causality: str,
    variability: str,
    initial: str | None,
    *,
    start: float | None = None,
    now: tuple[str, ...] = (),
    first: tuple[str, ...] = (),
) -> FmuVariable:
    return FmuVariable(
        name=v.name,
        unit=v.unit,
        description=v.description,
        causality=causality,
        variability=variability,
        initial=initial,
        start=start,
        dependencies=now,
        initial_dependencies=first,
        derivative_of=v.derivative_of,
        display_unit=v.display_unit,
    )
