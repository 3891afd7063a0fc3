"""From a configuration to a Program: hulls, potential flow, load."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.from_file import coefficients_from_file
from m4e_adapters.hydrodynamics.coefficients import MEMORY_REACH, Coefficients, memory_size
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Still, Water
from m4e_adapters.hydrodynamics.doubts import sea_doubts, size_doubts, stability_doubts
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls, without_flow
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, hulls_and_problems, make_hulls
from m4e_adapters.hydrodynamics.load.program import Heading, RecordSea, hydrodynamics_program
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory
from m4e_adapters.hydrodynamics.seas.sea import needed_frequency, record_sea, waves_beyond
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_adapters.hydrodynamics.seas.waves import angular_frequency
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.program import Program

MOST_BEYOND = 2.0  # frequencies that a response is asked for, over those of the memory
EXTENSION_STEP = 2.0  # of frequencies for waves above those of the memory, in steps of these
OF_A, OF_A_INF = 0.6, 1.2  # 1/(2^p - 1) for observed orders p = 1.4 and 0.9 in panel size
SHALLOWEST = 0.2  # wavenumber times depth below which Capytaine has no accurate Green function


def coefficients_from_config(
    config: HydrodynamicsConfig,
    *,
    folder: Path,
    highest: float = 0.0,
    progress: Callable[[str], object] = print,
) -> Coefficients:
    """Coefficients of the configured bodies: of a file, or computed, once.

    Computed frequencies reach `highest` [rad/s] too, unless the configuration has their `maximum`.
    Raises InputError for meshes that do not bound a volume in the water, and for files of
    coefficients that are wrong or of other bodies or water.
    """
    if config.coefficients is not None:
        found = coefficients_from_file(config, folder=folder, progress=progress)
    else:
        found = _computed(config, folder=folder, highest=highest, progress=progress)
    return found if config.body_to_body else found.without_interaction()


def _computed(
    config: HydrodynamicsConfig,
    *,
    folder: Path,
    highest: float,
    progress: Callable[[str], object],
) -> Coefficients:
    hulls = make_hulls(config, folder, progress=progress)
    for text in (
        *sea_doubts(config.waves, config.water),
        *size_doubts(hulls, config),
        *stability_doubts(hulls, config.water),
    ):
        progress(f"warning: {text}")
    for hull in hulls:
        progress(_hydrostatics(hull, config.water))
        progress(_accuracy(hull))
    return solve_hulls(
        hulls,
        water=config.water,
        omega=frequency_table(config, hulls, highest=highest),
        wave_direction=_direction(config),
        needed=max(needed_frequency(config.waves), highest),
        progress=progress,
    )


def _direction(config: HydrodynamicsConfig) -> float:
    """Direction [deg] of the waves from the hulls' x axis."""
    return 0.0 if isinstance(config.waves, Still) else config.waves.direction - config.heading


