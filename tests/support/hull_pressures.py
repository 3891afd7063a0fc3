"""Loads of the pressure on hulls, from their configuration."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.pressure.closed_hull import closed_hulls
from m4e_adapters.hydrodynamics.pressure.config import HullPressureConfig
from m4e_adapters.hydrodynamics.pressure.hull_load import HullLoad, IncidentWaves
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import wave_data

RHO, G = 1025.0, 9.81


def surface(body: dict) -> Panels:
    """The closed hull of a body, in space, or in the plane where its places are."""
    return closed_hulls(_config(body), Path())["hull"]


def hull_load(body: dict, **sections) -> HullLoad:
    """The load on a body; `sections` of the configuration besides."""
    config = _config(body, **sections)
    center = config.bodies["hull"].center_of_gravity
    hull = closed_hulls(config, Path())["hull"]
    vertices, triangles = hull.vertices - np.array(point_in_space(center)), hull.triangle_faces
    water = config.water
    data = wave_data(wave_systems(config.waves, depth=water.depth, gravity=water.gravity))
    return HullLoad(
        vertices.tolist(),
        triangles.tolist(),
        weight=config.water.density * config.water.gravity,
        waves=IncidentWaves(data) if data else None,
    )


def _config(body: dict, **sections) -> HullPressureConfig:
    dimensions = len(body["center_of_gravity"])
    return HullPressureConfig.model_validate(
        {"dimensions": dimensions, "bodies": {"hull": body}, **sections}
    )
