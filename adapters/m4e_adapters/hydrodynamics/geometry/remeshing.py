"""Surfaces of solids as even triangles: by Mmg (mmgpy), an optional library.

Boolean operations leave slivers where surfaces meet, with side² over area in the thousands. Mmg
makes a surface of triangles of one size of the same shape, with its edges. A solid that is its own
mirror image in x = 0 or y = 0 is meshed in half or in quarters, which are then mirrored.

Triangles with their corners on a curved surface enclose too little. All vertices are therefore
moved outwards by a share of their distance from the middle of their neighbours, which grows with
the curvature and vanishes where the surface is flat: the volume is then exact, and the forces
converge with a smaller constant.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels, joined
from m4e_adapters.hydrodynamics.geometry.solids import is_symmetric, library, triangles_of
from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from manifold3d import Manifold as Solid

RIDGE = 40.0  # deg between triangles that meet in an edge of the shape
FLATNESS = 0.1  # distance of a triangle from a curved surface, over its side
PASSES = 2  # the second makes the triangles more even
TRIALS, NEAR = 8, 0.1  # to come so near to the number of panels, or to an even surface
FINER = 0.85  # sides of the next trial, where a surface is not even
MOST_LACKING, THINNEST = 0.025, 30.0  # volume that even triangles lack; side² over area
ALONG_EDGES = 2.0 / 3.0  # share of a curve's distance, over that of a surface, that it lacks
MOST_OUTWARDS = 0.5  # share of the distance from the middle of the neighbours; 1/4 is usual


def even_panels(solid: Solid, count: int, name: str, *, wetted: bool) -> Panels:
    """About `count` triangles on the surface of a solid, open at z = 0 if it is `wetted`.

    A wetted solid ends at z = 0. There are more triangles where fewer cannot follow its surface.
    InputError if no even surface is found on the body of that `name`.
    """
    planes = [axis for axis in (0, 1) if is_symmetric(solid, axis)]
    piece = solid
    for axis in planes:
        piece = piece.trim_by_plane([1.0 * (k == axis) for k in range(3)], 0.0)
    cut = [*planes, *([2] if wetted else [])]
    vertices, triangles = opened(piece, cut)
    found = _even(vertices, triangles, count / 2 ** len(planes), piece.volume())
    if found is None:
        raise InputError.single(
            f"body {name!r}: no even panels were found on the union of shapes with about {count} "
            "panels",
            "use more panels, or avoid parts that nearly touch, or overlap by little",
            keys=("bodies", name, "shape", "union"),
        )
    points, faces = found
    panels = Panels(_snapped(points, faces, cut), np.column_stack([faces, faces[:, 2]])).merged()
    for axis in planes:
        panels = joined(panels, panels.mirrored(axis))
    return _filled(panels, float(solid.volume()))


def _even(
    vertices: np.ndarray, triangles: np.ndarray, wanted: float, volume: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """About `wanted` even triangles (nt, 3) of vertices (nv, 3) [m] on a surface around `volume`.

    In m3, with the parts of planes through the origin that close it. None if none are found.
    """
    edge = 1.1 * math.sqrt(4.0 / math.sqrt(3.0) * _areas(vertices[triangles]).sum() / wanted)
    best, most, longest = None, math.inf, math.inf
    for _ in range(TRIALS):
        found = _remeshed(vertices, triangles, edge)
        corners = found[0][found[1]]
        enclosed = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        ratio = len(corners) / wanted
        if abs(enclosed / volume - 1.0) > MOST_LACKING or thinness(corners) > THINNEST:
            longest = FINER * edge
            edge = min(longest, edge * math.sqrt(ratio))
            continue
        if abs(math.log(ratio)) < most:
            best, most = found, abs(math.log(ratio))
        following = min(longest, edge * math.sqrt(ratio))
        if most < NEAR or abs(math.log(following / edge)) < 0.25 * NEAR:
            break
        edge = following
    return best


def opened(solid: Solid, planes: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (nv, 3) [m] and triangles (nt, 3) of a solid, without those in these planes."""
    vertices, triangles = triangles_of(solid)
    reach = 1e-9 * float(np.ptp(vertices, axis=0).max())
    for axis in planes:
        inside = np.all(np.abs(vertices[triangles][:, :, axis]) < reach, axis=1)
        triangles = triangles[~inside]
    used, places = np.unique(triangles, return_inverse=True)
    return vertices[used], places.reshape(-1, 3)


