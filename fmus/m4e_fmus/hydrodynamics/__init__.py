"""FMU of linear hydrodynamics: `kind: hydrodynamics`. Equations and variables: README.md here."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.build import check_config, program_from_config, program_in_waves
from m4e_adapters.hydrodynamics.coefficient_files.report import config_of_file, hydrodynamic_data
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.refinement import refinement
from m4e_adapters.hydrodynamics.seas.shown_water import shown_sea
from m4e_fmi.report.animation.shown import Shown, ShownHull
from m4e_fmus.water import kind_in_water


def _scene(config: HydrodynamicsConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """Hulls, water and bed for `values` of parameters at the start; files are in `folder`.

    InputError for files that cannot be read.
    """
    heading = values.get("heading", math.radians(config.heading))
    hulls = tuple(_headed(config, hull, heading) for hull in drawn_hulls(config.bodies, folder))
    return shown_sea(config.water, config.waves, folder=folder, values=values, hulls=hulls)


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


def _refinement(
    config: HydrodynamicsConfig, *, folder: Path, progress: Callable[[str], object] = print
) -> tuple[str, dict[str, object]]:
    """A convergence study of the coefficients, as text and as JSON, tables in SI.

    InputError for coefficients of a file.
    """
    study = refinement(config, folder=folder, progress=progress)
    limit = study.limit
    return str(study), {
        "panels": list(study.panels),
        "highest_frequency": study.highest,
        "rows": list(study.rows()),
        "motions": list(limit.motions),
        "omega": limit.omega.tolist(),
        "added_mass": limit.added_mass.tolist(),
        "radiation_damping": limit.radiation_damping.tolist(),
        "added_mass_inf": limit.added_mass_inf.tolist(),
        "excitation_real": np.real(limit.excitation).tolist(),
        "excitation_imaginary": np.imag(limit.excitation).tolist(),
    }


KIND = kind_in_water(
    HydrodynamicsConfig,
    build=program_from_config,
    takes_long=True,
    outline=check_config,
    scene=_scene,
    response=program_in_waves,
    coefficients=hydrodynamic_data,
    config_of_file=config_of_file,
    refinement=_refinement,
)
