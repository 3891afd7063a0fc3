"""All keys of the component, and what does not go together among them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal, Protocol

from pydantic import Field, model_validator
from pydantic_core import InitErrorDetails, ValidationError

from m4e_adapters.hydrodynamics.config.numbers import Finite, Place
from m4e_adapters.hydrodynamics.config.sections import (
    NAME,
    Body,
    Frequencies,
    Loads,
    Radiation,
    Water,
)
from m4e_adapters.hydrodynamics.config.shapes import Shape
from m4e_adapters.hydrodynamics.config.waves import (
    Current,
    Still,
    Waves,
    flow_problems,
)
from m4e_fmi.files.document import Section, rejected_at

Keys = tuple[str | int, ...]
OF_SPACE = "remove it, or write 'dimensions: 3' on top of the component"


class Placed(Protocol):
    """A body that has places."""

    @property
    def shape(self) -> Shape: ...

    @property
    def center_of_gravity(self) -> Place: ...


def misplaced(bodies: Mapping[str, Placed], dimensions: int) -> Iterator[InitErrorDetails]:
    """Places of `bodies` that do not have as many coordinates as `dimensions` says."""
    axes = "[x, z]" if dimensions == 2 else "[x, y, z]"
    for name, body in bodies.items():
        drift = body.drift if isinstance(body, Body) else None
        given: dict[tuple[str | int, ...], Place | None] = {
            ("drift", "reference_point"): drift.reference_point if drift else None,
            ("reference_point",): body.reference_point if isinstance(body, Body) else None,
            ("weight_at",): body.weight_at if isinstance(body, Body) else None,
        }
        for k, part in enumerate(body.shape.parts):
            way = ("shape",) if body.shape.union is None else ("shape", "union", k)
            given[(*way, "mesh_origin")] = part.mesh_origin
        if body.center_of_gravity:
            given["center_of_gravity",] = body.center_of_gravity
        for keys, place in given.items():
            if place is None or len(place) == dimensions:
                continue
            text = f"'{keys[-1]}' has {len(place)} coordinates, expected {axes}"
            remedy = f"write {axes}; numbers have a decimal point"
            if dimensions == 2:
                remedy += ", and places in space need 'dimensions: 3'"
            yield rejected_at(("bodies", name, *keys), text, remedy)


def out_of_plane(bodies: Mapping[str, Placed]) -> Iterator[InitErrorDetails]:
    """Shapes that leave the X-Z plane; parts of unions may be aside in pairs."""
    for name, body in bodies.items():
        kind = body.shape.kind
        if getattr(getattr(body.shape, kind, None), "center_y", 0.0):
            place = ("bodies", name, "shape", kind, "center_y")
            yield rejected_at(place, "'center_y' leaves the X-Z plane", OF_SPACE)


OWN_NAMES = ("wave", "current", "heading")
"""First parts of names of variables that are of no body."""


class HydrodynamicsConfig(Section):
    """Floating bodies in water: linear potential flow, drag, waves, a current that makes drag.

    `dimensions: 2` (default) is the X-Z plane with surge, heave and pitch; `dimensions: 3` has all
    six motions and waves in any direction. There `heading` [deg] is the angle from +X, towards +Y,
    of the axis of the hulls that is drawn along +X: they are turned as one about the vertical
    through the middle of their centres of gravity. `coefficients` names a file of WAMIT
    (FILE.1 with .3 and .hst beside it), BEMIO (.h5) or Capytaine (.nc), relative to the system
    file's folder: then nothing is computed. `body_to_body: false` leaves out the forces of one
    body's motion on another.
    """

    dimensions: Literal[2, 3] = 2
    water: Water = Water()
    heading: Finite = 0.0
    coefficients: str | None = None
    body_to_body: bool = True
    bodies: Annotated[dict[Annotated[str, Field(pattern=NAME)], Body], Field(min_length=1)]
    frequencies: Frequencies = Frequencies()
    radiation: Radiation = Radiation()
    waves: Waves = Still(spectrum="still")
    current: Current | None = None
    loads: Loads = Loads()

    @model_validator(mode="after")
    def _of_its_dimensions(self) -> HydrodynamicsConfig:
        wrong = [*misplaced(self.bodies, self.dimensions), *_without_effect(self)]
        for name in (name for name in self.bodies if name in OWN_NAMES):
            text = f"the name {name!r} has another meaning here"
            wrong.append(rejected_at(("bodies", name), text, "give it another name"))
        wrong += flow_problems(
            self.waves, self.current, depth=self.water.depth, dimensions=self.dimensions
        )
        wrong += _missing(self)
        for name, body in self.bodies.items():
            if self.loads.displaced and body.drift is not None:
                text = "the excitation at the displaced place has a part of the second-order drift "
                text += f"of body {name!r}, which counts it all"
                remedy = "remove the body's drift, or excitation_at"
                wrong.append(rejected_at(("loads", "excitation_at"), text, remedy))
        if all(body.fixed for body in self.bodies.values()):
            wrong.append(rejected_at(("bodies",), "all bodies are fixed", "let one of them move"))
        if self.dimensions == 2:
            wrong += _beyond_the_plane(self)
        if wrong:
            raise ValidationError.from_exception_data("hydrodynamics", wrong)
        return self

    @property
    def feels_current(self) -> bool:
        """True if a current acts on a body, or would if there was one."""
        drags = [body.drag for body in self.bodies.values()]
        return self.loads.drag != "none" and any(drag.feels_current for drag in drags)


def _without_effect(config: HydrodynamicsConfig) -> Iterator[InitErrorDetails]:
    """Keys that other keys leave without effect."""
    of_file, on_file = config.coefficients is not None, " on coefficients of a file"
    rows: list[tuple[Section, Keys, bool, str, str]] = [
        (config, ("frequencies",), of_file, on_file, "remove it: the file has its own"),
    ]
    for name, body in config.bodies.items():
        whys = {
            ("reference_point", "weight_at", "volume"): (
                not of_file,
                " on a shape",
                "remove it, or name a file of 'coefficients'",
            ),
            ("shape", "panels", "slides_on"): (
                of_file,
                " with coefficients of a file",
                "remove it, or the key 'coefficients' of the component",
            ),
            ("fixed",): (
                of_file,
                " with coefficients of a file",
                "leave the body out: bodies of the file that are not named are held in place",
            ),
            ("center_of_gravity", "drag", "drift"): (
                body.fixed,
                " on a fixed body",
                "remove it, or remove 'fixed'",
            ),
            ("panels",): (
                body.shape.mesh is not None,
                " on a mesh file",
                "remove it, or refine the mesh itself",
            ),
        }
        rows += [(body, ("bodies", name, key), *why) for keys, why in whys.items() for key in keys]
        framed = body.fixed and body.shape.frame != "world"
        keys = ("bodies", name, "shape", "frame")
        remedy = "remove it and give mesh_origin: the body has no centre of gravity"
        rows.append((body.shape, keys, framed, " on a fixed body", remedy))
    for section, keys, applies, why, remedy in rows:
        key = str(keys[-1])
        if applies and key in section.model_fields_set and getattr(section, key):
            yield rejected_at(keys, f"'{key}' has no effect{why}", remedy)


def _missing(config: HydrodynamicsConfig) -> Iterator[InitErrorDetails]:
    """Keys of bodies with shapes that are missing, or lead to no body."""
    for name, body in config.bodies.items() if config.coefficients is None else ():
        missing = [] if "shape" in body.model_fields_set else ["shape"]
        if not body.fixed and not body.center_of_gravity:
            missing.append("center_of_gravity")
        for key in missing:
            yield InitErrorDetails(type="missing", loc=("bodies", name, key), input=None)
        if body.slides_on is not None and body.slides_on not in set(config.bodies) - {name}:
            text = f"body {name!r} slides on {body.slides_on!r}, which is no other body"
            others = ", ".join(set(config.bodies) - {name}) or "there is none"
            yield rejected_at(("bodies", name, "slides_on"), text, f"name another body: {others}")


def _beyond_the_plane(config: HydrodynamicsConfig) -> Iterator[InitErrorDetails]:
    """Keys and values of space in a component of the X-Z plane."""
    yield from out_of_plane(config.bodies)
    if "heading" in config.model_fields_set:
        yield rejected_at(("heading",), "'heading' is of space", OF_SPACE)
    for name, body in config.bodies.items():
        for way, drag in (("drag",), body.drag), (("drag", "linear"), body.drag.linear):
            for key in {"sway", "roll", "yaw"} & drag.model_fields_set:
                yield rejected_at(("bodies", name, *way, key), f"'{key}' is of space", OF_SPACE)