def _remeshed(
    vertices: np.ndarray, triangles: np.ndarray, edge: float
) -> tuple[np.ndarray, np.ndarray]:
    """The same surface with triangles of sides of about `edge` [m]: (nv, 3) [m], (nt, 3)."""
    for _ in range(PASSES):
        mesh = library("mmgpy").MmgMeshS(vertices, triangles.astype(np.int32))
        mesh.remesh(hsiz=edge, hausd=FLATNESS * edge, ar=RIDGE, verbose=-1)
        vertices = np.asarray(mesh.get_vertices())
        triangles = np.asarray(mesh.get_triangles(), dtype=int)
    return vertices, triangles


def _snapped(vertices: np.ndarray, triangles: np.ndarray, planes: list[int]) -> np.ndarray:
    """The vertices (nv, 3) [m], those of open edges exactly in the planes where they are cut."""
    result = vertices.copy()
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, counts = np.unique(pairs, axis=0, return_counts=True)
    rim = edges[counts == 1]
    if len(rim):
        away = np.abs(vertices[rim][:, :, planes]).max(axis=1)
        nearest = np.array(planes)[np.argmin(away, axis=1)]
        result[rim, nearest[:, None]] = 0.0
    return result


def _areas(triangles: np.ndarray) -> np.ndarray:
    """Areas (nt,) [m2] of triangles (nt, 3, 3) [m]."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def thinness(triangles: np.ndarray) -> float:
    """The largest side² over area [1] of triangles (nt, 3, 3) [m]; 2.3 of equal sides."""
    sides = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
    return float((sides.max(axis=1) ** 2 / np.maximum(_areas(triangles), 1e-300)).max())


def _filled(panels: Panels, volume: float) -> Panels:
    """The surface with its vertices moved outwards until it encloses that `volume` [m3]."""
    outwards = _outwards(panels)

    def moved(share: float) -> Panels:
        return Panels(panels.vertices + share * outwards, panels.faces)

    def lacking(share: float) -> float:
        return volume - hydrostatics_of(moved(share)).volume

    low, high = 0.0, 0.25
    first, second = lacking(low), lacking(high)
    if abs(first) < RELATIVE_TOLERANCE * volume:
        return panels
    for _ in range(8):
        if first == second:
            break
        low, high = high, high - second * (high - low) / (second - first)
        first, second = second, lacking(high)
        if abs(second) < 1e-12 * volume:
            break
    return moved(high) if 0.0 < high < MOST_OUTWARDS else panels


def _outwards(panels: Panels) -> np.ndarray:
    """From the middle of the neighbours to each vertex, (nv, 3) [m], off the surface only.

    On an edge of the shape, from the middle of its two neighbours on that edge, less for a curve;
    0 at corners.
    """
    corners = panels.vertices[panels.faces[:, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    units = normals / np.linalg.norm(normals, axis=1)[:, None]
    count = len(panels.vertices)
    sides: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(panels.faces[:, :3].tolist()):
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            sides.setdefault((min(a, b), max(a, b)), []).append(number)
    limit = math.cos(math.radians(RIDGE))
    sharp: list[list[int]] = [[] for _ in range(count)]
    near: list[list[int]] = [[] for _ in range(count)]
    for (a, b), faces in sides.items():
        near[a].append(b)
        near[b].append(a)
        if len(faces) != 2 or units[faces[0]] @ units[faces[1]] < limit:
            sharp[a].append(b)
            sharp[b].append(a)
    at_vertex = np.zeros((count, 3))
    for k in range(3):
        np.add.at(at_vertex, panels.faces[:, k], normals)
    result = np.zeros((count, 3))
    for v, point in enumerate(panels.vertices):
        if not sharp[v]:
            normal = at_vertex[v] / np.linalg.norm(at_vertex[v])
            result[v] = ((point - panels.vertices[near[v]].mean(axis=0)) @ normal) * normal
        elif len(sharp[v]) == 2:
            one, other = panels.vertices[sharp[v]]
            along = (other - one) / np.linalg.norm(other - one)
            apart = point - 0.5 * (one + other)
            before, after = point - one, other - point
            lengths = float(np.linalg.norm(before) * np.linalg.norm(after))
            goes_on = float(before @ after) > limit * lengths  # but for a curve
            if before @ along > 0.0 > (point - other) @ along and goes_on:
                result[v] = ALONG_EDGES * (apart - (apart @ along) * along)
    return result
