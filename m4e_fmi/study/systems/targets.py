"""Meaning of the varied names of a study: settings, keys of components, start values."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from m4e_fmi.cosim.system.component import Kind, kind_of
from m4e_fmi.cosim.system.simulation import CHECKPOINTS, SETTINGS
from m4e_fmi.cosim.system.start_values import is_settable
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.files.document import Document, Location
from m4e_fmi.files.sections import keys_at, types_at
from m4e_fmi.fmu import Description

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

    def __str__(self) -> str:
        unit = f" [{self.unit}]" if self.unit not in ("", "1") else ""
        return f"the start value {self.variable}{unit}"


Data = TypeVar("Data")
Target = SettingTarget | KeyTarget | StartTarget
Targets = Mapping[str, Target]


def targets_of(
    names: Iterable[tuple[str, Location]],
    system: System,
    descriptions: Mapping[str, Description],
    document: Document,
    problems: list[Problem],
) -> dict[str, Target]:
    """Meaning of each of the dotted names that have one; adds the others to `problems`.

    A key that the component's section has comes before a start value of that name, and that before
    a key which the section could have. `document` is the study's, for the places of `names`.
    """
    found: dict[str, Target] = {}
    components = {component.name: component for component in system.components}
    for name, location in names:
        first, _, rest = name.partition(".")
        if first == SIMULATION:
            known = [key for key in SETTINGS if key not in CHECKPOINTS]
            if rest in known:
                found[name] = SettingTarget(rest)
            else:
                message = f"{name}: there is no setting {rest!r}"
                remedy = suggestion(rest, known, "settings")
                problems.append(document.problem(location, message, remedy))
            continue
        if first not in components:
            message = f"{name}: there is no component {first!r}"
            remedy = suggestion(first, [*components, SIMULATION], "components")
            problems.append(document.problem(location, message, remedy))
            continue
        target = _of_component(system, first, rest, descriptions.get(first))
        if target is None:
            remedy = suggestion(rest, _known(system, first, descriptions.get(first)), "names")
            message = f"{name}: {first} has no key and no start value {rest!r}"
            problems.append(document.problem(location, message, remedy))
        else:
            found[name] = target
    return found


def _of_component(
    system: System, component: str, rest: str, description: Description | None
) -> Target | None:
    """Meaning of `rest` for a component; None if it has none."""
    keys = location_of(rest)
    variables = description.variables if description else {}
    if rest.startswith("start.") and rest.removeprefix("start.") in variables:
        rest, keys = rest.removeprefix("start."), ()
    data = system.document.data["components"][component] if system.document else {}
    if keys and is_there(data, keys) and keys[0] not in FIXED:
        return KeyTarget(component, keys)
    if rest in variables and is_settable(variables[rest]):
        variable = variables[rest]
        is_real = variable.type == "Real"
        return StartTarget(component, rest, variable.unit, variable.description, is_real)
    if keys and _could_be(system, component, keys):
        return KeyTarget(component, keys)
    return None


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


def _could_be(system: System, component: str, keys: Location) -> bool:
    """True of a key that the component's kind knows, though the file leaves it out."""
    (one,) = (c for c in system.components if c.name == component)
    if not isinstance(one.source, Kind) or system.document is None:
        return False
    config = kind_of(one.source.name).config
    *above, last = keys
    return str(last) in keys_at(config, tuple(above)) and bool(types_at(config, keys))


def _known(system: System, component: str, description: Description | None) -> list[str]:
    """Names that could be meant."""
    variables = description.variables if description else {}
    found = [name for name, variable in variables.items() if is_settable(variable)]
    if system.document is not None:
        leaves = _leaves(system.document.data["components"][component])
        found += [name for name in leaves if location_of(name)[0] not in FIXED]
    return list(dict.fromkeys(found))


def _leaves(data: object, prefix: str = "") -> list[str]:
    """Dotted names of all values in nested data."""
    if isinstance(data, dict):
        return [name for key, value in data.items() for name in _leaves(value, f"{prefix}{key}.")]
    if isinstance(data, list):
        here = prefix.removesuffix(".")
        return [
            name for k, value in enumerate(data) for name in _leaves(value, f"{here}[{k + 1}].")
        ]
    return [prefix.removesuffix(".")]


def with_values(data: Data, values: Mapping[Location, object]) -> Data:
    """A copy of nested data with other values at some locations; sections that lack are made.

    ValueError for a location that leads through a value.
    """
    result = copy.deepcopy(data)
    for location, value in values.items():
        _set(result, location, location, value)
    return result


def _set(data: object, rest: Location, whole: Location, value: object) -> None:
    """Set the value at the location `rest` of nested data, which is the end of the `whole`."""
    first, *further = rest
    if isinstance(data, dict):
        if further:
            _set(data.setdefault(first, {}), tuple(further), whole, value)
        else:
            data[first] = value
    elif isinstance(data, list) and isinstance(first, int) and first < len(data):
        if further:
            _set(data[first], tuple(further), whole, value)
        else:
            data[first] = value
    else:
        raise ValueError(f"{'.'.join(map(str, whole))} leads through a value")
