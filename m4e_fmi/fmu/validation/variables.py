"""Variables against one another: aliases, limits, start values, derivatives, units.

Units: that of a derivative, exponents against the unit's name, variables without one.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence

from fmpy.model_description import BaseUnit, ModelVariable

from m4e_fmi.fmu.importer.elements import unit_of
from m4e_fmi.fmu.validation.findings import Finding, about
from m4e_fmi.fmu.validation.subject import FmuUnderTest, limits
from m4e_fmi.units import BASE_UNITS, parse_unit

_Units = dict[str, BaseUnit | None]
_SECOND, _RADIAN = BASE_UNITS.index("s"), BASE_UNITS.index("rad")
_ROUNDING = 1e-9
"""Relative; factors are written in decimals."""


def check_variables(subject: FmuUnderTest) -> Iterator[Finding]:
    """Findings about start values, limits, aliases and derivatives of variables."""
    yield from _aliases(subject)
    for variable in subject.reals:
        yield from _limits(variable)
        yield from _derivative(variable)
    for rate in subject.rates:
        if rate.derivative is None:
            message = f"{rate.name} is listed among the derivatives, but is declared as none"
            basis = "FMI 2.0.4, section 2.2.8: needs the attribute `derivative`"
            yield Finding("derivatives.undeclared", "error", message, basis)


def _settable(variable: ModelVariable) -> bool:
    return variable.causality in ("input", "parameter", "independent")


def _aliases(subject: FmuUnderTest) -> Iterator[Finding]:
    """Two variables with one value reference are one variable; some pairs cannot be."""
    sets: dict[tuple[str, int], list[ModelVariable]] = defaultdict(list)
    for variable in subject.raw.modelVariables:
        base = "Integer" if variable.type == "Enumeration" else variable.type
        sets[base, variable.valueReference].append(variable)
    basis = "FMI 2.0.4, section 2.2.7, alias variables"
    for (_, reference), aliases in sets.items():
        first, *others = aliases
        for other in others:
            pair = f"{first.name} and {other.name} share value reference {reference}"
            if _settable(first) and _settable(other):
                yield Finding("variables.alias", "error", f"{pair}, but each can be set", basis)
            elif (first.variability == "constant") != (other.variability == "constant"):
                yield Finding("variables.alias", "error", f"{pair}, but one is constant", basis)
            elif first.type == "Real" and unit_of(first) != unit_of(other):
                units = f"{unit_of(first) or 'none'} and {unit_of(other) or 'none'}"
                yield Finding("variables.alias", "error", f"{pair}, but have units {units}", basis)


def _limits(variable: ModelVariable) -> Iterator[Finding]:
    basis = "FMI 2.0.4, section 2.2.7: min ≤ start ≤ max"
    low, high = limits(variable)
    if low > high:
        message = f"{variable.name}: min {low:g} is above max {high:g}"
        yield Finding("variables.limits", "error", message, basis)
    elif variable.start is not None:
        value = float(variable.start)
        if not math.isfinite(value):
            message = f"{variable.name}: the start value is {value}"
            yield Finding("variables.start", "error", message, "give it a finite one")
        elif not low <= value <= high:
            message = f"{variable.name}: start {value:g} is not between {low:g} and {high:g}"
            yield Finding("variables.start", "error", message, basis)
    nominal = variable.nominal
    if nominal is not None and not 0 < float(nominal) < math.inf:
        message = f"{variable.name}: nominal is {nominal}"
        basis = "fmi2GetNominalsOfContinuousStates: nominal values are above 0"
        yield Finding("variables.nominal", "error", message, basis)


def _derivative(variable: ModelVariable) -> Iterator[Finding]:
    base = variable.derivative
    if base is None:
        return
    basis = "FMI 2.0.4, section 2.2.7, attribute `derivative`"
    pair = f"{variable.name} is declared as derivative of {base.name}"
    if base is variable:
        yield Finding("derivatives.itself", "error", pair, basis)
    elif base.type != "Real" or base.variability != "continuous":
        yield Finding("derivatives.kind", "error", f"{pair}, which is not continuous", basis)


def check_units(subject: FmuUnderTest) -> Iterator[Finding]:
    """Findings about units and their use."""
    definitions = {unit.name: unit.baseUnit for unit in subject.raw.unitDefinitions}
    yield from _unit_definitions(definitions)
    for variable in subject.reals:
        state = variable.derivative
        if state is not None and state.type == "Real":
            yield from _unit_of_derivative(variable, state, definitions)
    missing = [v.name for v in subject.readable if not unit_of(v)]
    message, remedy = "{count} Reals have no unit", 'give unit="1" to what has none'
    yield from about(missing, "units.missing", "note", message, remedy)


def _exponents(base: BaseUnit) -> list[int]:
    return [int(getattr(base, name) or 0) for name in BASE_UNITS]


def _without_angle(exponents: list[int]) -> list[int]:
    """FMI leaves it open whether an angle has the unit 1 or rad."""
    return [e for k, e in enumerate(exponents) if k != _RADIAN]


def _unit_definitions(definitions: _Units) -> Iterator[Finding]:
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


def _unit_of_derivative(
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
