"""Closed surfaces of hulls, with their part above the water, checked."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import Box, Revolved, Shape, Sphere
from m4e_adapters.hydrodynamics.geometry.checks import Wrong, check_edges, check_shells, place
from m4e_adapters.hydrodynamics.geometry.mesh_files import drawn_panels
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels, joined
from m4e_adapters.hydrodynamics.geometry.remeshing import even_panels
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, sphere_panels
from m4e_adapters.hydrodynamics.geometry.solids import union_of, whole_revolved
from m4e_adapters.hydrodynamics.pressure.config import HullBody, HullPressureConfig
from m4e_fmi.errors import InputError, Problem

Bodies = dict[str, Panels]
TO_THE_DECK = "mesh the whole hull up to the deck, closed, not only what is below the water"


def closed_hulls(config: HullPressureConfig, folder: Path) -> Bodies:
    """The closed surfaces of all bodies in the reference pose; InputError with all problems."""
    hulls: Bodies = {}
    problems: list[Problem] = []
    for name, body in config.bodies.items():
        try:
            hulls[name] = closed_hull(name, body, folder)
        except InputError as error:
            problems += error.problems
            continue
        lowest = float(hulls[name].vertices[:, 2].min())
        if lowest <= -config.water.depth:
            text = f"body {name!r} reaches down to z = {lowest:.4g} m, the sea bed is at z = "
            text += f"{-config.water.depth:.4g} m"
            keys = ("bodies", name, "shape", body.shape.kind)
            problems.append(Problem(text, "give more water.depth, or less draft", keys=keys))
    InputError.raise_for(problems)
    return hulls


def closed_hull(name: str, body: HullBody, folder: Path) -> Panels:
    """The closed surface of a body in the reference pose, normals out of it.

    InputError where it is not closed, has no part in the water, or is closed at the waterline.
    """
    keys = ("bodies", name, "shape", body.shape.kind)
    if body.shape.union is not None:
        solid = union_of(name, body.shape, body.center_of_gravity, folder, whole=True)
        panels, file = even_panels(solid, body.panels, name, wetted=False), ""
    elif body.shape.mesh is None:
        panels, file = _drawn(body.shape, body.panels), ""
    else:
        panels = drawn_panels(name, body.shape, body.center_of_gravity, folder)
        file = str(folder / body.shape.mesh)

    def wrong(message: str, remedy: str) -> InputError:
        return InputError.single(f"body {name!r}: {message}", remedy, keys=keys)

    try:
        _check_closed(panels, wrong)
        reach = 10.0 * RELATIVE_TOLERANCE * panels.size
        low, high = panels.vertices[:, 2].min(), panels.vertices[:, 2].max()
        if low >= -reach:
            raise wrong(
                f"the hull is above the water (lowest point at z = {low:.4g} m)",
                "draw it in the reference pose (z = 0 is the still-water level, Z points up), or "
                "say with mesh_origin where the origin of its mesh lies",
            )
        if abs(high) < reach:
            text = "the hull ends at the still-water level: it has no part above the water"
            raise wrong(text, TO_THE_DECK)
        check_shells(panels, wrong, lowered=panels.vertices[:, 2].max() + panels.size)
    except InputError as error:
        raise InputError([replace(p, file=file, keys=keys) for p in error.problems]) from None
    return panels


def _drawn(shape: Shape, count: int) -> Panels:
    """The surface of a built-in shape; that of a sphere or box displaces its exact volume."""
    if shape.cylinder is not None:
        one, top = shape.cylinder, shape.cylinder.freeboard or 0.0
        profile = ((one.radius, -one.draft), (one.radius, top))
        whole = Revolved(profile=profile, center_x=one.center_x, center_y=one.center_y)
        return whole_revolved(whole, count)
    if shape.revolved is not None:
        return whole_revolved(shape.revolved, count)
    if shape.sphere is not None:
        return _sphere(shape.sphere, count)
    assert shape.box is not None
    return _box(shape.box, count)


def _sphere(shape: Sphere, count: int) -> Panels:
    """A ball of two parts that meet in the waterline, each of its exact volume."""
    height = shape.center_z / shape.radius
    if height <= -1.0:
        return sphere_panels(shape, count)
    upper = shape.model_copy(update={"center_z": -shape.center_z})
    share = math.acos(height) / math.pi  # of the profile that is below the water
    lower = sphere_panels(shape, round(share * count))
    return _of_halves(lower, sphere_panels(upper, round((1.0 - share) * count)))


def _box(shape: Box, count: int) -> Panels:
    upper = shape.model_copy(update={"draft": shape.freeboard})
    around = 2.0 * (shape.length + shape.width)
    areas = [shape.length * shape.width + around * half.draft for half in (shape, upper)]
    counts = [round(count * area / sum(areas)) for area in areas]
    return _of_halves(box_panels(shape, counts[0]), box_panels(upper, counts[1]))


def _of_halves(lower: Panels, upper: Panels) -> Panels:
    """`lower`, and above the water the mirror image of `upper`."""
    mirrored = Panels(upper.vertices * np.array([1.0, 1.0, -1.0]), upper.faces).reversed
    return joined(lower, mirrored)


def _check_closed(panels: Panels, wrong: Wrong) -> None:
    """The error that `wrong` makes where an edge is not one of two panels that face one way."""
    unshared = [edge for edge, sides in panels.edges().items() if len(sides) == 1]
    if not unshared:
        check_edges(panels, wrong)
        return
    heights = panels.vertices[np.array(unshared).ravel(), 2]
    if np.abs(heights).max() < 10.0 * RELATIVE_TOLERANCE * panels.size:
        raise wrong(
            "the mesh is open at the waterline: it has no part above the water", TO_THE_DECK
        )
    where = place(panels.vertices[list(unshared[0])].mean(axis=0))
    raise wrong(
        f"the mesh is not closed: {len(unshared)} edges belong to one panel only, the first "
        f"{where}",
        f"close the holes, or join panels that do not share their vertices; {TO_THE_DECK}",
    )
