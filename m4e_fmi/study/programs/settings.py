"""Settings of the simulation of a program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

from m4e_fmi.cosim.system.simulation import time_of
from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.simulate.simulation import METHODS
from m4e_fmi.study.given.sections import Scalar


@dataclass(frozen=True)
class Settings:
    """Settings of the simulation of a program, as of `simulate`; times in s."""

    stop_time: float
    output_interval: float = 0.01
    tolerance: float = 1e-8
    method: str = "dop853"
    step_size: float | None = None


SETTINGS = tuple(one.name for one in fields(Settings))


def checked_settings(given: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Settings with times in seconds, each checked by itself; InputError with all wrong ones."""
    found, problems = dict[str, Scalar](), []
    for key, value in given.items():
        try:
            found[key] = _checked(key, value)
        except InputError as error:
            problems += error.problems
    InputError.raise_for(problems)
    return found


def _checked(key: str, value: Scalar) -> Scalar:
    if key not in SETTINGS:
        message = f"unknown setting {key!r} of the simulation of a program"
        raise InputError.single(message, suggestion(key, SETTINGS, "settings"))
    if key == "method":
        if value not in METHODS:
            remedy = suggestion(str(value), METHODS, "methods")
            raise InputError.single(f"there is no method {value!r}", remedy)
        return value
    if isinstance(value, str) and key != "tolerance":
        try:
            value = float(time_of(value))
        except ValueError:
            raise InputError.single(f"{key} {value!r} is not a valid duration") from None
    if isinstance(value, bool | str) or not 0.0 < value < math.inf:
        raise InputError.single(f"{key}: expected a number above 0, got {value!r}")
    return value
