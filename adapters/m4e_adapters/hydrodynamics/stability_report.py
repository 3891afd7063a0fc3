"""Hydrostatics and stability of the configured bodies, as text.

Inertia of bodies with the shape of a hull: a homogeneous solid, and a shell of one thickness.

With a point p of the body, its mean C = <p pᵀ> about the centre of gravity gives I = m (tr C − C).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.geometry.hydrostatics import Hydrostatics
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hulls
from m4e_adapters.hydrodynamics.geometry.mesh_files import drawn_panels
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels
from m4e_adapters.hydrodynamics.geometry.solids import (
    drawn_shape,
    triangles_of,
    union_of,
)
from m4e_adapters.hydrodynamics.geometry.stability import HEEL, PITCH, Curve, WholeHull
from m4e_fmi.errors import InputError


def solid_inertia(triangles: np.ndarray, center: Sequence[float]) -> np.ndarray:
    """Tensor (3, 3) over the mass [m2] about `center` [m] of the solid within a surface.

    Its `triangles` (n, 3, 3) [m] may be open at z = 0.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    return _tensor(triangles, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, 4, center)


def shell_inertia(triangles: np.ndarray, center: Sequence[float]) -> np.ndarray:
    """Tensor (3, 3) over the mass [m2] about `center` [m] of `triangles` (n, 3, 3) [m]."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return _tensor(triangles, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1), 3, center)


def _tensor(
    triangles: np.ndarray, sizes: np.ndarray, corners: int, center: Sequence[float]
) -> np.ndarray:
    """Of simplices of these `sizes` (n,) [m2 or m3], with a fourth of their corners at 0."""
    total, sums = sizes.sum(), triangles.sum(axis=1)
    mean = sizes @ sums / (corners * total)
    squares = np.einsum("n,nki,nkj->ij", sizes, triangles, triangles)
    squares += np.einsum("n,ni,nj->ij", sizes, sums, sums)
    squares /= corners * (corners + 1) * total
    g = np.array(center)
    spread = squares - np.outer(g, mean) - np.outer(mean, g) + np.outer(g, g)
    return np.trace(spread) * np.eye(3) - spread


ANGLES = (0, 5, 10, 15, 20, 25, 30, 35, 40, 50, 60, 75, 90)
"""Of the table of righting arms [deg]."""
PRODUCTS = 1e-4
"""Of the largest moment of inertia, below which products are not shown."""


@dataclass(frozen=True)
class Stability:
    """A body in still water: `hydrostatics` in the reference pose, righting arms at any angle.

    `inertias` are tensors (3, 3) about the centre of gravity over the mass [m2], of a homogeneous
    solid and of a shell of one thickness. `curves` are by turn, heel and pitch, without one about
    the other axis; none if the part above the water is not known.
    """

    name: str
    center: tuple[float, float, float]
    hydrostatics: Hydrostatics
    inertias: dict[str, np.ndarray]
    curves: dict[str, Curve]


def stability_of(config: HydrodynamicsConfig, folder: Path) -> list[Stability]:
    """Stability of all bodies that move.

    InputError for meshes that do not bound a volume in the water.
    """
    hulls = make_hulls(config, folder, progress=lambda _: None)
    return [_stability(hull, _whole(hull, config, folder)) for hull in hulls if not hull.fixed]


def _whole(hull: Hull, config: HydrodynamicsConfig, folder: Path) -> Panels | None:
    """The hull with its part above the water, None if that is not known."""
    body = config.bodies[hull.name]
    shape, center = body.shape, body.center_of_gravity
    if shape.mesh is not None:
        drawn = drawn_panels(hull.name, shape, center, folder)
        dry = float(drawn.vertices[:, 2].max()) > RELATIVE_TOLERANCE * drawn.size
        submerged = float(hull.panels.vertices[:, 2].max()) < 0.0
        return drawn if dry or submerged else None
    ends = (part.cylinder or part.box for part in shape.parts)
    if any(end is not None and end.freeboard is None and end.top_z == 0.0 for end in ends):
        return None
    if shape.union is None:
        return drawn_shape(shape)
    try:
        solid = union_of(hull.name, shape, center, folder, whole=True)
    except InputError:  # a mesh that is open at the waterline: the wetted hull has been made
        return None
    vertices, triangles = triangles_of(solid)
    return Panels(vertices, np.column_stack([triangles, triangles[:, 2]]))


def _stability(hull: Hull, whole: Panels | None) -> Stability:
    center = point_in_space(hull.center)
    surface = (whole or hull.closed).triangles
    part = "" if whole is not None else ", below the water"
    inertias = {
        f"homogeneous solid{part}": solid_inertia(surface, center),
        f"shell of one thickness{part}": shell_inertia(surface, center),
    }
    if whole is None or float(hull.panels.vertices[:, 2].max()) < 0.0:
        return Stability(hull.name, center, hull.hydrostatics, inertias, {})
    afloat = WholeHull(whole, center, hull.hydrostatics.volume)
    angles = np.radians(ANGLES).tolist()
    curves = {about: afloat.arms(angles, about=about) for about in (HEEL, PITCH)}
    return Stability(hull.name, center, hull.hydrostatics, inertias, curves)


def stability_text(config: HydrodynamicsConfig, *, folder: Path) -> str:
    """Hydrostatics and righting arms of all bodies: a table for each; InputError as above."""
    found = stability_of(config, folder)
    return "\n\n".join("\n".join(_lines(one, config.water)) for one in found)


def _lines(one: Stability, water: Water) -> Iterator[str]:
    yield f"body {one.name}, in the reference pose:"
    for name, values, unit in _hydrostatic_rows(one, water):
        yield f"  {name:<44}" + "".join(f" {round(v, 9) + 0.0:12.6g}" for v in values) + f"  {unit}"
    if one.inertias:
        yield "  moments of inertia of that mass about x, y, z through G:"
    for shape, tensor in one.inertias.items():
        scaled = water.density * one.hydrostatics.volume * tensor
        moments = scaled.diagonal()
        cells = "".join(f" {v:12.6g}" for v in moments)
        yield f"    {shape:<42}{cells}  kg.m2"
        xy, yz, zx = scaled[[0, 1, 2], [1, 2, 0]]
        if max(map(abs, (xy, yz, zx))) > PRODUCTS * moments.max():
            yield f"    {'  with I_xy, I_yz, I_zx':<42} {xy:12.6g} {yz:12.6g} {zx:12.6g}  kg.m2"
    yield from _righting_lines(one)


def _hydrostatic_rows(one: Stability, water: Water) -> Sequence[tuple[str, Sequence[float], str]]:
    """Names, values and units of the hydrostatics of a hull."""
    known = one.hydrostatics
    area, along, _ = known.waterplane
    rows: list[tuple[str, Sequence[float], str]] = [
        ("displaced volume", (known.volume,), "m3"),
        ("mass of the displaced water", (water.density * known.volume,), "kg"),
        ("centre of gravity x, y, z", one.center, "m"),
        ("centre of buoyancy x, y, z", known.center_of_buoyancy, "m"),
        ("waterplane", (area,), "m2"),
    ]
    if area > 0.0:
        rows.append(("its centre x, y", (along / area, known.across[0] / area), "m"))
    heights = (
        known.transverse_metacentric_height(one.center),
        known.metacentric_height(one.center),
    )
    above = known.center_of_buoyancy[2] - one.center[2]
    return [
        *rows,
        ("metacentre above B, in heel and pitch (BM)", [h - above for h in heights], "m"),
        ("metacentre above G, in heel and pitch (GM)", heights, "m"),
    ]


def _righting_lines(one: Stability) -> Iterator[str]:
    """Righting arms, or why they are not known."""
    if not one.curves and one.hydrostatics.waterplane[0] == 0.0:
        yield (
            "  righting arms: all of the hull is under water, in balance at any depth: the arm is "
            "GM times the sine of the angle"
        )
        return
    if not one.curves:
        yield (
            "  righting arms: the part above the water is not known; give a box or a cylinder a "
            "freeboard, or a mesh that reaches above the water"
        )
        return
    yield "  righting arms GZ [m] at constant displacement, no turn about the other axis:"
    yield f"    {'angle [deg]':>12} {'heel':>12} {'pitch':>12}"
    for k, angle in enumerate(ANGLES):
        cells = [_plain(c.arms[k]) if k < len(c.arms) else "-" for c in one.curves.values()]
        yield f"    {angle:12g}" + "".join(f" {cell:>12}" for cell in cells)
    for about, curve in one.curves.items():
        yield f"  {about}: {_limits(curve)}"


def _plain(value: float) -> str:
    return f"{round(value, 6) + 0.0:.5g}"


def _limits(curve: Curve) -> str:
    """The largest arm, and the angles at which arms end."""
    best = int(np.argmax(curve.arms))
    told = [
        f"largest arm {_plain(curve.arms[best])} m at {math.degrees(curve.angles[best]):.3g} deg"
    ]
    ends = np.flatnonzero((curve.arms[1:] <= 0.0) & (curve.arms[:-1] > 0.0))
    if len(ends):
        k = int(ends[0])
        part = curve.arms[k] / (curve.arms[k] - curve.arms[k + 1])
        angle = curve.angles[k] + part * (curve.angles[k + 1] - curve.angles[k])
        told.append(f"none left at about {math.degrees(angle):.3g} deg")
    if math.isfinite(curve.flooded):
        told.append(f"water enters before {math.degrees(curve.flooded):.3g} deg")
    return ", ".join(told)
