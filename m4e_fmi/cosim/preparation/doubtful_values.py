"""Warnings of allowed values that seem wrong: surroundings that differ, loads that count twice.

A kind whose configuration has a section `water` is in water of that density, depth and gravity, and
one with `waves` or a `current` in that sea, unless its waves are the word `none`. A model that such
a component acts on has a gravity, too. A kind may offer ``displaced(config, *, folder)``: the
surfaces of what has buoyancy in it, in the axes of each body, by body and name.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from itertools import combinations, pairwise, permutations
from typing import Any

import numpy as np

from m4e_fmi.cosim.system.component import Component, Kind, ModelFile, kind_module
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.link_checks import moved_together
from m4e_fmi.cosim.wiring.links import BondAxis, Link, Port, Wiring, conversion
from m4e_fmi.cosim.wiring.structure import Structure, Transfer
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.report.drawing.hulls import Hull

RAMP = "ramp_time"
"""Last word of parameters that are the time in which a sea grows from nothing [s]."""
DRAG = ("drag_", "linear_drag_")
"""Beginnings of the last names of a hull's drag coefficients; `drag_force_…` are outputs."""
DISPLACED = "displaced"
DOWN = np.array([0.01234, 0.02718, -1.0])
"""Direction of rays that seldom meet an edge; downwards, as hulls may be open at the top."""
UNITS = {"density": "kg/m3", "depth": "m", "gravity": "m/s2"}
SHARED = {"waves": "sea", "current": "stream"}
"""Sections that components of one sea share, and the YAML anchors that remedies propose."""
SAME = 1e-3
"""Relative difference that is none: 9.80665 and 9.81 m/s2 are the same gravity."""
Descriptions = Mapping[str, Description]


def ramps(system: System, descriptions: Mapping[str, Description]) -> dict[str, float]:
    """The ramp [s] of each sea by COMPONENT.VARIABLE, at the start values of the system."""
    return {
        f"{component.name}.{name}": float(
            value_of(variable, component.start.get(name, float(variable.start)))
        )
        for component in system.components
        for name, variable in descriptions[component.name].variables.items()
        if name.rpartition(".")[2] == RAMP and variable.start is not None
    }


def within_ramps(system: System, descriptions: Mapping[str, Description]) -> Iterator[str]:
    """One line for each sea that has not grown to its full height when the run ends."""
    span = system.simulation.stop_time - system.simulation.start_time
    for name, ramp in ramps(system, descriptions).items():
        if span <= ramp:
            yield (
                f"the run of {span:g} s ends within the ramp of the sea, {name} = {ramp:g} s: no "
                "row is of the full sea; take a later stop_time, or a shorter ramp"
            )


def start_values_without_effect(
    system: System, wiring: Wiring, structure: Structure
) -> Iterator[str]:
    """One line for each start value that a connection replaces at initialisation.

    Start values of delayed connections and of algebraic loops have an effect: they carry the run,
    or the solution, until the source is known.
    """
    replaced = {
        (step.component, name)
        for step in structure.initial
        if isinstance(step, Transfer) and step.action == "set"
        for name in step.variables
    }
    for link in (*wiring.links, *wiring.initial_links):
        target = link.target
        start = {c.name: c.start for c in system.components}[target.component]
        at = target.component, target.variable
        if target.variable in start and at in replaced and not link.delayed:
            yield (
                f"the start value of {target} has no effect: it is connected to {link.source}; "
                "leave out one of the two"
            )


