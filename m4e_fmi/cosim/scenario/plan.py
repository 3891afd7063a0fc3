"""The plan of a scenario before the run: its actions checked against the system, and converted.

Names are those of variables that exist, values are in the units of the FMUs, times in ns.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace

from m4e_fmi.cosim.system.simulation import NS_PER_SECOND, nanoseconds
from m4e_fmi.cosim.system.start_values import Value, value_of
from m4e_fmi.cosim.system.system import Action, System
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.files.sections import Location
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.units import Quantity, parse_quantity

COMPONENT = "scenario"
"""The name under which actions are in the results."""
COMPARISONS: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
    ">": operator.gt,
    "<": operator.lt,
}
_CONDITION = re.compile(
    r"\s*(?P<name>[^<>=!\s]+)\s*(?P<sign>>=|<=|==|!=|>|<)\s*(?P<value>[^<>=!]+?)\s*$"
)


@dataclass(frozen=True)
class Condition:
    """A comparison of a variable with a value in its own unit; `text` is as the user wrote it."""

    port: Port
    compare: Callable[[float, float], bool]
    value: float
    text: str


@dataclass(frozen=True)
class Setting:
    """A variable and the value that it gets, in its own `unit`, within so many ns (0: at once)."""

    port: Port
    value: Value
    within: int = 0
    unit: str = ""

    def __str__(self) -> str:
        value = str(self.value)
        if isinstance(self.value, float):
            value = f"{self.value:.9g}" + (f" {self.unit}" if self.unit not in ("", "1") else "")
        within = f" within {self.within / NS_PER_SECOND:.9g} s" if self.within else ""
        return f"{self.port} = {value}{within}"

    def value_after(self, since: int, former: Value) -> Value:
        """The value a time `since` [ns] the beginning, when the variable had the `former` value."""
        if since >= self.within:
            return self.value
        return float(former) + (float(self.value) - float(former)) * (since / self.within)


@dataclass(frozen=True)
class SignalEffect:
    """Change of a link's signal, in its taker's unit: an offset, a value, or none (freeze).

    `kind` is that of the action.
    """

    link: Link
    kind: str
    amount: float


@dataclass(frozen=True)
class PlannedAction:
    """An action: the time `at` which it begins or its `condition`, its `duration`; its parts.

    Times are in ns.
    """

    name: str
    at: int | None
    condition: Condition | None
    duration: int | None
    settings: tuple[Setting, ...] = ()
    effects: tuple[SignalEffect, ...] = ()


@dataclass
class Planner:
    """Makes planned actions from the actions of a system; `problems` are the errors in them."""

    system: System
    descriptions: Mapping[str, Description]
    wiring: Wiring
    problems: list[Problem] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._variables = {name: d.variables for name, d in self.descriptions.items()}

    def actions(self) -> tuple[PlannedAction, ...]:
        """All actions that are right, in the order of the file."""
        if self.system.scenario and COMPONENT in self.descriptions:
            message = f"a component is called {COMPONENT!r}, the name of the scenario's variables"
            self._problem((), message, "rename the component")
        return tuple(self._action(name, action) for name, action in self.system.scenario.items())

    def _problem(self, keys: Location, message: str, remedy: str = "") -> None:
        self.problems.append(self.system.problem(("scenario", *keys), message, remedy))

    def _action(self, name: str, action: Action) -> PlannedAction:
        start = self.system.simulation.start_time
        if action.at is not None and action.at < start:
            message = f"{name!r} begins at {action.at:g} s, before the start time of {start:g} s"
            self._problem((name, "at"), message, f"give a time from {start:g} s on")
        kind = action.kind
        sets = kind in ("set", "ramp")
        settings = () if not sets else tuple(self._settings(name, action))
        effects = () if sets else tuple(self._effects(name, action))
        condition = self._condition(name, action.when) if action.when is not None else None
        at = None if action.at is None else nanoseconds(action.at)
        duration = None if action.duration is None else nanoseconds(action.duration)
        return PlannedAction(name, at, condition, duration, settings, effects)

    def _condition(self, name: str, text: str) -> Condition | None:
        at = (name, "when")
        written = _CONDITION.fullmatch(text)
        if not written or "." not in written["name"]:
            remedy = "write one comparison of a variable with a value, as 'buoy.z > 2 m' "
            remedy += f"({', '.join(COMPARISONS)})"
            self._problem(at, f"{text!r} is not a condition", remedy)
            return None
        sign, limit = written["sign"], written["value"]
        found = self._variable(at, written["name"])
        if found is None:
            return None
        port, variable = found
        given: object = limit
        if variable.type in ("String", "Binary"):
            message = f"{port} is of type {variable.type}, which a condition cannot compare"
            self._problem(at, message, "compare a number or a Boolean")
            return None
        if variable.type == "Boolean":
            given = {"true": True, "false": False}.get(limit.lower(), given)
        elif variable.type != REAL:
            with suppress(ValueError):
                given = int(limit)
        elif sign in ("==", "!="):
            message = f"{port} is a Real, which is hardly ever equal to a number"
            self._problem(at, message, "compare by <, <=, > or >=")
            return None
        else:
            with suppress(ValueError):
                given = float(limit)
        try:  # a condition may lie outside the range
            value = value_of(replace(variable, minimum=-math.inf, maximum=math.inf), given)
        except ValueError as error:
            self._problem(at, f"{limit!r} is no value of {port}", str(error))
            return None
        return Condition(port, COMPARISONS[sign], float(value), text.strip())

    def _variable(self, at: Location, name: str) -> tuple[Port, Variable] | None:
        port = Port.named(name)
        description = self.descriptions.get(port.component)
        if description is None:
            remedy = suggestion(port.component, self.descriptions, "components")
            self._problem(at, f"{name!r}: there is no component {port.component!r}", remedy)
        elif not port.variable:
            remedy = f"name one of its variables: {port.component}.<variable>"
            self._problem(at, f"{name!r} is a component, not a signal", remedy)
        elif port.variable not in description.variables:
            remedy = suggestion(port.variable, description.variables, "variables")
            self._problem(at, f"{port.component!r} has no variable {port.variable!r}", remedy)
        else:
            return port, description.variables[port.variable]
        return None

    def _settings(self, name: str, action: Action) -> Iterator[Setting]:
        """Values that are set in FMUs."""
        within = nanoseconds(action.within or 0.0)
        for variable_name, value in getattr(action, action.kind).items():
            at = (name, action.kind, variable_name)
            found = self._variable(at, variable_name)
            if found is None or not self._is_settable(at, *found, ramp=within > 0):
                continue
            port, variable = found
            try:
                yield Setting(port, value_of(variable, value), within, variable.unit)
            except ValueError as error:
                told = repr(value) if isinstance(value, str) else str(value)
                self._problem(at, f"value {told} of {port} is wrong", str(error))

    def _is_settable(self, at: Location, port: Port, variable: Variable, *, ramp: bool) -> bool:
        why, remedy = why_fixed(variable), "set an unconnected input or a tunable parameter"
        sources = [link.source for link in self.wiring.links if link.target == port]
        if sources:
            why = f"is connected to {sources[-1]}"
            remedy = "'replace' gives its taker another value"
        elif not why and ramp and variable.type != REAL:
            why, remedy = f"is of type {variable.type}", "a ramp needs a Real; use 'set'"
        if why:
            self._problem(at, f"{port} cannot be set during a run: it {why}", remedy)
        return not why

    def _effects(self, name: str, action: Action) -> Iterator[SignalEffect]:
        """Changes of signals, one for each taker of each."""
        given = getattr(action, action.kind)
        amounts = given if isinstance(given, Mapping) else dict.fromkeys(given, 0.0)
        for signal, amount in amounts.items():
            at = (name, action.kind, signal)
            links = self._takers(at, signal)
            if not links:
                continue
            for k, link in enumerate(links):
                variables = link.variables(self._variables)
                named = variables[signal != str(link.source)]
                first = k == 0 or signal == str(link.source)
                share = amount if first else 0.0  # of a sum: the first gives it all
                try:
                    value = _converted(action.kind, share, link, named, variables[1])
                    yield SignalEffect(link, action.kind, value)
                except ValueError as error:
                    self._problem(at, f"{str(amount)!r} for {signal} is wrong", str(error))
                    break

    def _takers(self, at: Location, signal: str) -> list[Link]:
        """The links that a signal names: one by its input, all by their output."""
        found = self._variable(at, signal)
        if found is None:
            return []
        port, variable = found
        links = [link for link in self.wiring.links if port in link.ends]
        if not links:
            why, remedy = "nobody takes it", "name a connected input or output"
            if why_fixed(variable) == "":
                why, remedy = "it is not connected", "use 'set' or 'ramp'"
            self._problem(at, f"{signal} carries no signal: {why}", remedy)
        elif not all(v.type == REAL for k in links for v in k.variables(self._variables)):
            message = f"{signal} is of type {variable.type}"
            self._problem(at, message, "actions on signals are for Reals")
            return []
        return links


def _converted(kind: str, amount: object, link: Link, named: Variable, taker: Variable) -> float:
    """The amount of an action on the signal that a `link` carries, in the unit of its `taker`.

    A number is in the unit of the variable `named`, source or taker; a text has a unit of its own.
    Of an offset it is a difference of two values. ValueError with a remedy.
    """
    number, unit = amount, named.dimension
    if isinstance(amount, str):
        given = parse_quantity(amount)
        number = given.value
        if unit is not None and kind == "offset":
            number = Quantity(given.value, given.unit).in_unit(unit)
        elif unit is not None:
            number = given.in_unit(unit, named.offset)
    assert isinstance(number, int | float)
    if not math.isfinite(number):
        raise ValueError("give a finite number")
    factor, offset = (1.0, 0.0) if named is taker else (link.factor, link.offset)
    value = factor * number
    if kind != "replace":
        return value
    value = value + offset if offset else value
    if not taker.minimum <= value <= taker.maximum:
        limits = f"{taker.minimum:g} to {taker.maximum:g} {taker.unit}"
        raise ValueError(f"{link.target} takes {limits}")
    return value


def why_fixed(variable: Variable) -> str:
    """Why an unconnected variable cannot be set during a run; empty if it can."""
    if variable.causality == "input" or variable.variability == "tunable":
        return "" if variable.causality in ("input", "parameter") else "is calculated"
    if variable.causality == "parameter":
        return f"is a {variable.variability} parameter, to be given under start"
    return f"is of causality {variable.causality}"


def scenario_problems(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> list[Problem]:
    """All problems of a system's scenario."""
    planner = Planner(system, descriptions, wiring)
    planner.actions()
    return planner.problems
