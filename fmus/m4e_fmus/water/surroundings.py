"""Surroundings that differ between components in one water.

A kind whose configuration has a section `water` is in water of that density, depth and gravity, and
one with `waves` or a `current` in that sea, unless its waves are the word `none`. A model that such
a component acts on has a gravity, too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from itertools import combinations

from m4e_fmi.cosim.system.component import Component, Kind, ModelFile
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Wiring
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import Description

UNITS = {"density": "kg/m3", "depth": "m", "gravity": "m/s2"}
SHARED = {"waves": "sea", "current": "stream"}
"""Sections that components of one sea share, and the YAML anchors that remedies propose."""
SAME = 1e-3
"""Relative difference that is none: 9.80665 and 9.81 m/s2 are the same gravity."""
Descriptions = Mapping[str, Description]


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
    system: System, descriptions: Descriptions, wiring: Wiring, waters: Mapping[str, object]
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
    from m4e_fmi.model.elements import parameter_values
    from m4e_fmi.model.groups import gravity_of

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


def _section(component: Component, key: str) -> object:
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
