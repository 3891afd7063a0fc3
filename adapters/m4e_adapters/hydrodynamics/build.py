"""From a configuration to a Program: hulls, potential flow, load."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.bem import solve_hulls
from m4e_adapters.hydrodynamics.coefficients import MEMORY_REACH, Coefficients, memory_size
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Still
from m4e_adapters.hydrodynamics.load import hydrodynamics_program
from m4e_adapters.hydrodynamics.mesh import Hull, make_hulls
from m4e_adapters.hydrodynamics.sea import highest_frequency
from m4e_adapters.hydrodynamics.waves import angular_frequency
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program

SHALLOWEST = 0.2  # wavenumber times depth below which Capytaine has no accurate Green function


def coefficients_from_config(
    config: HydrodynamicsConfig, *, folder: Path, progress: Callable[[str], object] = print
) -> Coefficients:
    """Coefficients of the configured bodies; from the cache if they were computed before.

    Raises InputError for meshes that do not bound a volume in the water.
    """
    hulls = make_hulls(config, folder, progress=progress)
    direction = 0.0 if isinstance(config.waves, Still) else config.waves.direction
    return solve_hulls(
        hulls,
        water=config.water,
        omega=frequency_table(config, hulls),
        wave_direction=direction,
        progress=progress,
    )


def program_from_config(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured load as a Program (see `load`)."""
    return hydrodynamics_program(
        coefficients_from_config(config, folder=folder, progress=progress),
        name=name,
        waves=config.waves,
        drag={body: section.drag for body, section in config.bodies.items()},
        radiation=config.radiation,
        progress=progress,
    )


def frequency_table(config: HydrodynamicsConfig, hulls: Sequence[Hull]) -> np.ndarray:
    """Angular frequencies [rad/s] for the potential flow, as `Frequencies` says."""
    wanted, water = config.frequencies, config.water
    sea = highest_frequency(config.waves)
    maximum = wanted.maximum
    if maximum is None:
        sizes = [memory_size(h.hydrostatics.volume, h.hydrostatics.waterplane[0]) for h in hulls]
        maximum = max(math.sqrt(MEMORY_REACH * water.gravity / min(sizes)), sea)
    lowest = float(
        angular_frequency(SHALLOWEST / water.depth, depth=water.depth, gravity=water.gravity)
    )
    minimum = wanted.minimum or max(maximum / wanted.count, lowest)
    problem = remedy = ""
    if minimum < lowest:
        problem = f"frequencies.minimum {minimum:.4g} rad/s is too low for this water depth"
        remedy = f"use {lowest:.4g} rad/s or more"
    elif minimum >= maximum:
        problem = f"the frequencies from {minimum:.4g} to {maximum:.4g} rad/s are no range"
        remedy = "give frequencies.maximum above frequencies.minimum"
    elif sea > maximum * (1 + 1e-9):
        problem = f"the waves reach {sea:.4g} rad/s, frequencies.maximum is {maximum:.4g}"
        remedy = "raise frequencies.maximum, or leave it out"
    if problem:
        raise InputError.single(problem, remedy)
    return np.linspace(minimum, maximum, wanted.count)
