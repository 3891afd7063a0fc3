"""Settings of the simulation of a program: those of all runs, and varied ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from m4e_fmi.cosim.system.simulation import time_of
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.files.limits import beyond_limits
from m4e_fmi.simulate.simulation import METHODS
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.systems.targets import SIMULATION


@dataclass(frozen=True)
class Settings:
    """Settings of the simulation of a program, as of `simulate`; times in s."""

    stop_time: float
    output_interval: float = 0.01
    tolerance: float = 1e-8
    method: str = "dop853"
    step_size: float | None = None


SETTINGS = tuple(one.name for one in fields(Settings))
TIMES = ("stop_time", "output_interval", "step_size")


def setting(key: str, value: Scalar) -> Scalar:
    """A setting; a time as a text in seconds."""
    return float(time_of(value)) if key in TIMES and isinstance(value, str) else value


def fixed_settings(study: Study, problems: list[Problem]) -> dict[str, object]:
    """The settings of all runs; adds to `problems`."""
    at = ("simulation",)
    varied = {t for axis in study.grid.axes for v in axis.varied for t in v.targets}
    found = dict[str, object]()
    for key, value in study.simulation.items():
        if key not in SETTINGS:
            message = f"unknown setting {key!r} of the simulation of a program"
            remedy = suggestion(key, SETTINGS, "settings")
            problems.append(study.document.problem((*at, key), message, remedy))
            continue
        try:
            found[key] = setting(key, value)
        except ValueError:
            message = f"{key} {value!r} is not a valid duration"
            problems.append(study.document.problem((*at, key), message))
    if "stop_time" not in found and f"{SIMULATION}.stop_time" not in varied:
        remedy = "write simulation: {stop_time: 10}"
        problems.append(study.document.problem(at, "the study has no stop_time", remedy))
        return found
    for key, value in found.items():
        if fault := _fault(key, value):
            problems.append(study.document.problem((*at, key), *fault))
    duration = found.get("stop_time")
    if isinstance(duration, int | float) and not _fault("stop_time", duration):
        problems += study.start_up_problems(duration)
    return found


def _fault(key: str, value: object) -> tuple[str, str] | None:
    """Message and remedy of a value that the setting `key` cannot have; None if it can."""
    if key == "method":
        if value in METHODS:
            return None
        return f"there is no method {value!r}", suggestion(str(value), METHODS, "methods")
    if isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf:
        beyond = beyond_limits(value) if key == "stop_time" else ()
        return next((one[1:] for one in beyond), None)
    return f"{key}: expected a number above 0, got {value!r}", ""


def varied_problems(
    study: Study, key: str, values: Sequence[Scalar], at: Location
) -> Iterator[Problem]:
    """Problems of the `values` of a varied setting, each by itself; `at` is their place."""
    for value in dict.fromkeys(values):
        try:
            fault = _fault(key, setting(key, value))
        except ValueError:
            fault = f"{key} {value!r} is not a valid duration", ""
        if fault:
            yield study.document.problem(at, *fault)


def count_problems(
    study: Study, fixed: Mapping[str, object], varied: Mapping[str, np.ndarray]
) -> Iterator[Problem]:
    """Problems of the numbers of rows and steps, by the extremes of `varied` (n_points,) [SI].

    `fixed` settings are those of all runs; those of neither have their defaults.
    """
    given = {**Settings(stop_time=0.0).__dict__, **fixed}
    stop, interval, step = (
        pick(varied[key]) if key in varied else given[key]
        for key, pick in (("stop_time", max), ("output_interval", min), ("step_size", min))
    )
    places = {t: v.location for axis in study.grid.axes for v in axis.varied for t in v.targets}
    for key, *told in beyond_limits(stop, output_interval=interval, step_size=step):  # pyrefly: ignore[bad-argument-type]
        at = places.get(f"{SIMULATION}.{key}", ("simulation", key))
        yield study.document.problem(at, *told)
