"""Units: that of a derivative, exponents against the unit's name, variables without one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fmpy.model_description import BaseUnit, ModelVariable

from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.fmu_under_test import FmuUnderTest
from m4e_fmi.units import BASE_UNITS, parse_unit

_Units = dict[str, BaseUnit | None]
_SECOND, _RADIAN = BASE_UNITS.index("s"), BASE_UNITS.index("rad")
_ROUNDING = 1e-9
"""Relative; factors are written in decimals."""


def check_units(subject: FmuUnderTest) -> Iterator[Finding]:
    """Findings about units and their use."""
    definitions = {unit.name: unit.baseUnit for unit in subject.raw.unitDefinitions}
    yield from _names(definitions)
    for variable in subject.reals():
        state = variable.derivative
        if state is not None and state.type == "Real":
            yield from _of_derivative(variable, state, definitions)
    missing = [v.name for v in subject.reals() if not unit_of(v) and v.causality != "independent"]
    if missing:
        message = f"{len(missing)} Reals have no unit: {some(missing)}"
        yield Finding("units.missing", "note", message, 'give unit="1" to what has none')


def unit_of(variable: ModelVariable) -> str:
    """The variable's own unit, or that of its type; "" where there is none."""
    of_type = variable.declaredType.unit if variable.declaredType is not None else None
    return variable.unit or of_type or ""


def _exponents(base: BaseUnit) -> list[int]:
    return [int(getattr(base, name) or 0) for name in BASE_UNITS]


def _without_angle(exponents: list[int]) -> list[int]:
    """FMI leaves it open whether an angle has the unit 1 or rad."""
    return [e for k, e in enumerate(exponents) if k != _RADIAN]


def _names(definitions: _Units) -> Iterator[Finding]:
    for name, base in definitions.items():
        if base is None:
            continue
        try:
            known = parse_unit(name)
        except ValueError:
            continue  # a name may be any text
        powers = _exponents(base)
        same = _without_angle(powers) == _without_angle(list(known.exponents))
        factor = float(base.factor)
        if not same or abs(factor - known.factor) > _ROUNDING * abs(known.factor):
            given, wanted = _text(factor, powers), _text(known.factor, known.exponents)
            message = f"unit {name} is defined as {given}, its name says {wanted}"
            yield Finding("units.definition", "warning", message, "FMI 2.0.4, section 2.2.2")


def _text(factor: float, powers: Sequence[int]) -> str:
    bases = [f"{b}^{e}" for b, e in zip(BASE_UNITS, powers, strict=True) if e]
    return f"{factor:g} {' '.join(bases) or '1'}"


def _of_derivative(
    variable: ModelVariable, state: ModelVariable, definitions: _Units
) -> Iterator[Finding]:
    of, unit = unit_of(state), unit_of(variable)
    pair = f"{variable.name} is the derivative of {state.name}"
    if bool(of) != bool(unit):
        who = variable.name if of else state.name
        message = f"{pair}, but {who} has no unit"
        yield Finding(
            "units.derivative_missing", "warning", message, "give both a unit, or neither"
        )
        return
    base, rate = definitions.get(of), definitions.get(unit)
    if base is None or rate is None:
        return
    powers = _exponents(base)
    powers[_SECOND] -= 1
    same = _without_angle(powers) == _without_angle(_exponents(rate))
    factor = float(base.factor)
    if not same or abs(float(rate.factor) - factor) > _ROUNDING * abs(factor):
        message = f"{pair}, but their units are {unit} and {of}"
        yield Finding("units.derivative", "error", message, "the unit of a derivative is unit/s")
