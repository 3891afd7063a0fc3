"""From a configuration to a Program: hulls, potential flow, load."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.from_file import coefficients_from_file
from m4e_adapters.hydrodynamics.coefficients import MEMORY_REACH, Coefficients, memory_size
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water, wave_sections
from m4e_adapters.hydrodynamics.drift.bodies import drifts_and_problems
from m4e_adapters.hydrodynamics.flow.bem import excited_by, moving_hulls, solve_hulls, without_flow
from m4e_adapters.hydrodynamics.flow.gap_lid import damped_lid
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, hulls_and_problems, make_hulls
from m4e_adapters.hydrodynamics.load.body_points import points_on_bodies
from m4e_adapters.hydrodynamics.load.drag import bodies_in_moving_water
from m4e_adapters.hydrodynamics.load.program import Heading, hydrodynamics_program
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import (
    RecordSea,
    needed_frequency,
    record_sea,
    waves_beyond,
)
from m4e_adapters.hydrodynamics.seas.system_seas import lines_on
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.current import current_doubts
from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.program import Program

LENGTHS = (0.01, 1000.0)  # [m] of hulls
BODIES_APART = 1000.0  # length of a hull over that of the shortest
WAVES_APART = 100.0  # length of a hull over that of the waves
UNSTABLE = -1e-3  # metacentric height over the size of a body, beyond the panels' noise


def size_doubts(
    hulls: Sequence[Hull], config: HydrodynamicsConfig, systems: Sequence[WaveSystem]
) -> Iterator[str]:
    """Hulls of sizes that no hull has, or none beside the others or in these waves; a line each."""
    lengths = {hull.name: float(np.ptp(hull.panels.vertices, axis=0).max()) for hull in hulls}
    shortest = min(lengths, key=lambda name: lengths[name])
    waves = min((system.length for system in systems), default=math.inf)
    for name, length in lengths.items():
        told = f"the hull of body {name!r} measures {length:.4g} m"
        if config.bodies[name].shape.mesh is not None:
            remedy = "a mesh is in m; one in mm has 'scale: 0.001'"
        else:
            remedy = "lengths are in m"
        if not LENGTHS[0] <= length <= LENGTHS[1]:
            yield f"{told}, hulls have {LENGTHS[0]:g} to {LENGTHS[1]:g} m: {remedy}"
        elif length > BODIES_APART * lengths[shortest]:
            yield f"{told}, that of {shortest!r} {lengths[shortest]:.4g} m: {remedy}"
        elif length > WAVES_APART * waves:
            yield f"{told}, the waves are {waves:.4g} m long: {remedy}"


def stability_doubts(hulls: Sequence[Hull], water: Water) -> Iterator[str]:
    """Hulls that capsize if they float freely; a line each."""
    for hull in hulls:
        if hull.fixed:
            continue
        volume = hull.hydrostatics.volume
        heights = {"pitch": hull.hydrostatics.metacentric_height(hull.center)}
        if len(hull.center) == 3:
            heights["roll"] = hull.hydrostatics.transverse_metacentric_height(hull.center)
        for motion, height in heights.items():
            if height >= UNSTABLE * math.cbrt(volume):
                continue
            stiffness = water.density * water.gravity * volume * height
            yield (
                f"body {hull.name!r} is unstable in {motion}, with a stiffness of {stiffness:.4g} "
                f"N.m/rad, weight included (GM = {height:.3g} m): floating freely it capsizes: "
                "lower center_of_gravity"
            )


def flow_doubts(config: HydrodynamicsConfig) -> Iterator[str]:
    """A current beside waves, or one that acts on nothing; a line each."""
    yield from current_doubts(config.current, has_waves=bool(wave_sections(config.waves)))
    if config.current is not None and not config.feels_current:
        yield "the current acts on nothing: no body has drag in moving water (drag: {surge: …})"


MOST_BEYOND = 2.0  # frequencies that a response is asked for, over those of the memory
EXTENSION_STEP = 2.0  # of frequencies for waves above those of the memory, in steps of these
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
    waves = _systems(config, folder)
    hulls = make_hulls(config, folder, progress=progress)
    for line in lines_on(waves):
        progress(line)
    for text in (*size_doubts(hulls, config, waves), *stability_doubts(hulls, config.water)):
        progress(f"warning: {text}")
    for hull in hulls:
        if not hull.fixed:
            progress(_hydrostatics(hull, config.water))
        progress(_accuracy(hull))
    omega = frequency_table(config, hulls, folder=folder, highest=highest)
    needed = max(needed_frequency(waves), highest)
    return coefficients_of(config, hulls, omega=omega, needed=needed, progress=progress)


def coefficients_of(
    config: HydrodynamicsConfig,
    hulls: Sequence[Hull],
    *,
    omega: np.ndarray,
    needed: float = 0.0,
    progress: Callable[[str], object] = print,
) -> Coefficients:
    """Coefficients of these `hulls` of the configured bodies at `omega` (nω,) [rad/s].

    There are waves up to `needed` [rad/s].
    """
    found = solve_hulls(
        hulls,
        water=config.water,
        omega=omega,
        wave_direction=_direction(config),
        needed=needed,
        gap_lid=damped_lid(config.gap_lids, hulls),
        progress=progress,
    )
    return excited_by(found, moving_hulls(hulls), config.loads.excitation)


def _direction(config: HydrodynamicsConfig) -> float:
    """Direction [deg] of the (first) waves from the hulls' x axis."""
    sections = wave_sections(config.waves)
    return sections[0].direction - config.heading if sections else 0.0


def _systems(config: HydrodynamicsConfig, folder: Path) -> tuple[WaveSystem, ...]:
    water = config.water
    return wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)


