"""Checks of the places of bodies: as many coordinates as dimensions, none beside the X-Z plane."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from pydantic_core import InitErrorDetails

from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.sections import Body
from m4e_adapters.hydrodynamics.config.shapes import Part, Shape
from m4e_adapters.hydrodynamics.config.waves import Waves, waves_beyond_the_plane
from m4e_fmi.files.document import rejected_at

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
        for keys, part in _parts(body.shape):
            given[(*keys, "mesh_origin")] = part.mesh_origin
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


def _parts(shape: Shape) -> Iterator[tuple[tuple[str | int, ...], Part]]:
    """The shape itself, or the parts of its union, and the way to each."""
    if shape.union is None:
        yield ("shape",), shape
        return
    yield from ((("shape", "union", k), part) for k, part in enumerate(shape.union))


def out_of_plane(bodies: Mapping[str, Placed], waves: Waves) -> Iterator[InitErrorDetails]:
    """Directions and places that leave the X-Z plane; parts of unions may be aside in pairs."""
    for place, message, advice in waves_beyond_the_plane(waves):
        yield rejected_at(("waves", *place), message, advice)
    for name, body in bodies.items():
        kind = body.shape.kind
        if getattr(getattr(body.shape, kind, None), "center_y", 0.0):
            place = ("bodies", name, "shape", kind, "center_y")
            yield rejected_at(place, "'center_y' leaves the X-Z plane", OF_SPACE)