def program_from_config(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured load as a Program (see `load`)."""
    coefficients = coefficients_from_config(config, folder=folder, progress=progress)
    return program_of(config, coefficients, name=name, progress=progress)


def program_in_waves(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    highest: float,
    progress: Callable[[str], object] = print,
) -> tuple[Program, HullWaves]:
    """The configured load with the forces of waves as inputs, and what these are.

    Computed up to `highest` [rad/s] at least, unless the configuration has a `maximum`.
    """
    coefficients = coefficients_from_config(
        config, folder=folder, highest=highest, progress=progress
    )
    forces = HullWaves(coefficients, config.waves)
    program = program_of(config, coefficients, name=name, sea=forces.record, progress=progress)
    return program, forces


def program_of(
    config: HydrodynamicsConfig,
    coefficients: Coefficients,
    *,
    name: str,
    sea: RecordSea = record_sea,
    memory: RadiationMemory | None = None,
    progress: Callable[[str], object],
) -> Program:
    """The load of a configuration with its `coefficients`, and a `memory` if it is known."""
    return hydrodynamics_program(
        coefficients,
        name=name,
        waves=config.waves,
        drag={body: section.drag for body, section in config.bodies.items()},
        radiation=config.radiation,
        heading=Heading(config.heading, config.heading_filter),
        sea=sea,
        memory=memory,
        progress=progress,
    )


def frequency_table(
    config: HydrodynamicsConfig, hulls: Sequence[Hull], *, highest: float = 0.0
) -> np.ndarray:
    """Angular frequencies (nω,) [rad/s] for the potential flow, as `Frequencies` says.

    It reaches `highest` [rad/s] too, unless a `maximum` is given. Another sea changes at most how
    far the table goes, and no frequency in it: cached solutions of one sea serve the next.
    InputError with all problems of the table.
    """
    table, problems = table_and_problems(config, hulls, highest=highest)
    if problems:
        raise InputError(problems)
    return table


def check_config(config: HydrodynamicsConfig, *, folder: Path) -> Program:
    """InputError with all problems of a configuration and its files; computes no flow.

    Returns a program with the variables of that of the configuration, but for the states of the
    memory; there is no flow in it.
    """
    if config.coefficients is not None:
        found = coefficients_from_file(config, folder=folder, progress=_silent)
        return program_of(config, found.without_flow(), name="hydrodynamics", progress=_silent)
    hulls, problems = hulls_and_problems(config, folder, progress=_silent)
    omega = np.empty(0)
    if hulls:
        omega, wrong = table_and_problems(config, hulls)
        problems += wrong
    if problems:
        raise InputError(problems)
    still = without_flow(hulls, water=config.water, omega=omega, wave_direction=_direction(config))
    return program_of(config, still, name="hydrodynamics", progress=_silent)


def table_and_problems(
    config: HydrodynamicsConfig, hulls: Sequence[Hull], *, highest: float = 0.0
) -> tuple[np.ndarray, list[Problem]]:
    """The frequency table (nω,) [rad/s] of `frequency_table`, and all its problems."""
    wanted, water = config.frequencies, config.water
    limit = math.sqrt(MEMORY_REACH * water.gravity / min(map(_reach, hulls)))
    maximum = wanted.maximum or limit
    lowest = float(
        angular_frequency(SHALLOWEST / water.depth, depth=water.depth, gravity=water.gravity)
    )
    minimum = wanted.minimum or max(maximum / wanted.count, lowest)
    problems = []
    if minimum < lowest:
        text = f"frequencies.minimum {minimum:.4g} rad/s is too low for this water depth"
        remedy = f"use {lowest:.4g} rad/s or more"
        problems.append(Problem(text, remedy, keys=("frequencies", "minimum")))
    if minimum >= maximum:
        text = f"the frequencies from {minimum:.4g} to {maximum:.4g} rad/s are not a range"
        remedy = "give frequencies.maximum above frequencies.minimum"
        problems.append(Problem(text, remedy, keys=("frequencies",)))
    beyond = waves_beyond(config.waves, maximum, limit)
    if beyond and wanted.maximum is not None:
        problems.append(Problem(*beyond, keys=("frequencies", "maximum")))
    table = np.linspace(minimum, maximum, wanted.count)
    if wanted.maximum is not None or problems:
        return table, problems
    step = EXTENSION_STEP * (table[1] - table[0])
    needed = max(needed_frequency(config.waves), min(highest, MOST_BEYOND * limit))
    more = math.ceil((needed - maximum) / step - 1e-9)
    return np.concatenate([table, maximum + step * np.arange(1, more + 1)]), []


def _hydrostatics(hull: Hull, water: Water) -> str:
    """Hydrostatics of a hull in its reference pose, in one line."""
    known = hull.hydrostatics
    x, y, z = (round(value, 6) + 0.0 for value in known.center_of_buoyancy)
    center, heights = f"x = {x:.4g}, z = {z:.4g}", [known.metacentric_height(hull.center)]
    if len(hull.center) == 3:
        center = f"x = {x:.4g}, y = {y:.4g}, z = {z:.4g}"
        heights.append(known.transverse_metacentric_height(hull.center))
    shown = " and ".join(f"{height:.3g}" for height in heights)
    of = "" if len(heights) == 1 else " in pitch and roll"
    return (
        f"body {hull.name!r}: displaces {known.volume:.6g} m3, neutral mass "
        f"{water.density * known.volume:.6g} kg; centre of buoyancy at {center} m; "
        f"waterplane {known.waterplane[0]:.4g} m2, GM {shown} m{of}"
    )


def _accuracy(hull: Hull) -> str:
    """The size of a hull, and how to estimate the error of its number of panels."""
    count = len(hull.panels.faces)
    draft = -float(hull.panels.vertices[:, 2].min())
    return (
        f"body {hull.name!r}: displaces {hull.hydrostatics.volume:.4g} m3, lowest point "
        f"{draft:.4g} m below the water, {count} panels; to estimate their error, compute with "
        f"about {count // 4} panels too: it is {OF_A:g} of the difference in added mass, and "
        f"{OF_A_INF:g} of that in added mass at infinite frequency"
    )


def _silent(_: str) -> None:
    pass


def _reach(hull: Hull) -> float:
    """Length [m] that waves must be short against for radiation to be negligible.

    The size of a body; a submerged one radiates as e^(−2kd), d the depth of its highest point.
    """
    depth = max(0.0, -float(hull.panels.vertices[:, 2].max()))
    return memory_size(hull.hydrostatics.volume, hull.hydrostatics.waterplane[0]) + depth
