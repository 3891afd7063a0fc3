"""All problems of a study of a system that can be told before an FMU is built, at once."""

from __future__ import annotations

from collections.abc import Iterator

from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.study.given.study import STOP_TIME, Study
from m4e_fmi.study.runs.start_up import RAMP, check_start_up, start_up
from m4e_fmi.study.systems.names import changed, resolved
from m4e_fmi.study.systems.plan import Versions, versions


def checked(study: Study, system: System, *, quick: bool = False) -> Versions:
    """The versions of the components of a study, as `versions`.

    InputError with all problems of names, of values, of sections with these, and of the start-up.
    """
    named, problems = resolved(study, system)
    try:
        made = versions(named, quick=quick or bool(problems))
    except InputError as error:
        problems += error.problems
    else:
        if not problems:
            problems += _start_up_problems(made)
        if not problems:
            return made
    raise InputError(dict.fromkeys(problems))


def _start_up_problems(made: Versions) -> list[Problem]:
    """A problem of the first run of which no row counts."""
    named = made.named
    study = named.study
    if not _may_end_early(made):
        return []
    for run in study.grid.runs:
        settings = named.settings(study.grid.values(run))
        times = changed(named.system, settings).simulation
        first = start_up(study.start_up, times.start_time, dict(_ramps(made, run)))
        try:
            check_start_up(study, first, times.stop_time)
        except InputError as error:
            return error.problems
    return []


def _may_end_early(made: Versions) -> bool:
    """False if a stated start-up was compared with the stop time of all runs, or no sea ramps."""
    if made.named.study.start_up is not None:
        return STOP_TIME in made.named.targets
    known = made.named.descriptions.values()
    return any(name.rpartition(".")[2] == RAMP for one in known for name in one.variables)


def _ramps(made: Versions, run: int) -> Iterator[tuple[str, float]]:
    """Ramps of the seas of a run [s] by component and variable."""
    for name, (number, component) in made.components(run).items():
        variables = made.named.descriptions[name].variables
        starts = {n: v.start for n, v in variables.items() if v.start is not None}
        own = made.of[name].builds[number].variables if name in made.of else None
        starts |= {v.name: v.start for v in own or () if v.name in starts}
        for variable in starts:
            if variable.rpartition(".")[2] == RAMP:
                given = component.start.get(variable, float(starts[variable]))
                yield f"{name}.{variable}", float(value_of(variables[variable], given))
