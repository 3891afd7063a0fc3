"""The arrays of FMI 3.0: which scalars of a description are the elements of one variable.

Vectors are the components of one quantity of a body, point or joint: `body.buoy.x` and
`body.buoy.z` are `body.buoy.position`, `body.buoy.e0` to `e3` are `body.buoy.quaternion`. What has
indices is an array of its own: `added_mass[1,1]`, `added_mass[1,2]`, ... are the matrix
`added_mass`, row by row.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from m4e_fmi.fmu.export.description import FmuVariable, ModelDescription
from m4e_fmi.joints import ATTITUDE, QUATERNION, TURNING
from m4e_fmi.program import TIME

_MOTION = {"": "position", "v": "velocity", "a": "acceleration"}
"""Text before the axis in the last part of a name → the vector's name."""

IN_SPACE: Mapping[str, tuple[str, ...]] = {
    "quaternion": QUATERNION,
    "attitude": ATTITUDE,
    "angular_velocity": TURNING,
    "angular_acceleration": ("alpha_x", "alpha", "alpha_z"),
    "moment": ("moment_x", "moment", "moment_z"),
    "reaction_moment": ("reaction_moment_x", "reaction_moment", "reaction_moment_z"),
}
"""Name of a vector that exists in space only → last parts of the names of all its components."""

KIND_NUMBERS = {"constant": 1, "fixed": 2, "tunable": 3, "dependent": 5}
"""Kinds of dependencies as fmi3DependencyKind has them."""
LIMITS = ("minimum", "maximum", "nominal")

_TIME = FmuVariable(TIME, "s", "Simulation time", causality="independent")


@dataclass(frozen=True)
class Grouped:
    """A variable of an FMU: the scalars that are its elements, row by row; shape () for one."""

    name: str
    shape: tuple[int, ...]
    members: tuple[FmuVariable, ...]

    @property
    def first(self) -> FmuVariable:
        """The member that says what all agree in."""
        return self.members[0]

    @property
    def elements(self) -> tuple[str, ...]:
        """Names of the elements: ``a[1,1]``, ``a[1,2]``, ...; the name, if it is one."""
        if not self.shape:
            return (self.name,)
        indices = product(*(range(1, n + 1) for n in self.shape))
        return tuple(f"{self.name}[{','.join(map(str, index))}]" for index in indices)

    @property
    def unit(self) -> str | None:
        """The unit of all elements; None where they differ."""
        return self.first.unit if len({m.unit for m in self.members}) == 1 else None

    @property
    def description(self) -> str:
        """The different descriptions of the elements, and their units where they differ."""
        texts = _summed(list(dict.fromkeys(m.description for m in self.members)))
        if self.unit is None:
            texts.append(f"units of the elements: {', '.join(m.unit for m in self.members)}")
        return "; ".join(texts)


Place = tuple[int, int]
"""Where a scalar is: value reference of its variable, and element, counting from 1."""


def places(variables: Sequence[Grouped]) -> dict[str, Place]:
    """Name of each scalar → its place. Value references count the variables from 0."""
    return {
        member.name: (reference, element)
        for reference, variable in enumerate(variables)
        for element, member in enumerate(variable.members, start=1)
    }


def grouped(description: ModelDescription, fmi: str) -> tuple[Grouped, ...]:
    """Variables of a description in version `fmi` of the standard: scalars in "2".

    In "3" time, then all of the description's, each at the place of its first. Scalars become
    elements if they agree in type, causality, variability, display unit, limits and in whether they
    have a start value; vectors in their unit, too. A variable and what it is the derivative of have
    equal dimensions: where elements are derivatives, they are those of the elements of another
    array, and no scalar is the derivative of an element.
    """
    if fmi == "2":
        return tuple(Grouped(v.name, (), (v,)) for v in description.variables)
    variables = {v.name: v for v in description.variables}
    found = {
        name: Grouped(name, shape, tuple(variables[m] for m in members))
        for name, (shape, members) in _candidates(list(variables)).items()
        if name not in variables or name in members
    }
    found = {name: group for name, group in found.items() if _uniform(group)}
    while unfit := _unfit(found, description.variables):
        for name in unfit:
            del found[name]
    group_of = _group_of(found)
    result = {TIME: Grouped(TIME, (), (_TIME,))}
    for v in description.variables:
        group = group_of.get(v.name, Grouped(v.name, (), (v,)))
        result.setdefault(group.name, group)
    return tuple(result.values())


def dependencies(variable: FmuVariable, *, initial: bool) -> list[tuple[str, str]] | None:
    """Dependencies of a scalar and their kinds, "" if it does not say; at the start, or later.

    None of a scalar that may depend on all.
    """
    names, kinds = variable.dependencies, variable.kinds
    if initial:
        names, kinds = variable.initial_dependencies, variable.initial_kinds
    return None if names is None else list(zip(names, kinds or [""] * len(names), strict=True))


