"""Bodies in water as animations show them: their hulls, and the sea."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.seas.shown_water import floor_of, shown_water
from m4e_fmi.report.animation.shown import Shown, ShownHull


def shown(config: HydrodynamicsConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """Hulls, water and bed for `values` of parameters at the start; files are in `folder`.

    InputError for files that cannot be read.
    """
    heading = values.get("heading", math.radians(config.heading))
    return Shown(
        hulls=tuple(_headed(config, hull, heading) for hull in drawn_hulls(config.bodies, folder)),
        water=shown_water(config.water, config.waves, folder=folder, values=values),
        floor=floor_of(config.water),
    )


def _headed(config: HydrodynamicsConfig, hull: ShownHull, heading: float) -> ShownHull:
    """A fixed hull turned with all others, about the middle of the centres of gravity."""
    if not hull.fixed or not heading:
        return hull
    moving = [body.center_of_gravity for body in config.bodies.values() if not body.fixed]
    middle = np.array([point_in_space(center) for center in moving]).mean(axis=0)
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    surface = hull.surface
    turned = replace(surface, vertices=middle + (surface.vertices - middle) @ turn.T)
    return replace(hull, surface=turned)
