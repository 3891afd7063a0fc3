"""Models with the parameters of all runs: values that are right by themselves, but not together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.system.component import ModelFile
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem
from m4e_fmi.model import Model, load_model
from m4e_fmi.study.names import Named
from m4e_fmi.units import number_in, parse_unit


def model_problems(model: Model, names: Sequence[str], values: np.ndarray) -> list[Problem]:
    """Faults of a model with the values of runs, each once, by the first run that has it.

    `values` (n_runs, n_names) are those of the parameters `names`, in SI units.
    """
    first: dict[Problem, Problem] = {}
    count: Counter[Problem] = Counter()
    check = model.check_of(names)
    for row, runs in Counter(map(tuple, values.tolist())).items():
        for problem in check(dict(zip(names, row, strict=True))):
            fault = replace(problem, message="")
            first.setdefault(fault, problem)
            count[fault] += runs
    of = f"of {len(values)} runs"
    return [replace(p, message=f"{p.message}: in {count[f]} {of}") for f, p in first.items()]


def system_problems(named: Named, system: System) -> Iterator[Problem]:
    """The same of the models of a system whose files do not change.

    The system has the start values of all runs; of the targets each by itself is right.
    """
    grid = named.study.grid
    for component in system.components:
        varied = {n: t for n, t in named.starts.items() if t.component == component.name}
        source = component.source
        if not varied or named.keys(component.name) or not isinstance(source, ModelFile):
            continue
        model = load_model(source.path)
        fixed: dict[str, float] = {}
        for name, value in component.start.items():
            if name in model.parameters and isinstance(value, int | float | str):
                with suppress(ValueError):  # told where start values are checked one by one
                    unit = parse_unit(model.parameters[name].unit)
                    fixed[name] = number_in(unit.coherent_text, value)
        for target in varied.values():
            fixed.pop(target.variable, None)
        rows = [
            [*(number_in(t.unit, values[n]) for n, t in varied.items()), *fixed.values()]
            for values in map(grid.values, grid.runs)
        ]
        names = [*(t.variable for t in varied.values()), *fixed]
        yield from model_problems(model, names, np.array(rows))