def layout_files(description: ModelDescription, variables: Sequence[Grouped]) -> dict[str, bytes]:
    """Name in the archive → content: which scalars a value reference of FMI 3.0 stands for.

    All are lines of numbers; scalars are numbered as the value references of FMI 2.0 are, time
    last. `variables.txt` has a line for each value reference: its scalars. `dependencies.txt` has
    one for each dependency: value reference and element of what depends, of what it depends on, and
    how.
    """
    scalars = [v.name for v in description.variables if v.type == "Real"]
    numbers = {name: k for k, name in enumerate([*scalars, TIME])}
    place, lines, needs = places(variables), list[str](), list[str]()
    for variable in (v for v in variables if v.first.type == "Real"):
        lines.append(" ".join(str(numbers[m.name]) for m in variable.members))
        initial = variable.first.causality == "calculatedParameter"
        for member in variable.members:
            for name, kind in dependencies(member, initial=initial) or ():
                indices = (*place[member.name], *place[name], KIND_NUMBERS[kind])
                needs.append(" ".join(map(str, indices)))
    texts = {"variables.txt": lines, "dependencies.txt": needs}
    return {
        f"resources/{name}": "".join(f"{x}\n" for x in text).encode()
        for name, text in texts.items()
    }


def _candidates(names: Sequence[str]) -> dict[str, tuple[tuple[int, ...], list[str]]]:
    """Name of an array → its shape and elements, for all that are complete."""
    found: dict[str, dict[tuple[int, ...], str]] = {}
    families: dict[tuple[str, str], dict[str, str]] = {}
    for name in names:
        rate = re.fullmatch(r"der\((.+)\)", name)
        before, inner, after = ("der(", rate[1], ")") if rate else ("", name, "")
        if index := re.fullmatch(r"(.+)\[([0-9]+(?:,[0-9]+)*)\]", inner):
            place = tuple(map(int, index[2].split(",")))
            found.setdefault(f"{before}{index[1]}{after}", {})[place] = name
        elif (split := inner.rpartition("."))[0]:
            families.setdefault((f"{before}{split[0]}.", after), {})[split[2]] = name
    arrays: dict[str, tuple[tuple[int, ...], list[str]]] = {}
    for (before, after), members in families.items():
        for vector, parts in _vectors(members).items():
            arrays[f"{before}{vector}{after}"] = (len(parts),), [members[part] for part in parts]
    for name, parts in found.items():
        shape = tuple(map(max, zip(*parts, strict=True))) if len(set(map(len, parts))) == 1 else ()
        from_one = all(min(place, default=0) > 0 for place in parts)
        if from_one and len(parts) == prod(shape) > 1:
            arrays[name] = shape, [parts[place] for place in sorted(parts)]
    return arrays


def _vectors(parts: Collection[str]) -> dict[str, tuple[str, ...]]:
    """Name of each vector among the last parts of names that begin alike → its components."""
    found = {name: whole for name, whole in IN_SPACE.items() if set(whole) <= set(parts)}
    taken = {part for whole in found.values() for part in whole}
    by_axis: dict[str, list[tuple[str, str]]] = {}
    for part in (part for part in parts if part not in taken):
        if component := _component(part):
            vector, axis = component
            by_axis.setdefault(vector, []).append((axis, part))
    for vector, components in by_axis.items():
        if len(components) > 1 and vector not in found:
            found[vector] = tuple(part for _, part in sorted(components))
    return found


def _component(last: str) -> tuple[str, str] | None:
    """Vector and axis of the last part of a name, as in `vx` and `force_x`."""
    motion = re.fullmatch(r"([va]?)([xyz])", last)
    if motion:
        return _MOTION[motion[1]], motion[2]
    other = re.fullmatch(r"(.+)_([xyz])", last)
    return (other[1], other[2]) if other else None


def _uniform(group: Grouped) -> bool:
    keys = ("type", "causality", "variability", "initial", "display_unit", *LIMITS)
    agreed = {tuple(getattr(v, key) for key in keys) for v in group.members}
    started = {v.start is None for v in group.members}
    one_unit = len(group.shape) > 1 or len({v.unit for v in group.members}) == 1
    return len(agreed) == 1 and len(started) == 1 and one_unit


def _summed(texts: list[str]) -> list[str]:
    """As one text, if the texts differ in one word only: `Force, world X, Y, Z`."""
    columns = [
        list(dict.fromkeys(words)) for words in zip(*(t.split() for t in texts), strict=False)
    ]
    same_length = len({len(text.split()) for text in texts}) == 1
    if same_length and len(columns) > 1 and sum(len(words) > 1 for words in columns) == 1:
        return [" ".join(", ".join(words) for words in columns)]
    return texts


def _group_of(found: Mapping[str, Grouped]) -> dict[str, Grouped]:
    """Name of each scalar that is an element → the array."""
    return {m.name: group for group in found.values() for m in group.members}


def _unfit(found: Mapping[str, Grouped], variables: Collection[FmuVariable]) -> list[str]:
    """Names of arrays that are derivatives of other things, or have scalars as derivatives."""
    members = _group_of(found)
    arrays = {tuple(m.name for m in group.members) for group in found.values()}
    of_scalars = {v.derivative_of for v in variables if v.name not in members}

    def fit(group: Grouped) -> bool:
        bases = tuple(v.derivative_of for v in group.members)
        sound = not any(bases) or bases in arrays
        return sound and not any(m.name in of_scalars for m in group.members)

    return [name for name, group in found.items() if not fit(group)]
