"""A program as an FMU's variables and as the source of a Python slave."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from itertools import count
from pathlib import Path

from m4e_fmi.fmu.export.description.description import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.fmu.export.program_files import PROGRAM, model_file
from m4e_fmi.fmu.export.selection import GROUPS
from m4e_fmi.program import TIME, Program, Variable
from m4e_fmi.program.dependence import initial_kind, kinds
from m4e_fmi.program.python_form import python_source
from m4e_fmi.runtime import declarations, dormand_prince, runge_kutta
from m4e_fmi.runtime.library import library_path
from m4e_fmi.runtime.platforms import PLATFORMS, packaged

LIBRARY = "runtime.{}"  # as runtime_engine names it
PLATFORMS_OF_PYTHONFMU = {"linux": "x86_64-linux", "win32": "x86_64-windows"}
EMBEDDED = Path(__file__).parent / "embedded"


def with_rates(program: Program) -> Program:
    """`program` with the rate of every state as an output: local ``der(x)`` where none is it."""
    shown = _rates_shown(program)
    missing = [
        (Variable(f"der({v.name})", rate_unit(v.unit), _of_rate(v), 0.0, v.name, local=True), k)
        for v, k in zip(program.states, program.rates, strict=True)
        if v.name not in shown
    ]
    return replace(
        program,
        outputs=(*program.outputs, *(v for v, _ in missing)),
        results=(*program.results, *(k for _, k in missing)),
    )


def _of_rate(state: Variable) -> str:
    """A description without the state's name, which may be changed later."""
    return f"Rate: {state.description}".removesuffix(": ")


def rate_unit(unit: str) -> str:
    """The unit of the time derivative of what has `unit`."""
    if unit.endswith("/s"):
        return f"{unit}2"
    return f"{unit}.s" if "/" in unit else f"{unit}/s"


def _rates_shown(program: Program) -> dict[str, str]:
    """State → the output that is its rate."""
    rates = {v.name: k for v, k in zip(program.states, program.rates, strict=True)}
    outputs = zip(program.outputs, program.results, strict=True)
    return {
        y.derivative_of: y.name
        for y, k in outputs
        if y.derivative_of and rates.get(y.derivative_of) == k
    }


def describe(
    program: Program, *, stop_time: float = 10.0, step_size: float = 0.01
) -> ModelDescription:
    """The FMU variables of `program`: parameters, calculated, inputs, states, outputs."""
    moving = {TIME, *(v.name for v in (*program.inputs, *program.states))}
    known = moving | {v.name for v in program.parameters}
    needs = kinds(program, [*program.results, *program.constants])
    rates = _rates_shown(program)

    def parameter(v: Variable) -> FmuVariable:
        variability = "tunable" if v.tunable else "fixed"
        return _variable(v, "parameter", variability, "exact", start=v.start)

    def calculated(v: Variable, node: int) -> FmuVariable:
        tunable = any(p.tunable for p in program.parameters if p.name in needs[node])
        variability = "tunable" if tunable else "fixed"
        first = _initial(needs[node], known)
        return _variable(v, "calculatedParameter", variability, "calculated", first=first)

    def state(v: Variable) -> FmuVariable:
        now = {v.name: "constant"}
        return _variable(v, _causality(v), "continuous", "exact", start=v.start, now=now)

    def output(v: Variable, node: int) -> FmuVariable:
        now = {name: kind for name, kind in needs[node].items() if name in moving}
        first = _initial(needs[node], known)
        return _variable(v, _causality(v), "continuous", "calculated", now=now, first=first)

    variables = (
        *(parameter(v) for v in program.parameters),
        *(calculated(v, n) for v, n in zip(program.calculated, program.constants, strict=True)),
        *(_variable(v, "input", "continuous", None, start=v.start) for v in program.inputs),
        *(state(v) for v in program.states),
        *(output(v, n) for v, n in zip(program.outputs, program.results, strict=True)),
    )
    return ModelDescription(
        program.name,
        program.description,
        variables,
        stop_time=stop_time,
        step_size=step_size,
        derivatives=tuple(rates[v.name] for v in program.states)
        if len(rates) == len(program.states)
        else (),
    )


def python_slave(
    program: Program, description: ModelDescription, method: str = "dop853"
) -> PythonSource:
    """The Python slave that runs `program`; the variables of `description` follow it in order."""
    references = count()
    layout = {group: [next(references) for _ in getattr(program, group)] for group in GROUPS}
    settings = {
        "method": method,
        "tolerance": description.tolerance,
        "step_size": description.step_size,
    }
    return PythonSource(
        description=description,
        slave="program_slave:ProgramSlave",
        modules={
            "program_slave.py": EMBEDDED / "program_slave.py",
            "runtime_engine.py": EMBEDDED / "runtime_engine.py",
            "python_engine.py": EMBEDDED / "python_engine.py",
            "declarations.py": Path(declarations.__file__),
            "dormand_prince.py": Path(dormand_prince.__file__),
            "runge_kutta.py": Path(runge_kutta.__file__),
        },
        data={
            "model.py": python_source(program).encode(),
            "layout.json": json.dumps({**layout, **settings}).encode(),
            **_runtime_files(program, method),
        },
    )


def _initial(needs: Mapping[str, str], known: set[str]) -> dict[str, str]:
    return {name: initial_kind(kind) for name, kind in needs.items() if name in known}


def _runtime_files(program: Program, method: str) -> dict[str, bytes]:
    """Files that the C runtime needs, for the systems whose library is there."""
    files = {}
    for system, name in PLATFORMS_OF_PYTHONFMU.items():
        own = system == sys.platform
        path = library_path() if own else packaged("runtime", PLATFORMS[name])
        if path is not None:
            files[LIBRARY.format(system)] = path.read_bytes()
    return {**files, PROGRAM: model_file(program, method, {})} if files else {}


def _causality(v: Variable) -> str:
    return "local" if v.local else "output"


def _variable(
    v: Variable,
    causality: str,
    variability: str,
    initial: str | None,
    *,
    start: float | None = None,
    now: Mapping[str, str] | None = None,
    first: Mapping[str, str] | None = None,
) -> FmuVariable:
    now, first = now or {}, first or {}
    return FmuVariable(
        name=v.name,
        unit=v.unit,
        description=v.description,
        causality=causality,
        variability=variability,
        initial=initial,
        start=start,
        dependencies=tuple(now),
        initial_dependencies=tuple(first),
        kinds=tuple(now.values()),
        initial_kinds=tuple(first.values()),
        derivative_of=v.derivative_of,
        display_unit=v.display_unit,
        minimum=v.minimum,
        maximum=v.maximum,
        nominal=v.nominal,
    )
