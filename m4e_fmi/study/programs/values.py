"""Start values of a study of one program that do not fit, told by their lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from m4e_fmi.errors import InputError, Problem, UnknownNameError
from m4e_fmi.model import Model
from m4e_fmi.program import Program, Variable
from m4e_fmi.simulate import started
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.systems.targets import StartTarget, Target
from m4e_fmi.units import number_in


def start_problems(study: Study, targets: Mapping[str, Target], program: Program) -> list[Problem]:
    """Start values of all runs, and varied ones, that their variables do not take, by their lines.

    What is unknown is told by `unknown_starts`, what is of an attitude by `started`.
    """
    known = {v.name: v for v in (*program.parameters, *program.inputs, *program.states)}
    problems: list[Problem] = []
    for name, value in study.start.items():
        if name not in known:
            continue
        at = ("start", name)
        try:
            number = number_in(known[name].unit, value)
        except ValueError as error:
            problems.append(study.document.problem(at, f"{name}: {error}"))
            continue
        problems += [study.document.problem(at, text) for text in _outside(known[name], [number])]
    for axis in study.grid.axes:
        for k, varied in enumerate(axis.varied):
            for target in map(targets.get, varied.targets):
                if not isinstance(target, StartTarget):
                    continue
                values = list(dict.fromkeys(point[k] for point in axis.points))
                try:
                    numbers = [number_in(target.unit, value) for value in values]
                except ValueError as error:
                    texts = [f"{target.variable}: {error}"]
                else:
                    texts = _outside(known[target.variable], numbers)
                problems += [study.document.problem(varied.location, text) for text in texts]
    return problems


def unknown_starts(study: Study, program: Program, model: Model | None) -> list[Problem]:
    """Start values of all runs whose names the program does not know, one by one."""
    known = {v.name for v in (*program.parameters, *program.inputs, *program.states)}
    problems: list[Problem] = []
    for name, value in study.start.items():
        if name not in known:
            try:
                started(program, {name: value}, model)
            except UnknownNameError as error:
                problems += [
                    study.document.problem(("start", name), p.message, p.remedy)
                    for p in error.problems
                ]
            except InputError:  # of an attitude: told with all start values
                pass
    return problems


def _outside(one: Variable, numbers: Sequence[float]) -> list[str]:
    """A message for each number that is outside the range of a variable."""
    limits = f"is outside its range from {one.minimum:g} to {one.maximum:g}"
    return [f"{one.name} = {x:g} {limits}" for x in numbers if not one.minimum <= x <= one.maximum]