def reversed_forces(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> Iterator[str]:
    """One line for each force of a component of a kind that is turned round, but not its motion.

    Forces of kinds act on the body, so that another sign makes power of nothing. That of a foreign
    FMU may be the reaction, for which -1 is right.
    """
    kinds = {c.name for c in system.components if isinstance(c.source, Kind)}
    for axis in (axis for bond in wiring.bonds for axis in bond.axes):
        giver = axis.force.source.component
        if giver not in kinds or axis.velocity.target.component != giver:
            continue
        if axis.share * _written(axis, descriptions) < 0.0:
            yield (
                f"the connection '{axis.force}' has the factor {axis.share:g}, but that of its "
                f"motion, '{axis.velocity}', has another sign: the power is not kept, as "
                f"{axis.force.source} acts on the body already; leave out the sign"
            )


def _written(axis: BondAxis, descriptions: Mapping[str, Description]) -> float:
    """The factor of the motion without that between its units."""
    link: Link = axis.velocity
    give, take = (descriptions[p.component].variables[p.variable] for p in link.ends)
    return link.factor / conversion(give, take)[0]


def double_drag(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> Iterator[str]:
    """A line on each two components that move with one body and both have drag on it."""
    for source, takers in moved_together(wiring.links).items():
        acting = [k.target for k in takers if _has_drag(system, descriptions, k.target)]
        for one, other in combinations(acting, 2):
            body, first, second = (str(p).removesuffix(".z") for p in (source, one, other))
            yield (
                f"{first} and {second} both have drag on {body}: right for different parts of it; "
                "of the same part leave it to one of them"
            )


def _has_drag(system: System, descriptions: Mapping[str, Description], port: Port) -> bool:
    """True if the component gives drag on the body whose height is `port`.

    A hull's coefficients are parameters of the body; members have their own.
    """
    body = port.variable.removesuffix("z")
    variables = descriptions[port.component].variables
    if f"{body}drag_force_z" not in variables:
        return False
    start = next(c.start for c in system.components if c.name == port.component)
    coefficients = [
        variable
        for name, variable in variables.items()
        if name.startswith(tuple(body + part for part in DRAG))
        and variable.causality == "parameter"
    ]
    values = (value_of(v, start.get(v.name, float(v.start or 0.0))) for v in coefficients)
    return not coefficients or any(value != 0.0 for value in values)


def double_buoyancy(system: System, wiring: Wiring) -> Iterator[str]:
    """A line on each two components on one body of which one has parts within a hull of the other.

    Parts of a surface, such as members, are within it where any of their corners is.
    """
    for source, takers in moved_together(wiring.links).items():
        ports = [link.target for link in takers] if len(takers) > 1 else []
        surfaces = {port: _displaced(system, port) for port in ports}
        for one, other in permutations(surfaces, 2):
            names = [
                name
                for name, part in surfaces[one].items()
                if any(_reach_into(part, hull) for hull in surfaces[other].values())
            ]
            if names:
                body, first, second = (str(p).removesuffix(".z") for p in (source, one, other))
                yield (
                    f"{', '.join(names)} of {first}: in part or in full within {second}, so that "
                    f"buoyancy on {body} counts twice there; end members at the hull, or write "
                    "'buoyancy: false' (and 'added_mass: 0, inertia: 0') at them"
                )


def _displaced(system: System, port: Port) -> Mapping[str, Hull]:
    """Surfaces of what has buoyancy on the body whose height is `port`; none if not known."""
    source = next(c.source for c in system.components if c.name == port.component)
    find = getattr(kind_module(source.name), DISPLACED, None) if isinstance(source, Kind) else None
    if find is None or not isinstance(source, Kind):
        return {}
    try:
        found: Mapping[str, Mapping[str, Hull]] = find(source.config, folder=system.folder)
    except InputError:  # told where the component is built
        return {}
    return found.get(port.variable.removesuffix(".z"), {})


def _reach_into(part: Hull, hull: Hull) -> bool:
    """True if a corner of `part` is within `hull`: a ray meets its surface an odd number of times.

    (T. Möller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools 2,
    1997.)
    """
    triangles = np.array([(face[0], *pair) for face in hull.faces for pair in pairwise(face[1:])])
    corner, *others = (hull.vertices[triangles[:, k]] for k in range(3))
    one, two = (other - corner for other in others)
    across = np.cross(DOWN, two)
    volume = np.einsum("ij,ij->i", one, across)
    inverse = 1.0 / np.where(volume == 0.0, np.inf, volume)
    low, high = hull.vertices.min(axis=0), hull.vertices.max(axis=0)
    near = part.vertices[np.all((part.vertices > low) & (part.vertices < high), axis=1)]
    for point in near:
        away = point - corner
        normal = np.cross(away, one)
        first = np.einsum("ij,ij->i", away, across) * inverse
        second = normal @ DOWN * inverse
        ahead = np.einsum("ij,ij->i", two, normal) * inverse > 0.0
        met = ahead & (first > 0.0) & (second > 0.0) & (first + second < 1.0)
        if int(met.sum()) % 2:
            return True
    return False


def differing(system: System, descriptions: Descriptions, wiring: Wiring) -> list[str]:
    """Water, waves and gravity that differ between two components; a line each, with places."""
    found = ((c.name, _section(c, "water")) for c in system.components)
    waters = {name: water for name, water in found if water is not None}
    differences: list[str] = []
    for (first, one), (second, other) in combinations(waters.items(), 2):
        for key, unit in UNITS.items():
            a, b = getattr(one, key, None), getattr(other, key, None)
            if a is not None and b is not None and not _same(a, b):
                differences.append(
                    f"{_text(system, first, key, a)}, {_text(system, second, key, b)} {unit}: "
                    "components in one water need the same"
                )
    return [
        *differences,
        *_seas(system, "waves"),
        *_seas(system, "current"),
        *_weights(system, descriptions, wiring, waters),
    ]


def _seas(system: System, key: str) -> Iterator[str]:
    """Waves or currents (`key`) that are not those of another component.

    By their section or by start values; no `current` is one of 0, which differs from others, unless
    the component would not feel one.
    """
    seas = {
        c.name: (section, {name: x for name, x in c.start.items() if is_of(name, key)})
        for c in system.components
        if (section := _section(c, key)) not in ("none", None) or key in _may_be_left_out(c)
    }
    for (first, one), (second, other) in combinations(seas.items(), 2):
        if one == other:
            continue
        if one[0] == other[0]:
            how, remedy = f"start values of {key}", "set them in all of them"
        else:
            how, name = key, SHARED[key]
            remedy = f"write the section once, `{key}: &{name} {{…}}`, and `{key}: *{name}`"
            remedy += " elsewhere"
        yield (
            f"the {how} of {first}{_line(system, first, key)} and of "
            f"{second}{_line(system, second, key)} differ: components in one sea need the "
            f"same: {remedy}"
        )


def _may_be_left_out(component: Component) -> tuple[str, ...]:
    """Keys whose absence means that the effect is absent.

    A configuration whose `feels_current` is False may leave out the current of others.
    """
    source = component.source
    if not isinstance(source, Kind) or not hasattr(source.config, "current"):
        return ()
    return ("current",) if getattr(source.config, "feels_current", True) else ()


def is_of(name: str, key: str) -> bool:
    """True of the `name` of a parameter of waves or a current."""
    return re.split(r"[.[]", name)[0] == ("wave" if key == "waves" else key)


def _weights(
    system: System, descriptions: Descriptions, wiring: Wiring, waters: Mapping[str, Any]
) -> Iterator[str]:
    """Models whose gravity is not that of the water which acts on them."""
    acts = {(link.source.component, link.target.component) for link in wiring.links}
    for water, model in sorted(acts):
        there = getattr(waters.get(water), "gravity", None)
        if there is None:
            continue
        gravity = model_gravity(system, descriptions, model)
        if not _same(gravity, there):
            yield (
                f"the gravity of {model}'s model is {gravity:g}, "
                f"{_text(system, water, 'gravity', there)} m/s2: bodies of the mass of the "
                "displaced water do not float; make them equal"
            )


def model_gravity(system: System, descriptions: Descriptions, name: str) -> float | None:
    """The gravity [m/s2] towards −Z of a component that is built from a model still there."""
    from m4e_fmi.model import load_model
    from m4e_fmi.model.elements import gravity_of, parameter_values

    (component,) = (c for c in system.components if c.name == name)
    if not isinstance(component.source, ModelFile):
        return None
    try:
        model = load_model(component.source.path)
    except InputError:
        return None
    variables, values = descriptions[name].variables, parameter_values(model.parameters)
    for key, given in component.start.items():
        if key in values:
            values[key] = float(value_of(variables[key], given))
    return float(gravity_of(model)[-1].evaluate(values))


def _section(component: Component, key: str) -> Any:
    source = component.source
    return getattr(source.config, key, None) if isinstance(source, Kind) else None


def _same(a: float | None, b: float | None) -> bool:
    return a is None or b is None or a == b or math.isclose(a, b, rel_tol=SAME)


def _text(system: System, component: str, key: str, value: float) -> str:
    """A value and its place."""
    text = "deep" if math.isinf(value) else f"{value:g}"
    return f"{component}.water.{key} is {text}{_line(system, component, 'water', key)}"


def _line(system: System, component: str, *keys: str) -> str:
    """The line of a key of a component, in brackets; "" if that is not known."""
    line = system.problem(("components", component, *keys), "").line
    return f" (line {line})" if line else ""
