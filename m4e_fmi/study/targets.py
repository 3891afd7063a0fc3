"""Meaning of the varied names of a study: settings, keys of components, start values."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from m4e_fmi.cosim.system.component import Kind, kind_of
from m4e_fmi.cosim.system.start_values import is_settable
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.files.sections import keys_at, types_at
from m4e_fmi.fmu import Description
from m4e_fmi.study.given.sections import Scalar

SIMULATION = "simulation"
FIXED = ("kind", "model", "fmu", "start")
"""Keys of a component that are not varied: what it is, and start values, which have own names."""
_INDEX = re.compile(r"(.+)\[(\d+)\]")


@dataclass(frozen=True)
class SettingTarget:
    """A setting of the simulation."""

    key: str

    def __str__(self) -> str:
        return "a setting of the simulation"


@dataclass(frozen=True)
class KeyTarget:
    """A key of the section of a component in the system's file, or of a model's file ("")."""

    component: str
    keys: Location

    def __str__(self) -> str:
        where = f"the section of {self.component}" if self.component else "the model's file"
        return f"the key {dotted(self.keys)} of {where}"


@dataclass(frozen=True)
class StartTarget:
    """A start value of a component's FMU, or of a program ("")."""

    component: str
    variable: str
    unit: str = ""
    text: str = ""
    is_real: bool = True

    @property
    def whole(self) -> str:
        """The name of the variable with its component."""
        return f"{self.component}.{self.variable}" if self.component else self.variable

    def __str__(self) -> str:
        unit = f" [{self.unit}]" if self.unit not in ("", "1") else ""
        return f"the start value {self.variable}{unit}"


Data = TypeVar("Data")
Made = TypeVar("Made")
Combination = tuple[Scalar, ...]
"""Values of the varied keys of one component, or of a model's file."""
Target = SettingTarget | KeyTarget | StartTarget
Targets = Mapping[str, Target]


def system_target(system: System, descriptions: Mapping[str, Description], name: str) -> Target:
    """Meaning of the dotted `name` in a system; InputError if it has none.

    A key that the component's section has comes before a start value of that name, and that before
    a key which the section could have.
    """
    component, _, rest = name.partition(".")
    sections = {c.name: c for c in system.components}
    if component not in sections:
        remedy = suggestion(component, [*sections, SIMULATION], "components")
        raise InputError.single(f"{name}: there is no component {component!r}", remedy)
    found = descriptions.get(component)
    keys, variables = location_of(rest), found.variables if found else {}
    if rest.startswith("start.") and rest.removeprefix("start.") in variables:
        rest, keys = rest.removeprefix("start."), ()
    data = system.document.data["components"][component] if system.document else {}
    if keys and is_there(data, keys) and keys[0] not in FIXED:
        return KeyTarget(component, keys)
    settable = {n: v for n, v in variables.items() if is_settable(v)}
    if rest in settable:
        one = settable[rest]
        return StartTarget(component, rest, one.unit, one.description, one.type == "Real")
    source = sections[component].source
    if keys and system.document and isinstance(source, Kind):  # a key that the file leaves out
        config = kind_of(source.name).config
        if str(keys[-1]) in keys_at(config, keys[:-1]) and types_at(config, keys):
            return KeyTarget(component, keys)
    known = [*settable, *(key for key in data if key not in FIXED)]
    remedy = suggestion(rest, dict.fromkeys(known), "names")
    message = f"{name}: {component} has no key and no start value {rest!r}"
    raise InputError.single(message, remedy)


def made_for(
    combinations: Iterable[Combination],
    names: Sequence[str],
    make: Callable[[Combination], Made],
    located: Callable[[Problem], Problem] = lambda problem: problem,
) -> dict[Combination, Made]:
    """Results of `make` for each of the `combinations` of values of varied keys by `names`.

    InputError with all problems, `located`, each by the first values that have it.
    """
    found, problems = dict[Combination, Made](), dict[Problem, Problem]()
    for one in dict.fromkeys(combinations):
        try:
            found[one] = make(one)
        except InputError as error:
            told = ", ".join(f"{name} = {value}" for name, value in zip(names, one, strict=True))
            for problem in map(located, error.problems):
                message = f"{problem.message} (with {told})" if told else problem.message
                problems.setdefault(problem, replace(problem, message=message))
    InputError.raise_for(problems.values())
    return found


def location_of(text: str) -> Location:
    """Keys and indices (from 0) of a dotted text; ``waves[2]`` is the second entry of a list."""
    keys: list[str | int] = []
    for part in text.split("."):
        indexed = _INDEX.fullmatch(part)
        keys += [indexed[1], int(indexed[2]) - 1] if indexed else [part]
    return tuple(keys)


def dotted(keys: Location) -> str:
    """The text of keys and indices (from 0), as names of studies have them: ``waves[2].seed``."""
    return "".join(f"[{k + 1}]" if isinstance(k, int) else f".{k}" for k in keys).removeprefix(".")


def is_there(data: object, keys: Location) -> bool:
    """True if nested data have a value, not a section, at `keys`."""
    for key in keys:
        known = range(len(data)) if isinstance(data, list) else data
        if not isinstance(known, (dict, range)) or key not in known:
            return False
        data = data[key]  # pyrefly: ignore[bad-index]
    return not isinstance(data, (dict, list))


def with_values(data: Data, values: Mapping[Location, object]) -> Data:
    """A copy of nested data with other values at some locations; sections that lack are made.

    InputError for a location that leads through a value.
    """
    result = copy.deepcopy(data)
    for location, value in values.items():
        at: Any = result
        try:
            for key in location[:-1]:
                at = at.setdefault(key, {}) if isinstance(at, dict) else at[key]
            at[location[-1]] = value
        except (IndexError, TypeError):
            raise InputError.single(f"{dotted(location)} leads through a value") from None
    return result
