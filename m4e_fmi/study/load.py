"""Studies from files, with all problems that can be told before anything is built."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.study.given.study import Study, read_study
from m4e_fmi.study.programs.names import named_program
from m4e_fmi.study.systems.checks import checked


def load_study(path: str | Path) -> Study:
    """The study in a YAML file; InputError with all problems found in it.

    If it has any, names and values are compared with the system or the model too.
    """
    study, problems = read_study(path)
    if problems or study is None:
        raise InputError(dict.fromkeys([*problems, *(_of_names(study) if study else ())]))
    return study


def _of_names(study: Study) -> list[Problem]:
    """Problems of the names of a study that has others: what is left of it does not show more."""
    left = replace(study, start_up=None)
    try:
        if study.is_program:
            named_program(
                replace(left, simulation={"stop_time": 1.0, **study.simulation}), tell=_silent
            )
        else:
            checked(left, load_system(study.source), quick=True)
    except InputError as error:
        return error.problems
    except RunError:  # the study itself tells it
        pass
    return []


def _silent(_: str) -> None:
    pass
