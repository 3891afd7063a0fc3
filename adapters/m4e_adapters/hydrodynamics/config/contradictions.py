"""Keys that have no effect beside others: told with all that is wrong with shapes and files."""

from __future__ import annotations

from collections.abc import Iterator

from m4e_adapters.hydrodynamics.config.component import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.config.sections import Body
from m4e_fmi.errors import Problem


def keys_without_effect(config: HydrodynamicsConfig) -> Iterator[Problem]:
    """A problem for each key of a body that its other keys leave without effect."""
    for name, body in config.bodies.items():
        for keys, message, remedy in _without_effect(body):
            yield Problem(message, remedy, keys=("bodies", name, *keys))


def _without_effect(body: Body) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """Place, message and remedy of each."""
    if body.shape.mesh is not None and "panels" in body.model_fields_set:
        remedy = "remove it, or refine the mesh itself"
        yield ("panels",), "'panels' has no effect on a mesh file", remedy
    if not body.fixed:
        return
    for key in ("center_of_gravity", "drag", "drift"):
        if key in body.model_fields_set:
            text = f"'{key}' has no effect on a fixed body"
            yield (key,), text, "remove it, or remove 'fixed'"
    if body.shape.frame != "world":
        text = "a fixed body has no centre of gravity that 'frame: body' could be about"
        yield ("shape", "frame"), text, "remove it and give mesh_origin"