def program_from_config(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured load as a Program (see `load`)."""
    coefficients = coefficients_from_config(config, folder=folder, progress=progress)
    return program_of(config, coefficients, name=name, folder=folder, progress=progress)


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
    with_drift = [name for name, body in config.bodies.items() if body.drift is not None]
    points = points_on_bodies(coefficients, config.points)
    drags = {name: body.drag for name, body in config.bodies.items()}
    in_water = bodies_in_moving_water(coefficients, drags, config.current)
    in_water = in_water if config.loads.drag != "none" else ()
    forces = HullWaves(coefficients, points, in_water, drift=tuple(with_drift))
    program = program_of(
        config, coefficients, name=name, folder=folder, sea=forces.record, progress=progress
    )
    return program, forces


def program_of(
    config: HydrodynamicsConfig,
    coefficients: Coefficients,
    *,
    name: str,
    folder: Path,
    sea: RecordSea = record_sea,
    memory: RadiationMemory | None = None,
    progress: Callable[[str], object],
) -> Program:
    """The load of a configuration with its `coefficients`, and a `memory` if it is known."""
    water = config.water.model_copy(
        update={key: getattr(coefficients, key) for key in ("density", "depth", "gravity")}
    )
    for text in flow_doubts(config):
        progress(f"warning: {text}")
    centers = dict(zip(coefficients.bodies, map(tuple, coefficients.centers.tolist()), strict=True))
    drift, problems = drifts_and_problems(config, folder, centers=centers, water=water)
    InputError.raise_for(problems)
    return hydrodynamics_program(
        coefficients,
        name=name,
        waves=config.waves,
        drag={body: section.drag for body, section in config.bodies.items()},
        radiation=config.radiation,
        heading=Heading(config.heading, config.heading_filter),
        current=config.current,
        loads=config.loads,
        drift=drift,
        points=config.points,
        sea=sea,
        folder=folder,
        memory=memory,
        progress=progress,
    )


def frequency_table(
    config: HydrodynamicsConfig,
    hulls: Sequence[Hull],
    *,
    folder: Path = Path(),
    highest: float = 0.0,
) -> np.ndarray:
    """Angular frequencies (nω,) [rad/s] for the potential flow, as `Frequencies` says.

    It reaches `highest` [rad/s] too, unless a `maximum` is given. Another sea changes at most how
    far the table goes, and no frequency in it: cached solutions of one sea serve the next.
    Files of the waves are in `folder`. InputError with all problems of the table.
    """
    waves = _systems(config, folder)
    table, problems = table_and_problems(config, hulls, waves=waves, highest=highest)
    InputError.raise_for(problems)
    return table


def check_config(config: HydrodynamicsConfig, *, folder: Path) -> Program:
    """InputError with all problems of a configuration and its files; computes no flow.

    Returns a program with the variables of that of the configuration, but for the states of the
    memory; there is no flow in it.
    """
    if config.coefficients is not None:
        found = coefficients_from_file(config, folder=folder, progress=_silent)
        found = found.without_flow()
        return program_of(config, found, name="hydrodynamics", folder=folder, progress=_silent)
    hulls, problems = hulls_and_problems(config, folder, progress=_silent)
    omega, waves = np.empty(0), tuple[WaveSystem, ...]()
    try:
        waves = _systems(config, folder)
    except InputError as error:
        problems += error.problems
    centers = {name: b.center_of_gravity for name, b in config.bodies.items() if not b.fixed}
    problems += drifts_and_problems(config, folder, centers=centers, water=config.water)[1]
    try:
        damped_lid(config.gap_lids if hulls else (), hulls)
    except InputError as error:
        problems += error.problems
    if moving_hulls(hulls):
        omega, wrong = table_and_problems(config, hulls, waves=waves)
        problems += wrong
    InputError.raise_for(problems)
    still = without_flow(hulls, water=config.water, omega=omega, wave_direction=_direction(config))
    still = replace(still, excited_by=config.loads.excitation)
    return program_of(config, still, name="hydrodynamics", folder=folder, progress=_silent)


def table_and_problems(
    config: HydrodynamicsConfig,
    hulls: Sequence[Hull],
    *,
    waves: Sequence[WaveSystem],
    highest: float = 0.0,
) -> tuple[np.ndarray, list[Problem]]:
    """The frequency table (nω,) [rad/s] of `frequency_table`, and all its problems."""
    wanted, water = config.frequencies, config.water
    limit = math.sqrt(MEMORY_REACH * water.gravity / min(map(_reach, moving_hulls(hulls))))
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
    beyond = waves_beyond(waves, maximum, limit)
    if beyond and wanted.maximum is not None:
        problems.append(Problem(*beyond, keys=("frequencies", "maximum")))
    table = np.linspace(minimum, maximum, wanted.count)
    if wanted.maximum is not None or problems:
        return table, problems
    step = EXTENSION_STEP * (table[1] - table[0])
    needed = max(needed_frequency(waves), min(highest, MOST_BEYOND * limit))
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
    """The size of a hull, and where the error of its number of panels comes from."""
    count = len(hull.panels.faces)
    draft = -float(hull.panels.vertices[:, 2].min())
    return (
        f"body {hull.name!r}: displaces {hull.hydrostatics.volume:.4g} m3, lowest point "
        f"{draft:.4g} m below the water, {count} panels (their error: see 'refinement' in the page "
        "of hydrodynamics)"
    )


def _silent(_: str) -> None:
    pass


def _reach(hull: Hull) -> float:
    """Length [m] that waves must be short against for radiation to be negligible.

    The size of a body; a submerged one radiates as e^(−2kd), d the depth of its highest point.
    """
    depth = max(0.0, -float(hull.panels.vertices[:, 2].max()))
    return memory_size(hull.hydrostatics.volume, hull.hydrostatics.waterplane[0]) + depth
