"""Variables against one another: names, aliases, limits, start values, declared derivatives."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator

from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.validation.description.units import unit_of
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.fmu_under_test import FmuUnderTest, limits


def check_variables(subject: FmuUnderTest) -> Iterator[Finding]:
    """Findings about start values, limits, aliases and derivatives of variables."""
    yield from _aliases(subject)
    for variable in subject.reals():
        yield from _limits(variable)
        yield from _derivative(variable)
    for rate in subject.rates:
        if rate.derivative is None:
            message = f"{rate.name} is listed among the derivatives, but is declared as none"
            basis = "FMI 2.0.4, section 2.2.8: needs the attribute `derivative`"
            yield Finding("derivatives.undeclared", "error", message, basis)


def check_names(names: Iterable[str]) -> Iterator[Finding]:
    """A finding if some `names` differ only in upper and lower case."""
    spellings: dict[str, list[str]] = defaultdict(list)
    for name in names:
        spellings[name.casefold()].append(name)
    alike = [list(dict.fromkeys(found)) for found in spellings.values()]
    alike = [" and ".join(found) for found in alike if len(found) > 1]
    if alike:
        message = f"names that differ only in upper and lower case: {some(alike)}"
        basis = "FMI 2.0.4, section 2.2.7, allows it, but some tools ignore case: rename them"
        yield Finding("variables.case", "warning", message, basis)


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
