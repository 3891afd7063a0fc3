"""Hulls: the wetted surface of every body, checked, with a lid on its inner free surface.

The lid is a flat surface of panels on the water inside the hull: it removes the irregular
frequencies of the integral equation, at which its solution is otherwise wrong by tens of percent.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import Body, HydrodynamicsConfig
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine, kept_warnings
from m4e_adapters.hydrodynamics.geometry.checks import check_as_drawn, checked, place
from m4e_adapters.hydrodynamics.geometry.clearance import (
    ROOM,
    Gap,
    narrowest_gap,
    overlap,
    reaching,
)
from m4e_adapters.hydrodynamics.geometry.contact import (
    REMEDY,
    SlidingError,
    common_walls,
    on_the_bed,
)
from m4e_adapters.hydrodynamics.geometry.hydrostatics import (
    Hydrostatics,
    hydrostatics_of,
    hydrostatics_of_triangles,
)
from m4e_adapters.hydrodynamics.geometry.lid import make_lid, waterline
from m4e_adapters.hydrodynamics.geometry.mesh_files import Keys, drawn_panels
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels, joined
from m4e_adapters.hydrodynamics.geometry.remeshing import even_panels, opened
from m4e_adapters.hydrodynamics.geometry.shapes import (
    box_panels,
    cylinder_panels,
    horizontal_cylinder_panels,
    revolved_panels,
    sphere_hydrostatics,
    sphere_panels,
)
from m4e_adapters.hydrodynamics.geometry.solids import (
    is_symmetric,
    union_of,
)
from m4e_fmi.errors import InputError, Problem

BUILT_IN: Mapping[str, Callable[..., Panels]] = {
    "cylinder": cylinder_panels,
    "horizontal_cylinder": horizontal_cylinder_panels,
    "sphere": sphere_panels,
    "box": box_panels,
    "revolved": revolved_panels,
}
SHALLOW = 0.15  # overlap, over a panel's side, that the flat panels of round bodies may make
NARROW = 0.25  # gap over the side of a panel below which the flow in it is of no use


@dataclass(frozen=True)
class Hull:
    """A body's wetted surface and lid (None: none needed, or none possible).

    Motions are about `center` G: (x, z) [m] in the plane, (x, y, z) in space. `axis` (x, y) [m] is
    the upright axis of a body of revolution, about which it turns without moving the water. A
    `fixed` body has no motions and no centre; where it stands on the sea bed no water touches it:
    those panels are its `bed`. Walls along which it slides on another hull are `dry` too.
    """

    name: str
    panels: Panels
    lid: Panels | None
    center: tuple[float, ...]
    hydrostatics: Hydrostatics
    axis: tuple[float, float] | None = None
    fixed: bool = False
    bed: Panels | None = None
    dry: Panels | None = None

    @property
    def closed(self) -> Panels:
        """The surface with the panels that no water touches."""
        parts = [part for part in (self.panels, self.bed, self.dry) if part is not None]
        return joined(*parts) if len(parts) > 1 else self.panels


def make_hulls(
    config: HydrodynamicsConfig, folder: Path, *, progress: Callable[[str], object]
) -> tuple[Hull, ...]:
    """The hulls of all bodies in the order of the file; InputError with all problems."""
    hulls, problems = list[Hull](), list[Problem]()
    depth = config.water.depth
    for name, body in config.bodies.items():
        try:
            hull = make_hull(name, body, folder, depth=depth, progress=progress)
        except InputError as error:
            problems += error.problems
            continue
        hulls.append(hull)
        problems += _in_the_bed(hull, depth, ("bodies", name, "shape", body.shape.kind))
    hulls, wrong = sliding_hulls(hulls, config.bodies)
    problems += wrong
    for k, second in enumerate(hulls):
        keys = ("bodies", second.name, "shape", config.bodies[second.name].shape.kind)
        slides = config.bodies[second.name].slides_on
        others = (
            first
            for first in hulls[:k]
            if first.name != slides and second.name != config.bodies[first.name].slides_on
        )
        near = (found for first in others if (found := _too_near(first, second, progress)))
        if (found := next(near, None)) is not None:
            problems.append(Problem(*found, keys=keys))
    InputError.raise_for(problems)
    return tuple(hulls)


def sliding_hulls(
    hulls: Sequence[Hull], bodies: Mapping[str, Body]
) -> tuple[list[Hull], list[Problem]]:
    """The hulls with dry walls where a body `slides_on` another, and the problems of these."""
    named, problems = {hull.name: hull for hull in hulls}, list[Problem]()
    for name, body in bodies.items():
        if body.slides_on is None or not {name, body.slides_on} <= named.keys():
            continue
        pair = named[name], named[body.slides_on]
        keys = ("bodies", name, "slides_on")
        names = f"bodies {name!r} and {body.slides_on!r}"
        whole = pair[0].closed, pair[1].closed
        try:
            walls = common_walls(pair[0].panels, pair[1].panels, whole=whole)
        except SlidingError as error:
            text = f"{names} do not slide on each other: {error}"
            problems.append(Problem(text, REMEDY, keys=keys))
            continue
        wetted = [h.panels.selected(~dry) for h, dry in zip(pair, walls, strict=True)]
        points = (reaching(p, other) for p, other in zip(wetted, whole[::-1], strict=True))
        if (point := next((p for p in points if p is not None), None)) is not None:
            problems.append(Problem(f"{names} overlap {place(point)}", REMEDY, keys=keys))
            continue
        for hull, dry in zip(pair, walls, strict=True):
            parts = [p for p in (hull.dry, hull.panels.selected(dry)) if p is not None]
            still = joined(*parts) if len(parts) > 1 else parts[0]
            named[hull.name] = replace(hull, panels=hull.panels.selected(~dry), dry=still)
    return list(named.values()), problems


def _in_the_bed(hull: Hull, depth: float, keys: Keys) -> Iterator[Problem]:
    """A problem if the hull reaches the sea bed, on which only a fixed one may stand."""
    lowest = float(hull.panels.vertices[:, 2].min())
    over, reach = lowest + depth, RELATIVE_TOLERANCE * hull.panels.size
    if over > reach or (hull.fixed and abs(over) <= reach):
        return
    text = f"body {hull.name!r} reaches down to z = {lowest:.4g} m, the sea bed is at z = "
    remedy = "give more water.depth, or less draft"
    if abs(over) <= reach:
        remedy += "; a body that stands on the sea bed and does not move is 'fixed: true'"
    yield Problem(f"{text}{-depth:.4g} m", remedy, keys=keys)


def _too_near(
    first: Hull, second: Hull, progress: Callable[[str], object]
) -> tuple[str, str] | None:
    """Message and remedy of bodies that overlap, or nearly touch; of other narrow gaps a warning.

    Panels see a gap as a wall where it is much narrower than they are: their damping is then
    negative, by several times its largest value in gaps of a fifth of a side.
    """
    names = f"bodies {first.name!r} and {second.name!r}"
    point = overlap(first.closed, second.closed, inwards=SHALLOW)
    if point is not None:
        remedy = "move one of them (center_x, or mesh_origin of a mesh), or make one body of both"
        return f"{names} overlap {place(point)}", remedy
    gap = narrowest_gap(first.panels, second.panels)
    if gap is None:
        return None
    text = f"the gap between {names} {_wide(gap)}"
    remedy = "use more panels (a finer mesh), or a wider gap"
    if gap.width < NARROW * gap.side:
        return text, remedy
    finer = (ROOM * gap.side / gap.width) ** 2
    needed = " and ".join(f"{math.ceil(len(h.panels.faces) * finer)}" for h in (first, second))
    progress(
        f"warning: {text}: coefficients are inaccurate in short waves; use about {needed} panels, "
        f"so that the gap has {ROOM:g} of their sides, or a wider gap"
    )
    return None


def _wide(gap: Gap) -> str:
    return (
        f"is about {gap.width:.3g} m wide {place(gap.middle)}, where panels have sides of "
        f"{gap.side:.3g} m"
    )


def make_hull(
    name: str,
    body: Body,
    folder: Path,
    *,
    depth: float = math.inf,
    finer: int = 1,
    progress: Callable[[str], object] = print,
) -> Hull:
    """The checked hull of one body in water of that `depth` [m], its panels divided into `finer`².

    A lid that could not be made is told through `progress`.
    """
    with kept_warnings() as warnings:
        bed = depth if body.fixed else math.inf
        drawn, hydrostatics = _shape_panels(name, body, folder, bed, finer)
        panels = on_the_bed(drawn, bed)
        lid = make_lid(panels)
    for text in warnings:
        progress(f"warning: capytaine: {text}")
    if lid is None and waterline(panels):
        progress(
            f"warning: no lid could be made inside body {name!r}: its coefficients may be wrong "
            "near irregular frequencies; limit frequencies.maximum, or make a finer mesh"
        )
    for text in _narrow_inside(name, body, panels):
        progress(f"warning: {text}")
    if body.fixed:
        below = np.all(panels.corners[:, :, 2] == -depth, axis=1)  # no water touches these
        stands = panels.selected(below) if below.any() else None
        wetted = panels.selected(~below) if below.any() else panels
        return Hull(name, wetted, lid, (), hydrostatics, fixed=True, bed=stands)
    x, _, z = point_in_space(body.center_of_gravity)
    low, high = panels.vertices[:, 0].min(), panels.vertices[:, 0].max()
    if not low <= x <= high or z < panels.vertices[:, 2].min():
        progress(
            f"warning: the centre of gravity of body {name!r} (x = {x:.4g}, z = {z:.4g} m) is not "
            f"above or below its hull (x = {low:.4g} to {high:.4g} m), or under its lowest point: "
            "give the shape a center_x or draft that agrees, or a mesh its mesh_origin"
        )
    return Hull(name, panels, lid, body.center_of_gravity, hydrostatics, body.shape.axis)


def _shape_panels(
    name: str, body: Body, folder: Path, bed: float, finer: int
) -> tuple[Panels, Hydrostatics]:
    """The closed surface below the water of a body that may stand on a `bed` [m] so deep.

    With the hydrostatics of the shape, where these are known better than by its panels.
    """
    shape = body.shape
    if shape.union is not None:
        return _union_panels(name, body, folder, bed, finer)
    if shape.mesh is None:
        panels = BUILT_IN[shape.kind](getattr(shape, shape.kind), body.panels, finer)
        ball = shape.sphere
        return panels, hydrostatics_of(panels) if ball is None else sphere_hydrostatics(ball)
    placed = drawn_panels(name, shape, body.center_of_gravity, folder)
    try:
        check_as_drawn(placed, name, scale=shape.scale)
        panels = checked(on_the_bed(_immersed(placed, name), bed), name).divided(finer)
    except InputError as error:
        known = {"file": str(folder / str(shape.mesh)), "keys": ("bodies", name, "shape", "mesh")}
        raise InputError([replace(p, **known) for p in error.problems]) from None
    return panels, hydrostatics_of(panels)


def _union_panels(
    name: str, body: Body, folder: Path, bed: float, finer: int
) -> tuple[Panels, Hydrostatics]:
    """The surface of a union of shapes below the water, of even triangles."""
    keys = ("bodies", name, "shape", "union")
    try:
        solid = union_of(name, body.shape, body.center_of_gravity, folder, whole=False)
    except InputError as error:
        raise InputError([replace(p, keys=p.keys or keys) for p in error.problems]) from None
    if len(body.center_of_gravity) == 2 and not is_symmetric(solid, 1):
        raise InputError.single(
            f"body {name!r}: the union is not its own mirror image in the X-Z plane",
            "complete it, or write 'dimensions: 3' on top of the component",
            keys=keys,
        )
    solid = solid.trim_by_plane([0.0, 0.0, -1.0], 0.0)  # the part below the water
    if solid.is_empty():
        raise InputError.single(
            f"body {name!r}: all parts of the union are above the water",
            "z = 0 is the still-water level, Z points up",
            keys=keys,
        )
    try:
        panels = on_the_bed(even_panels(solid, body.panels, name, wetted=True), bed)
        many = [edge for edge, sides in panels.edges().items() if len(sides) > 2]
        if many:
            x = panels.vertices[list(many[0])].mean(axis=0)
            raise InputError.single(
                f"body {name!r}: parts of the union touch along an edge only, {place(x)}",
                "let them overlap, or leave a gap",
            )
        checked(panels, name)
    except InputError as error:
        raise InputError([replace(p, keys=p.keys or keys) for p in error.problems]) from None
    vertices, triangles = opened(solid, [2])
    return panels.divided(finer), hydrostatics_of_triangles(vertices[triangles])


def _narrow_inside(name: str, body: Body, panels: Panels) -> Iterator[str]:
    """A warning of gaps between parts of a union that stand apart; InputError of narrow ones."""
    shells = panels.shells() if body.shape.union is not None else []
    for k, second in enumerate(shells):
        for first in shells[:k]:
            gap = narrowest_gap(first, second)
            if gap is None:
                continue
            text = f"the gap between parts of the union of body {name!r} {_wide(gap)}"
            if gap.width < NARROW * gap.side:
                remedy = "let the parts overlap, use more panels, or leave a wider gap"
                keys = ("bodies", name, "shape", "union")
                raise InputError.single(text, remedy, keys=keys)
            yield f"{text}: coefficients are inaccurate in short waves; use more panels"


def _immersed(panels: Panels, name: str) -> Panels:
    """The part below z = 0, without panels that lie in the still-water level."""
    reach = RELATIVE_TOLERANCE * panels.size
    low, high = panels.vertices[:, 2].min(), panels.vertices[:, 2].max()
    if low >= -reach:
        raise InputError.single(
            f"body {name!r}: the mesh is above the water (lowest point at z = {low:.4g} m)",
            "draw the mesh in the reference pose (z = 0 is the still-water level, Z points up), or "
            "say with mesh_origin: [x, z] where its origin lies",
        )
    if high > reach:
        capytaine = import_capytaine()
        mesh = capytaine.Mesh(panels.vertices, panels.faces, auto_check=False).immersed_part()
        panels = Panels(np.asarray(mesh.vertices), np.asarray(mesh.faces)).merged()
    vertices = panels.vertices.copy()
    vertices[np.abs(vertices[:, 2]) < reach, 2] = 0.0
    panels = Panels(vertices, panels.faces)
    return panels.selected(np.any(panels.corners[:, :, 2] < 0.0, axis=1))
