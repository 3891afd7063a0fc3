"""Unions of shapes as solids: Boolean operations by manifold3d, an optional library.

Round parts are drawn with many facets that have the exact volume of the shape, so that volumes and
hydrostatics of the union are those of the shapes to about 1e-4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.shapes import Box, Cylinder, Part, Revolved, Shape
from m4e_adapters.hydrodynamics.geometry.checks import check_as_drawn, check_edges, place
from m4e_adapters.hydrodynamics.geometry.lid import loops, waterline
from m4e_adapters.hydrodynamics.geometry.mesh_files import Keys, drawn_panels
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels, joined
from m4e_adapters.hydrodynamics.geometry.shapes import (
    Placed,
    horizontal_cylinder_panels,
    revolved_panels,
    shifted,
    sphere_panels,
    turned,
)
from m4e_fmi.errors import InputError, Problem

if TYPE_CHECKING:
    from manifold3d import Manifold as Solid

LIBRARIES = ("manifold3d", "mmgpy")  # of solids, and of even panels on them
AROUND, FACETS = 96, 3000  # of a round part: facets of a cylinder, of a ball, ring or tube
NOTHING = 1e-9  # of a volume
SYMMETRIC = 1e-6  # difference of a solid from its mirror image, over its volume


def library(name: str) -> ModuleType:
    """The module `name` of the optional libraries of unions; InputError without it."""
    try:
        return import_module(name)
    except ImportError:
        raise InputError.single(
            f"a union of shapes needs the library {name}",
            "install it: pip install 'm4e_fmi[unions]'; or mesh the union in a mesher",
        ) from None


def union_of(name: str, shape: Shape, center: Place, folder: Path, *, whole: bool) -> Solid:
    """The union of the parts of body `name` with this `center` of gravity [m].

    Cylinders and boxes without a freeboard, and meshes that are open at the waterline, end
    somewhere above the water; the `whole` of them is not known. InputError with all that is wrong
    with the parts, and for one that lies inside the others.
    """
    for needed in LIBRARIES:
        library(needed)
    solids: list[Solid] = []
    problems: list[Problem] = []
    for k, part in enumerate(shape.parts):
        keys = ("bodies", name, "shape", "union", k, part.kind)
        try:
            solids.append(_solid(name, part, center, folder, keys, whole))
        except InputError as error:
            problems += [replace(p, keys=p.keys or keys) for p in error.problems]
    InputError.raise_for(problems)
    for k, part in enumerate(shape.parts):
        others = _together(solids[:k] + solids[k + 1 :])
        if (solids[k] - others).volume() < NOTHING * solids[k].volume():
            raise InputError.single(
                f"body {name!r}: part {k + 1} of the union, a {part.kind}, lies inside the others",
                "remove it: it adds nothing to the hull",
                keys=("bodies", name, "shape", "union", k, part.kind),
            )
    return _together(solids)


def _together(solids: Sequence[Solid]) -> Solid:
    """The solids as one; those of overlapping or touching parts have one surface."""
    manifold = library("manifold3d")
    return manifold.Manifold.batch_boolean(list(solids), manifold.OpType.Add)


def is_symmetric(solid: Solid, axis: int) -> bool:
    """If the solid is its own mirror image in the plane x = 0 (axis 0) or y = 0 (axis 1)."""
    image = solid.mirror([1.0 * (k == axis) for k in range(3)])
    return (solid - image).volume() < SYMMETRIC * solid.volume()


def triangles_of(solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (nv, 3) [m] of a solid, and its triangles (nt, 3) of them, normals outwards."""
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=int)


def _solid(name: str, part: Part, center: Place, folder: Path, keys: Keys, whole: bool) -> Solid:
    """One part, closed, with its part above the water."""
    if part.mesh is None:
        return _solid_of(drawn_shape(part))
    drawn = drawn_panels(name, part, center, folder, keys=keys)
    check_as_drawn(drawn, name, scale=part.scale)

    def wrong(message: str, remedy: str) -> InputError:
        return InputError.single(f"body {name!r}: {message}", remedy, keys=keys)

    return _solid_of(_closed(drawn, wrong, whole), wrong)


