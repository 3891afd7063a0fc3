"""Members as cylinders in animations and pictures, on their bodies or fixed, and the sea."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.seas.shown_water import shown_sea
from m4e_adapters.morison.config import FIXED, Member, MorisonConfig
from m4e_fmi.report.animation.shown import Shown, ShownHull
from m4e_fmi.report.drawing.hulls import Hull, turned_hull


def shown(config: MorisonConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """Members, water and bed for `values` of parameters at the start; files are in `folder`."""
    hulls = [
        ShownHull(name, _cylinders(config.of_body(name).values(), body.center_of_gravity))
        for name, body in config.bodies.items()
    ]
    if fixed := config.of_body(None):
        hulls.append(ShownHull(FIXED, _cylinders(fixed.values(), (0.0, 0.0)), fixed=True))
    return shown_sea(config.water, config.waves, folder=folder, values=values, hulls=tuple(hulls))


def _cylinders(members: Iterable[Member], center: tuple[float, ...]) -> Hull:
    """The surfaces of members together, from a `center` [m] on."""
    first, vertices, faces = 0, list[np.ndarray](), list[tuple[int, ...]]()
    for member in members:
        low, high = (np.array(point_in_space(end)) for end in member.ends)
        along = (high - low) / member.length
        rims = np.array([[0.5 * member.diameter, s * member.length / 2] for s in (-1, 1)])
        one = turned_hull(
            rims,
            0.5 * (low + high) - point_in_space(center),
            (float(along[0]), float(along[1]), float(along[2])),
        )
        faces += [tuple(first + k for k in face) for face in one.faces]
        vertices.append(one.vertices)
        first += len(one.vertices)
    return Hull(np.concatenate(vertices), tuple(faces), edged=False)
