"""From a configuration to a Program: waves, hulls, potential flow, load.

`check_config` goes the same way with an empty flow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.from_file import coefficients_from_file
from m4e_adapters.hydrodynamics.coefficients import MEMORY_REACH, Coefficients, memory_size
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water, wave_sections
from m4e_adapters.hydrodynamics.drift.bodies import read_drifts
from m4e_adapters.hydrodynamics.flow.bem import excited_by, moving_hulls, solve_hulls, without_flow
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hulls
from m4e_adapters.hydrodynamics.load.program import Heading, hydrodynamics_program
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import (
    RecordSea,
    check_frequencies,
    needed_frequency,
    record_sea,
)
from m4e_adapters.hydrodynamics.seas.system_seas import lines_on
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.program import Program

Progress = Callable[[str], object]
MOST_BEYOND = 2.0  # frequencies that a response is asked for, over those of the memory
EXTENSION_STEP = 2.0  # of frequencies for waves above those of the memory, in steps of these
SHALLOWEST = 0.2  # wavenumber times depth below which Capytaine has no accurate Green function


def coefficients_from_config(
    config: HydrodynamicsConfig, *, folder: Path, highest: float = 0.0, progress: Progress = print
) -> Coefficients:
    """Coefficients of the configured bodies: of a file, or computed, once.

    Computed frequencies reach `highest` [rad/s] too, unless the configuration has their `maximum`.
    Raises InputError for meshes that do not bound a volume in the water, and for files of
    coefficients that are wrong or of other bodies or water.
    """
    return _flow(config, folder, highest=highest, progress=progress)[0]


def _flow(
    config: HydrodynamicsConfig,
    folder: Path,
    *,
    highest: float = 0.0,
    solved: bool = True,
    progress: Progress,
) -> tuple[Coefficients, tuple[WaveSystem, ...]]:
    """The coefficients, those of the flow 0 if it is not `solved`, and the waves in their water.

    InputError with all problems of hulls, waves and files of drift.
    """
    if config.coefficients is not None:
        found = coefficients_from_file(config, folder=folder, progress=progress)
        waves = _sea(config, found, folder, progress)
        found = found if solved else found.without_flow()
    else:
        hulls, waves = _prepared(config, folder, progress)
        omega = _table(config, hulls, waves, highest)
        needed = max(needed_frequency(waves), highest)
        found = coefficients_of(
            config, hulls, omega=omega, needed=needed, solved=solved, progress=progress
        )
    return found if config.body_to_body else found.without_interaction(), waves


def _prepared(
    config: HydrodynamicsConfig, folder: Path, progress: Progress
) -> tuple[Sequence[Hull], tuple[WaveSystem, ...]]:
    """Hulls and waves, with their doubts; InputError with all problems of them and of drift."""
    hulls, waves, problems = tuple[Hull, ...](), tuple[WaveSystem, ...](), list[Problem]()
    centers = {name: b.center_of_gravity for name, b in config.bodies.items() if not b.fixed}
    try:
        waves = _sea(config, config.water, folder, progress)
    except InputError as error:
        problems += error.problems
    try:
        hulls = make_hulls(config, folder, progress=progress)
    except InputError as error:
        problems += error.problems
    try:
        read_drifts(config, folder, centers=centers, water=config.water)
    except InputError as error:
        problems += error.problems
    InputError.raise_for(problems)
    for hull in hulls:
        text = _hull_text(hull, config.water)
        progress(f"note: {text}" if "capsizes" in text else text)
    return hulls, waves


def _sea(
    config: HydrodynamicsConfig, water: Water | Coefficients, folder: Path, progress: Progress
) -> tuple[WaveSystem, ...]:
    """The configured waves; notes and doubts on them are told."""
    found = wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)
    for line in lines_on(found):
        progress(line)
    return found


def coefficients_of(
    config: HydrodynamicsConfig,
    hulls: Sequence[Hull],
    *,
    omega: np.ndarray,
    needed: float = 0.0,
    solved: bool = True,
    progress: Progress = print,
) -> Coefficients:
    """Coefficients of these `hulls` of the configured bodies at `omega` (nω,) [rad/s].

    There are waves up to `needed` [rad/s]. Those of the flow are 0 if it is not `solved`.
    """
    sections, parts = wave_sections(config.waves), config.loads.excitation
    direction = sections[0].direction - config.heading if sections else 0.0  # from the hulls' x
    if not solved:
        still = without_flow(hulls, water=config.water, omega=omega, wave_direction=direction)
        return replace(still, excited_by=parts)
    found = solve_hulls(
        hulls,
        water=config.water,
        omega=omega,
        wave_direction=direction,
        needed=needed,
        progress=progress,
    )
    return excited_by(found, moving_hulls(hulls), parts)


def program_from_config(
    config: HydrodynamicsConfig, *, name: str, folder: Path, progress: Progress = print
) -> Program:
    """The configured load as a Program (see `load`)."""
    coefficients, waves = _flow(config, folder, progress=progress)
    return program_of(
        config, coefficients, name=name, folder=folder, waves=waves, progress=progress
    )


def program_in_waves(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    highest: float,
    progress: Progress = print,
) -> tuple[Program, HullWaves]:
    """The configured load with the forces of waves as inputs, and what these are.

    Computed up to `highest` [rad/s] at least, unless the configuration has a `maximum`.
    """
    coefficients, waves = _flow(config, folder, highest=highest, progress=progress)
    drifting = ", ".join(name for name, body in config.bodies.items() if body.drift is not None)
    note = f"second-order drift of {drifting} is left out: the response is that of first order"
    forces = HullWaves(
        coefficients=coefficients,
        water=coefficients,
        highest=float(coefficients.omega[-1]),
        notes=[note] if drifting else [],
    )
    program = program_of(
        config,
        coefficients,
        name=name,
        folder=folder,
        waves=waves,
        sea=forces.record,
        progress=progress,
    )
    return program, forces


def program_of(
    config: HydrodynamicsConfig,
    coefficients: Coefficients,
    *,
    name: str,
    folder: Path,
    waves: Sequence[WaveSystem] | None = None,
    sea: RecordSea = record_sea,
    memory: RadiationMemory | None = None,
    progress: Progress,
) -> Program:
    """The load of a configuration with its `coefficients`; `waves` and `memory` if made before."""
    if config.current is not None and not config.feels_current:
        progress(
            "warning: the current acts on nothing: no body has drag in moving water (drag: {surge: "
            "…})"
        )
    centers = dict(zip(coefficients.bodies, map(tuple, coefficients.centers.tolist()), strict=True))
    return hydrodynamics_program(
        coefficients,
        name=name,
        waves=config.waves if waves is None else waves,
        drag={body: section.drag for body, section in config.bodies.items()},
        radiation=config.radiation,
        heading=Heading(config.heading),
        current=config.current,
        loads=config.loads,
        drift=read_drifts(config, folder, centers=centers, water=coefficients),
        sea=sea,
        folder=folder,
        memory=memory,
        progress=progress,
    )


def check_config(config: HydrodynamicsConfig, *, folder: Path) -> Program:
    """InputError with all problems of a configuration and its files; computes no flow.

    Returns a program with the variables of that of the configuration, but for the states of the
    memory; there is no flow in it.
    """
    coefficients, waves = _flow(config, folder, solved=False, progress=lambda _: None)
    return program_of(
        config,
        coefficients,
        name="hydrodynamics",
        folder=folder,
        waves=waves,
        progress=lambda _: None,
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
    return _table(config, hulls, _sea(config, config.water, folder, lambda _: None), highest)


def _table(
    config: HydrodynamicsConfig,
    hulls: Sequence[Hull],
    waves: Sequence[WaveSystem],
    highest: float,
) -> np.ndarray:
    """As `frequency_table`, for `waves` that are known."""
    wanted, water = config.frequencies, config.water
    lengths = [  # that waves must be short against for radiation to be negligible: of a submerged
        # body, which radiates as e^(−2kd), with the depth d of its highest point
        memory_size(hull.hydrostatics.volume, hull.hydrostatics.waterplane[0])
        + max(0.0, -float(hull.panels.vertices[:, 2].max()))
        for hull in moving_hulls(hulls)
    ]
    limit = math.sqrt(MEMORY_REACH * water.gravity / min(lengths))
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
    InputError.raise_for(problems)
    table = np.linspace(minimum, maximum, wanted.count)
    if wanted.maximum is not None:
        check_frequencies(waves, maximum, limit, keys=("frequencies", "maximum"))
        return table
    step = EXTENSION_STEP * (table[1] - table[0])
    needed = max(needed_frequency(waves), min(highest, MOST_BEYOND * limit))
    more = math.ceil((needed - maximum) / step - 1e-9)
    return np.concatenate([table, maximum + step * np.arange(1, more + 1)])


def _hull_text(hull: Hull, water: Water) -> str:
    """Hydrostatics of a hull in its reference pose, and its panels, in one line."""
    known = hull.hydrostatics
    text = f"body {hull.name!r}: displaces {known.volume:.6g} m3, "
    if not hull.fixed:
        x, y, z = (round(value, 6) + 0.0 for value in known.center_of_buoyancy)
        center, heights = f"x = {x:.4g}, z = {z:.4g}", [known.metacentric_height(hull.center)]
        if len(hull.center) == 3:
            center = f"x = {x:.4g}, y = {y:.4g}, z = {z:.4g}"
            heights.append(known.transverse_metacentric_height(hull.center))
        shown = " and ".join(f"{height:.3g}" for height in heights)
        of = "" if len(heights) == 1 else " in pitch and roll"
        of += " (a negative one: alone and free, it capsizes)" if min(heights) < 0.0 else ""
        text += (
            f"neutral mass {water.density * known.volume:.6g} kg; centre of buoyancy at {center} "
            f"m; waterplane {known.waterplane[0]:.4g} m2, GM {shown} m{of}; "
        )
    draft = -float(hull.panels.vertices[:, 2].min())
    return (
        f"{text}lowest point {draft:.4g} m below the water, {len(hull.panels.faces)} panels (their "
        "error: m4e-fmi hydro SYSTEM --refine)"
    )
