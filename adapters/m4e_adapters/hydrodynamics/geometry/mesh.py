"""Hulls: the wetted surface of every body, checked, with a lid on its inner free surface.

The lid is a flat surface of panels on the water inside the hull: it removes the irregular
frequencies of the integral equation, at which its solution is otherwise wrong by tens of percent.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import Body, HydrodynamicsConfig, Shape
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine, kept_warnings
from m4e_adapters.hydrodynamics.geometry.clearance import narrowest_gap, overlap
from m4e_adapters.hydrodynamics.geometry.hydrostatics import Hydrostatics, hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh_files import FORMATS, read_mesh
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels, grid
from m4e_adapters.hydrodynamics.geometry.shapes import (
    box_panels,
    cylinder_panels,
    revolved_panels,
    sphere_hydrostatics,
    sphere_panels,
)
from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.model.shapes.mesh_files import MeshFileError

Keys = tuple[str | int, ...]
"""The way to a value in a HydrodynamicsConfig."""
LID_TRIALS = (1.0, 0.8, 0.6, 1.3)  # panel sizes tried, relative to the hull's
SHALLOW = 0.15  # overlap, over a panel's side, that the flat panels of round bodies may make
NARROW = 0.25  # gap over the side of a panel below which the flow in it is of no use


@dataclass(frozen=True)
class Hull:
    """A body's wetted surface and lid (None: none needed, or none possible).

    Motions are about `center` G: (x, z) [m] in the plane, (x, y, z) in space. `axis` (x, y) [m] is
    the upright axis of a body of revolution, about which it turns without moving the water.
    """

    name: str
    panels: Panels
    lid: Panels | None
    center: tuple[float, ...]
    hydrostatics: Hydrostatics
    axis: tuple[float, float] | None = None


def make_hulls(
    config: HydrodynamicsConfig, folder: Path, *, progress: Callable[[str], object]
) -> tuple[Hull, ...]:
    """The hulls of all bodies in the order of the file; InputError with all problems."""
    hulls, problems = hulls_and_problems(config, folder, progress=progress)
    if problems:
        raise InputError(problems)
    return tuple(hulls)


def hulls_and_problems(
    config: HydrodynamicsConfig, folder: Path, *, progress: Callable[[str], object]
) -> tuple[list[Hull], list[Problem]]:
    """The hulls of those bodies that can have one, and the problems of all."""
    hulls, problems = [], []
    for name, body in config.bodies.items():
        try:
            hull = make_hull(name, body, folder, progress=progress)
        except InputError as error:
            problems += error.problems
            continue
        hulls.append(hull)
        lowest = hull.panels.vertices[:, 2].min()
        if lowest <= -config.water.depth:
            problems.append(
                Problem(
                    f"body {name!r} reaches down to z = {lowest:.4g} m, the sea bed is at "
                    f"z = {-config.water.depth:.4g} m",
                    "give more water.depth, or less draft",
                    keys=("bodies", name, "shape", body.shape.kind),
                )
            )
    for k, second in enumerate(hulls):
        keys = ("bodies", second.name, "shape", config.bodies[second.name].shape.kind)
        near = (found for first in hulls[:k] if (found := _too_near(first, second, progress)))
        if (found := next(near, None)) is not None:
            problems.append(Problem(*found, keys=keys))
    return hulls, problems


def _too_near(
    first: Hull, second: Hull, progress: Callable[[str], object]
) -> tuple[str, str] | None:
    """Message and remedy of bodies that overlap, or nearly touch; of other narrow gaps a warning.

    Panels see a gap as a wall where it is much narrower than they are: their damping is then
    negative, by several times its largest value in gaps of a fifth of a side.
    """
    names = f"bodies {first.name!r} and {second.name!r}"
    point = overlap(first.panels, second.panels, inwards=SHALLOW)
    if point is not None:
        remedy = "move one of them (center_x, or mesh_origin of a mesh), or make one body of both"
        return f"{names} overlap {_place(point)}", remedy
    point = overlap(first.panels, second.panels)
    if point is not None:
        text = f"the gap between {names} is too narrow for their panels to resolve {_place(point)}"
        return text, "use more panels (a finer mesh) where the bodies are round, or a wider gap"
    gap = narrowest_gap(first.panels, second.panels)
    if gap is None:
        return None
    text = (
        f"the gap between {names} is about {gap.width:.3g} m wide {_place(gap.middle)}, where "
        f"panels have sides of {gap.side:.3g} m"
    )
    remedy = "use more panels (a finer mesh), or a wider gap"
    if gap.width < NARROW * gap.side:
        return text, remedy
    progress(f"warning: {text}: coefficients are inaccurate there; {remedy}")
    return None


def _place(point: Sequence[float]) -> str:
    x, y, z = point
    return f"near x = {x:.4g}, y = {y:.4g}, z = {z:.4g} m"


def make_hull(
    name: str, body: Body, folder: Path, *, progress: Callable[[str], object] = print
) -> Hull:
    """The checked hull of one body; a lid that could not be made is told through `progress`."""
    with kept_warnings() as warnings:
        panels = _shape_panels(name, body.shape, body.panels, folder)
        lid = make_lid(panels)
    for text in warnings:
        progress(f"warning: capytaine: {text}")
    if lid is None and waterline(panels):
        progress(
            f"warning: no lid could be made inside body {name!r}: its coefficients may be wrong "
            "near irregular frequencies; limit frequencies.maximum, or make a finer mesh"
        )
    for text in _misplaced(name, body, panels):
        progress(f"warning: {text}")
    ball = body.shape.sphere
    hydrostatics = hydrostatics_of(panels) if ball is None else sphere_hydrostatics(ball)
    return Hull(name, panels, lid, body.center_of_gravity, hydrostatics, body.shape.axis)


def _misplaced(name: str, body: Body, panels: Panels) -> Iterator[str]:
    """A centre of gravity that is where no hull of this extent can have it."""
    world = body.shape.mesh is not None
    where = "a mesh is in world coordinates, unless mesh_origin: [x, z] moves it there"
    x, _, z = point_in_space(body.center_of_gravity)
    low, high = panels.vertices[:, 0].min(), panels.vertices[:, 0].max()
    keel = panels.vertices[:, 2].min()
    if not low <= x <= high:
        remedy = where if world else "give the shape a center_x"
        yield (
            f"the centre of gravity of body {name!r} (x = {x:.4g} m) is not above or below its "
            f"hull (x = {low:.4g} to {high:.4g} m): {remedy}"
        )
    if z < keel:
        remedy = where if world else "make center_of_gravity and the shape's draft agree"
        yield (
            f"the centre of gravity of body {name!r} (z = {z:.4g} m) is below its hull (lowest "
            f"point at z = {keel:.4g} m): {remedy}"
        )


def _shape_panels(name: str, shape: Shape, count: int, folder: Path) -> Panels:
    if shape.cylinder is not None:
        return cylinder_panels(shape.cylinder, count)
    if shape.sphere is not None:
        return sphere_panels(shape.sphere, count)
    if shape.box is not None:
        return box_panels(shape.box, count)
    if shape.revolved is not None:
        return revolved_panels(shape.revolved, count)
    drawn = drawn_mesh(name, shape, folder)
    try:
        return checked(_immersed(drawn, name), name)
    except InputError as error:
        file = str(folder / str(shape.mesh))
        keys = ("bodies", name, "shape", "mesh")
        raise InputError(replace(p, file=file, keys=keys) for p in error.problems) from None


def drawn_mesh(name: str, shape: Shape, folder: Path) -> Panels:
    """The panels of a mesh file in the reference pose, with those above the water."""
    drawn = _loaded(folder / str(shape.mesh), name, ("bodies", name, "shape", "mesh"))
    origin = point_in_space(shape.mesh_origin or (0.0, 0.0))
    return Panels(drawn.vertices + np.array(origin), drawn.faces)


def _loaded(path: Path, name: str, keys: Keys = ()) -> Panels:
    """The panels of a mesh file as they are drawn."""
    if not is_file(path):
        message, remedy = missing_file(path, "mesh file")
        message = f"body {name!r}: {message}"
        remedy = "; ".join(
            filter(None, ("the name is relative to the system file's folder", remedy))
        )
        raise InputError.single(message, remedy, keys=keys)
    try:
        panels = read_mesh(path)
    except (MeshFileError, OSError) as error:
        message = f"body {name!r}: the mesh cannot be read: {error}"
        raise InputError.single(message, FORMATS, str(path), keys=keys) from None
    if not len(panels.faces):
        message = f"body {name!r}: the mesh has no panels"
        raise InputError.single(message, FORMATS, str(path), keys=keys)
    return panels


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
    return panels.kept(np.any(panels.corners[:, :, 2] < 0.0, axis=1))


def checked(panels: Panels, name: str) -> Panels:
    """`panels` if they bound a volume below the waterline; InputError says where they do not."""

    def wrong(message: str, remedy: str) -> InputError:
        return InputError.single(f"body {name!r}: {message}", remedy)

    _check_edges(panels, wrong)
    shells = sorted(panels.shells(), key=lambda shell: abs(hydrostatics_of(shell).volume))
    outwards = [shell if hydrostatics_of(shell).volume > 0 else shell.reversed for shell in shells]
    for first, second in combinations(outwards, 2):
        if (point := overlap(first, second)) is not None:
            raise wrong(
                f"a closed shell is inside the hull {_place(point)}",
                "remove it: a hull is the surface that the water touches; join intersecting parts "
                "into one surface",
            )
    for shell, right in zip(shells, outwards, strict=True):
        if shell is not right:
            raise wrong(
                "the mesh is inverted: the normals point out of the water "
                f"{_place(shell.centers[0])}, the volume within is "
                f"{hydrostatics_of(shell).volume:.4g} m3",
                "reverse the order of the vertices of every panel there: normals point into the "
                "water",
            )
    return panels


def _check_edges(panels: Panels, wrong: Callable[[str, str], InputError]) -> None:
    """The error that `wrong` makes where an edge below the water is not one of two panels."""

    def place(edge: tuple[int, int]) -> str:
        return _place(panels.vertices[list(edge)].mean(axis=0))

    edges = panels.edges()
    height = panels.vertices[:, 2]
    unshared = [e for e, sides in edges.items() if len(sides) == 1 and min(height[list(e)]) < 0]
    if unshared:
        raise wrong(
            f"the mesh is not watertight: {len(unshared)} edges below the water belong to one "
            f"panel only, the first {place(unshared[0])}",
            "close the holes (only the waterline may be open), or join panels that do not share "
            "their vertices",
        )
    many = [edge for edge, sides in edges.items() if len(sides) > 2]
    if many:
        raise wrong(
            f"more than two panels meet in an edge {place(many[0])}",
            "remove inner walls and doubled panels",
        )
    twisted = [edge for edge, sides in edges.items() if len(sides) == 2 and sum(sides)]
    if twisted:
        raise wrong(
            f"neighbouring panels face opposite ways {place(twisted[0])}",
            "turn the panels so that all normals point into the water",
        )


def waterline(panels: Panels) -> list[tuple[int, int]]:
    """The open edges, as (from, to) vertices in the direction of their panel."""
    found = []
    for (low, high), sides in panels.edges().items():
        if len(sides) == 1:
            found.append((low, high) if sides[0] > 0 else (high, low))
    return found


def make_lid(panels: Panels) -> Panels | None:
    """Panels on the still water inside the hull, None if there is no waterline or no way.

    One waterline that is visible from its centre is filled with rings, which keeps the hull's
    symmetries; any other shape is left to Capytaine, whose generator can return nothing at all
    and is then asked again with another spacing.
    """
    loop = _single_loop(waterline(panels))
    if loop is not None:
        rings = _rings(panels.vertices[loop])
        if rings is not None:
            return rings
    if not waterline(panels):
        return None
    mesh = import_capytaine().Mesh(panels.vertices, panels.faces, auto_check=False)
    spacing = float(np.mean(mesh.faces_radiuses))
    for trial in LID_TRIALS:
        lid = mesh.generate_lid(faces_max_radius=trial * spacing)
        if lid.nb_faces > 0:
            return Panels(np.asarray(lid.vertices), np.asarray(lid.faces)).merged()
    return None


def _single_loop(edges: list[tuple[int, int]]) -> list[int] | None:
    """Vertices of the one closed line that `edges` make, None if it is not one."""
    following = dict(edges)
    if not edges or len(following) < len(edges):
        return None
    start = edges[0][0]
    loop, vertex = [start], following[start]
    while vertex != start and vertex in following and len(loop) <= len(edges):
        loop.append(vertex)
        vertex = following[vertex]
    return loop if len(loop) == len(edges) and vertex == start else None


def _rings(line: np.ndarray) -> Panels | None:
    """Rings of panels inside a closed line (n, 3) about its centre, normals down.

    None if some part of the line is not visible from there.
    """
    following = np.roll(line, -1, axis=0)
    doubled = line[:, 0] * following[:, 1] - line[:, 1] * following[:, 0]
    center = ((line + following) * doubled[:, None]).sum(axis=0) / (3 * doubled.sum())
    spokes = line - center
    turns = spokes[:, 0] * np.roll(spokes, -1, axis=0)[:, 1]
    turns -= spokes[:, 1] * np.roll(spokes, -1, axis=0)[:, 0]
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return None
    edge = np.linalg.norm(following - line, axis=1).mean()
    count = max(2, math.ceil(np.linalg.norm(spokes, axis=1).mean() / (2.0 * edge)))
    closed = np.concatenate([spokes, spokes[:1]])
    if turns[0] < 0:
        closed = closed[::-1]
    fractions = np.linspace(0.0, 1.0, count + 1)
    return grid(center + fractions[None, :, None] * closed[:, None, :]).merged()
