"""The scene of a system: what its models and kinds show, followed along its connections."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import Component, Kind, ModelFile, kind_of
from m4e_fmi.cosim.system.start_values import start_values
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import Description
from m4e_fmi.model import load_model
from m4e_fmi.report.animation.of_parts import PartScenes
from m4e_fmi.report.animation.scene import Followed, Scene, Value, Water
from m4e_fmi.report.animation.shown import Shown


def system_scene(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> Scene | None:
    """The scene of a system with these `descriptions` and `wiring`; None if it shows no bodies.

    Components that are FMUs show nothing. Notes of the scene tell of parts that cannot be made.
    """
    sources: dict[Port, Link] = {link.target: link for link in wiring.links}
    starts = {c.name: _starts(c, descriptions[c.name]) for c in system.components}

    def follow(component: str, variable: str) -> Value:
        """The variable that an input follows, or an output; else the start value, or 0."""
        own = descriptions[component].variables.get(variable)
        if own is not None and own.causality == "output":
            return Followed(f"{component}.{variable}")
        link = sources.get(Port(component, variable))
        if link is not None:
            return Followed(str(link.source), link.factor, link.offset)
        return starts[component].get(variable, 0.0)

    parts = PartScenes(follow)
    for component in system.components:
        name, source = component.name, component.source
        try:
            if isinstance(source, ModelFile):
                parts.add_model(name, load_model(source.path), starts[name])
            elif isinstance(source, Kind) and (shown := _shown(system, source, starts[name])):
                parts.add(name, shown)
        except InputError as error:
            parts.notes.append(f"{name} is not shown: {error.problems[0].message}")
    return parts.whole(system.name, system.description)


def scene_without_build(system: System) -> Scene | None:
    """The scene of a system of which nothing is built; None if it shows no bodies."""
    descriptions = expected_descriptions(system)
    known = tuple(c for c in system.components if c.name in descriptions)
    part = replace(system, components=known)
    return system_scene(part, descriptions, connect(part, descriptions))


def waters(system: System, descriptions: Mapping[str, Description]) -> Iterator[Water]:
    """The water that each component shows, with its waves as they are at the start."""
    for component in system.components:
        source = component.source
        if isinstance(source, Kind):
            starts = _starts(component, descriptions[component.name])
            with suppress(InputError):  # a note of the scene
                if (shown := _shown(system, source, starts)) and shown.water:
                    yield shown.water


def _shown(system: System, source: Kind, values: Mapping[str, float]) -> Shown | None:
    """The scene of a kind. Its code may be anyone's: a fault of it is a note, and no error."""
    try:
        shown = kind_of(source.name).scene(source.config, folder=system.folder, values=values)
    except InputError:
        raise
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
        message = f"the scene of kind '{source.name}' failed with {found}"
        raise InputError.single(" ".join(message.split()), "") from error
    if shown is not None and not isinstance(shown, Shown):
        message = f"the scene of kind '{source.name}' is a {type(shown).__name__}, not a Shown"
        raise InputError.single(message, "")
    return shown


def _starts(component: Component, description: Description) -> dict[str, float]:
    """Values of the Reals of a component at the start, by name, in their units."""
    real = {name: v for name, v in description.variables.items() if v.type == "Real"}
    starts = {name: float(v.start) for name, v in real.items() if v.start is not None}
    given = start_values(component, description)
    return starts | {name: float(value) for name, value in given.items() if name in real}
