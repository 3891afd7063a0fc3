"""Start values, checked and converted to the FMUs' own types and units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from numbers import Integral, Real

import numpy as np

from m4e_fmi.cosim.system.component import Component, ModelFile
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import range_of_type
from m4e_fmi.joints import QUATERNION
from m4e_fmi.joints.joint_type import angles_of_attitudes, no_attitudes, with_quaternions
from m4e_fmi.units import Quantity, parse_quantity, parse_unit

Value = float | int | bool | str

_TYPES: dict[str, type | tuple[type, ...]] = {
    "Real": (float, int),
    "Integer": int,
    "Enumeration": int,
    "Boolean": bool,
    "String": str,
}


def start_values(component: Component, description: Description) -> dict[str, Value]:
    """The values to set in the component's FMU before it is initialised, by variable.

    A Real given with a unit (a Quantity, or a text as ``"5 mm"``) is converted to that of the FMU;
    an item of an enumeration given by name becomes its number. Roll, pitch and yaw of a free
    attitude of ours, as ``body.arm.phi``, become its quaternion. ValueError with a remedy.
    """
    variables, angles = description.variables, _angles(component, description)
    given = {n: value_of((variables | angles)[n], v) for n, v in component.start.items()}
    if not angles:
        return given
    parts = [f"{name.rpartition('.')[0]}.{part}" for name in angles for part in QUATERNION]
    starts = {name: float(variables[name].start or 0.0) for name in parts}
    turning = {*angles, *starts}
    turns = {name: float(value) for name, value in given.items() if name in turning}
    return {n: v for n, v in given.items() if n not in turns} | with_quaternions(turns, starts)


def _angles(component: Component, description: Description) -> dict[str, Variable]:
    """Start values that are angles of free attitudes, as variables [rad]."""
    if not description.is_own:  # others may mean other angles by these names
        return {}
    variables, radian = description.variables, parse_unit("rad")
    settable = [name for name, variable in variables.items() if is_settable(variable)]
    return {
        name: replace(
            variables[f"{name.rpartition('.')[0]}.{QUATERNION[0]}"],
            name=name,
            unit="rad",
            dimension=radian,
        )
        for name in angles_of_attitudes(component.start, settable)
    }


def start_problems(system: System, descriptions: Mapping[str, Description]) -> Iterable[Problem]:
    """All problems of the start values of a system."""
    for component in system.components:
        description = descriptions[component.name]
        found = list(single_problems(system, component, description))
        yield from found or _problems_of_all(system, component, description)


def single_problems(
    system: System, component: Component, description: Description
) -> Iterator[Problem]:
    """Problems of single start values."""
    variables, angles = description.variables, _angles(component, description)
    for name, given in component.start.items():
        at = ("components", component.name, "start", name)
        if name not in variables and name not in angles:
            settable = [n for n, v in variables.items() if is_settable(v)]
            remedy = suggestion(name, settable, "start values")
            yield system.problem(at, f"{component.name!r} has no variable {name!r}", remedy)
            continue
        variable = angles.get(name) or variables[name]
        if not is_settable(variable):
            remedy = "parameters, inputs and initial states take start values"
            message = f"{component.name}.{name} ({variable.causality}) takes no start value"
            yield system.problem(at, message, remedy)
            continue
        try:
            value_of(variable, given)
        except ValueError as error:
            told = repr(given) if isinstance(given, str) else str(given)
            message = f"start value {told} of {component.name}.{name} is wrong"
            yield system.problem(at, message, str(error))


def _problems_of_all(
    system: System, component: Component, description: Description
) -> Iterator[Problem]:
    """Problems of start values together, each of which is right."""
    from m4e_fmi.model import load_model

    at = "components", component.name, "start"
    try:
        values = start_values(component, description)
    except ValueError as error:
        name = next(iter(_angles(component, description)))
        message = f"an attitude of {component.name} is given twice: {error}"
        yield system.problem((*at, name), message)
        return
    numbers = {
        name: float(value)
        for name, value in values.items()
        if description.variables[name].type == "Real"
    }
    if description.is_own:
        parts = [n for n in description.variables if n.rpartition(".")[2] in QUATERNION]
        starts = {name: float(description.variables[name].start or 0.0) for name in parts}
        for owner in no_attitudes(starts | numbers):
            message = f"{component.name}.{owner}.e0 to e3 are all 0, which is no attitude"
            name = next((n for n in component.start if n.startswith(f"{owner}.e")), f"{owner}.e0")
            remedy = f"give {owner}.phi, {owner}.theta, {owner}.psi"
            yield system.problem((*at, name), message, remedy)
    if isinstance(component.source, ModelFile) and numbers:
        yield from load_model(component.source.path).problems_with(numbers)


def is_settable(variable: Variable) -> bool:
    """True if FMI allows setting a start value."""
    return variable.variability != "constant" and (
        variable.causality == "input" or variable.initial in ("exact", "approx")
    )


def value_of(variable: Variable, start: object) -> Value:
    """A start value in the variable's type and unit; ValueError with a remedy if it does not fit.

    Numbers may be of any library.
    """
    given = _plain(start)
    if variable.type == "Binary":
        raise ValueError("values of type Binary are not set: it keeps the FMU's own")
    if variable.type == "Real" and isinstance(given, str):
        given = parse_quantity(given)
    if isinstance(given, Quantity):
        given = _number(variable, given)
    if isinstance(given, float) and not math.isfinite(given) and variable.type != "String":
        raise ValueError("give a finite number")
    if variable.type == "Enumeration" and isinstance(given, str):
        if given not in variable.items:
            raise ValueError(suggestion(given, variable.items, "items") or "give its number")
        return variable.items[given]
    if not isinstance(given, _TYPES[variable.type]) or (
        isinstance(given, bool) and variable.type != "Boolean"
    ):
        remedy = f", to be quoted: '\"{given}\"'" if variable.type == "String" else ""
        raise ValueError(f"it is of type {variable.type}{remedy}")
    assert isinstance(given, float | int | str)
    _check_range(variable, given)
    _check_limits(variable, given)
    return given


def _plain(given: object) -> object:
    """A number or a truth value of any library as Python's own; anything else as it is."""
    if isinstance(given, bool | np.bool_):
        return bool(given)
    if isinstance(given, Integral):
        return int(given)
    if not isinstance(given, Real):
        return given
    try:
        return float(given)
    except OverflowError:
        return math.inf


