"""A program with start values of the user's, checked."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from m4e_fmi.errors import InputError, Problem, UnknownNameError, unknown_names
from m4e_fmi.joints import ATTITUDE
from m4e_fmi.joints.joint_type import angles_of_attitudes, no_attitudes, with_quaternions
from m4e_fmi.model import Model
from m4e_fmi.model.checks import without_value
from m4e_fmi.multibody.declaration import is_unset
from m4e_fmi.program import Program
from m4e_fmi.units import number_in


def started(
    program: Program, values: Mapping[str, float | str], model: Model | None = None
) -> Program:
    """`program` with other start values: numbers, or texts with a unit, as ``"5 mm"``.

    Beside parameters, inputs and states these may be the roll, pitch and yaw of a free attitude, as
    ``body.hull.phi``; of those not given the present ones stay.

    InputError names what is unknown, not finite, of another dimension, outside its limits, or
    without a value though it needs one; of a `model`, also what becomes wrong by these values, as
    an axis without length, and where in its file that is.
    """
    variables = {v.name: v for v in (*program.parameters, *program.inputs, *program.states)}
    states = {v.name: v.start for v in program.states}
    units = {name: v.unit for name, v in variables.items()}
    units |= dict.fromkeys(angles_of_attitudes(values, states), "rad")
    complaint = f"{program.name} has no parameter, input or state"
    if unknown := unknown_names(values, units, complaint, "start values"):
        raise UnknownNameError(unknown)
    numbers = _numbers(units, values)
    try:
        result = program.with_start(with_quaternions(numbers, states))
    except ValueError as error:
        raise InputError.single(f"an attitude is given twice: {error}") from error
    lacking = model.lacking if model else {}
    wrong = model.problems_with(numbers) if model else []
    wrong = wrong or [
        Problem(f"{v.name} = {v.start:g} is outside its range from {v.minimum:g} to {v.maximum:g}")
        for v in (*result.parameters, *result.inputs, *result.states)
        if not v.minimum <= v.start <= v.maximum
    ]
    wrong += [
        lacking.get(v.name) or Problem(f"{program.name}: {message}", remedy)
        for v in result.parameters
        if is_unset(v)
        for message, remedy in [without_value(v.name)]
    ]
    for owner in no_attitudes({v.name: v.start for v in result.states}):
        instead = ", ".join(f"{owner}.{angle}" for angle in ATTITUDE)
        message = f"{owner}.e0 to e3 are all 0, which is no attitude"
        wrong.append(Problem(message, f"give {instead} instead"))
    InputError.raise_for(wrong)
    return result


def _numbers(units: Mapping[str, str], values: Mapping[str, float | str]) -> dict[str, float]:
    """The values in the units of their variables; InputError with all that are wrong."""
    numbers: dict[str, float] = {}
    wrong = []
    for name, value in values.items():
        try:
            numbers[name] = number_in(units[name], value)
        except ValueError as error:
            wrong.append(Problem(f"start value {value!r} of {name} is wrong", str(error)))
    InputError.raise_for(wrong)
    bad = [f"{name} = {value}" for name, value in numbers.items() if not np.isfinite(value)]
    if bad:
        raise InputError.single(f"start values must be finite numbers: {', '.join(bad)}")
    return numbers
