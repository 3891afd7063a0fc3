"""Models with the parameters of all runs: values that are right by themselves, but not together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.system.component import Component, ModelFile
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem
from m4e_fmi.model import Model, load_model
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.systems.targets import KeyTarget, StartTarget, Target
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


def system_problems(
    study: Study, system: System, targets: Mapping[str, Target]
) -> Iterator[Problem]:
    """The same of the models of a system whose files do not change.

    Of the `targets` each by itself is right.
    """
    keyed = {t.component for t in targets.values() if isinstance(t, KeyTarget)}
    starts = [(n, t) for n, t in targets.items() if isinstance(t, StartTarget)]
    for component in system.components:
        varied = [(n, t) for n, t in starts if t.component == component.name]
        if not varied or component.name in keyed or not isinstance(component.source, ModelFile):
            continue
        model = load_model(component.source.path)
        varied = [(n, t) for n, t in varied if t.variable in model.parameters]
        fixed = _fixed(study, component, model)
        for _, target in varied:
            fixed.pop(target.variable, None)
        names = [*(t.variable for _, t in varied), *fixed]
        runs = map(study.grid.values, study.grid.runs)
        rows = [
            [*(number_in(t.unit, values[n]) for n, t in varied), *fixed.values()] for values in runs
        ]
        if varied:
            yield from model_problems(model, names, np.array(rows))


def _fixed(study: Study, component: Component, model: Model) -> dict[str, float]:
    """Parameters that the system or the study gives to all runs [SI]."""
    own = f"{component.name}."
    given = {n.removeprefix(own): v for n, v in study.start.items() if n.startswith(own)}
    found: dict[str, float] = {}
    for name, value in {**component.start, **given}.items():
        if name in model.parameters and isinstance(value, int | float | str):
            with suppress(ValueError):  # told where start values are checked one by one
                unit = parse_unit(model.parameters[name].unit)
                found[name] = number_in(unit.coherent_text, value)
    return found