def drawn_shape(part: Part) -> Panels:
    """The closed surface of a built-in shape; without a freeboard it ends above the water."""
    if part.cylinder is not None:
        shape = part.cylinder
        radii, heights = [shape.radius] * 2, [-shape.draft, _top(shape)]
        return _turned(radii, heights, part.cylinder)
    if part.revolved is not None and part.revolved.hole is not None:
        return whole_revolved(part.revolved, FACETS)
    if part.revolved is not None:
        radii, heights = map(list, zip(*part.revolved.profile, strict=True))
        return _turned(radii, heights, part.revolved)
    if part.box is not None:
        box, top = part.box, _top(part.box)  # six panels, which are exact
        x, y = 0.5 * box.length, 0.5 * box.width
        middle = np.array([box.center_x, box.center_y])
        ring = middle + np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
        corners = [np.column_stack([ring, np.full(4, z)]) for z in (-box.draft, top)]
        sides = [[k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4)]
        return Panels(np.concatenate(corners), np.array([[3, 2, 1, 0], [4, 5, 6, 7], *sides]))
    shape = getattr(part, part.kind)
    draw: Callable[..., Panels] = {
        "sphere": sphere_panels,
        "horizontal_cylinder": horizontal_cylinder_panels,
    }[part.kind]
    depth = 3.0 * (shape.radius + abs(shape.center_z))  # drawn where none of it is cut off
    lowered = shape.model_copy(update={"center_z": -depth})
    return raised(draw(lowered, FACETS), depth + shape.center_z)


def _top(shape: Cylinder | Box) -> float:
    """Height z [m] of the top."""
    if shape.top_z < 0.0:
        return shape.top_z
    return shape.draft if shape.freeboard is None else shape.freeboard


def _turned(radii: list[float], heights: list[float], shape: Placed) -> Panels:
    r, z = np.array([0.0, *radii, 0.0]), np.array([heights[0], *heights, heights[-1]])
    squares = r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2
    volume = math.pi / 3 * float(np.diff(z) @ squares)
    kept = np.concatenate([[True], (np.diff(r) != 0) | (np.diff(z) != 0)])
    return shifted(turned(r[kept], z[kept], AROUND, volume, pivot=heights[0]), shape)


def whole_revolved(shape: Revolved, count: int) -> Panels:
    """The closed surface of a body of revolution, of about `count` panels.

    It is drawn below the water, where none of it is cut off, and lifted.
    """
    depth = shape.profile[-1][1] + 1.0
    profile = tuple((radius, z - depth) for radius, z in shape.profile)
    return raised(revolved_panels(shape.model_copy(update={"profile": profile}), count), depth)


def raised(panels: Panels, height: float) -> Panels:
    """The surface, higher by `height` [m]."""
    return Panels(panels.vertices + np.array([0.0, 0.0, height]), panels.faces)


def _closed(panels: Panels, wrong: Callable[[str, str], InputError], whole: bool) -> Panels:
    """A mesh with walls and a top above the water, if it is open at the waterline.

    The error that `wrong` makes where it is open elsewhere, or if the `whole` must be known.
    """
    rim = waterline(panels)
    if not rim:
        check_edges(panels, wrong)
        return panels
    reach = RELATIVE_TOLERANCE * panels.size
    edges = np.array(rim)
    aside = np.abs(panels.vertices[edges, 2]).max(axis=1) > reach
    if aside.any():
        x = panels.vertices[edges[aside][0]].mean(axis=0)
        raise wrong(
            f"the mesh is not watertight: {int(aside.sum())} edges belong to one panel only, the "
            f"first {place(x)}",
            "close the holes (only the waterline may be open), or join panels that do not share "
            "their vertices",
        )
    if whole:
        raise wrong(
            "the mesh is open at the waterline: it has no part above the water",
            "mesh the whole part up to the deck, closed, not only what is below the water",
        )
    check_edges(panels, wrong)
    return _with_freeboard(panels, rim)


def _with_freeboard(panels: Panels, rim: list[tuple[int, int]]) -> Panels:
    """Walls as high as the mesh is long on its waterline, and lids."""
    height, parts = panels.size, [panels]
    for loop in loops(rim):
        line = panels.vertices[loop] * np.array([1.0, 1.0, 0.0])
        upper = line + np.array([0.0, 0.0, height])
        n = len(loop)
        k, following = np.arange(n), (np.arange(n) + 1) % n
        walls = np.stack([following, k, k + n, following + n], axis=1)
        top = np.stack([following + n, k + n, np.full(n, 2 * n), np.full(n, 2 * n)], axis=1)
        points = np.concatenate([line, upper, upper.mean(axis=0, keepdims=True)])
        parts.append(Panels(points, np.concatenate([walls, top])))
    return joined(*parts)


def _solid_of(panels: Panels, wrong: Callable[[str, str], InputError] | None = None) -> Solid:
    manifold = library("manifold3d")
    mesh = manifold.Mesh64(
        vert_properties=np.ascontiguousarray(panels.vertices, dtype=np.float64),
        tri_verts=np.ascontiguousarray(panels.triangle_faces, dtype=np.uint64),
    )
    solid = manifold.Manifold(mesh)
    if wrong is not None and solid.volume() <= 0.0:
        raise wrong(
            "the mesh is inverted: the normals point into the body",
            "reverse the order of the vertices of every panel: normals point into the water",
        )
    return solid