def _check_range(variable: Variable, given: Value) -> None:
    """ValueError for a value that the type cannot hold."""
    if variable.type == "Integer" and isinstance(given, int):
        low, high = range_of_type(variable)
        if not low <= given <= high:
            raise ValueError(f"it is of type {variable.fmi_type}: {low} to {high}")


def _check_limits(variable: Variable, given: Value) -> None:
    """ValueError for a number outside the range that the FMU declares."""
    low, high = variable.minimum, variable.maximum
    if isinstance(given, str | bool) or low <= given <= high:
        return
    unit = "" if variable.unit in ("", "1") else f" {variable.unit}"
    limits = f"{low:g} to {high:g}{unit}"
    if math.isinf(high):
        limits = f"{low:g}{unit} or more"
    elif math.isinf(low):
        limits = f"{high:g}{unit} or less"
    told = f" ({variable.description})" if variable.description else ""
    raise ValueError(f"the FMU's range is {limits}{told}")


def _number(variable: Variable, given: Quantity) -> float:
    if variable.type != "Real":
        raise ValueError(f"it is of type {variable.type}, which has no unit")
    if variable.dimension is None and given.unit.text != "1":
        raise ValueError("its FMU gives it no unit that is known: write the number alone")
    if variable.dimension is None:
        return given.value
    return given.in_unit(variable.dimension, variable.offset)
