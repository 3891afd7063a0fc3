"""A mooring from its section of a system file.

Described lines are written as a MoorDyn file, and that is read like any other.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from m4e_adapters.hydrodynamics.config import current_problems
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.moordyn.bathymetry import FILE, Bathymetry, bathymetry
from m4e_adapters.moordyn.config import MooringConfig, in_space
from m4e_adapters.moordyn.line_file import MOVING_WATER, line_file, point_numbers
from m4e_adapters.moordyn.mooring import (
    Failure,
    Fairlead,
    Mooring,
    Sea,
    internal_step,
    kinds_of,
)
from m4e_adapters.moordyn.ready_files.attachments import Attachments
from m4e_adapters.moordyn.ready_files.named_files import NamedFiles
from m4e_adapters.moordyn.ready_files.read_file import ReadFile
from m4e_adapters.moordyn.ready_files.ready_file import (
    net_of,
    ready_mooring,
    segments_of,
    text_of,
    with_moving_nodes,
)
from m4e_adapters.moordyn.stability import cheapest_scheme
from m4e_fmi.errors import InputError, Problem

ROUNDED = 1e-3
"""[m] below a seabed of a file, by which places may be rounded."""


def mooring(config: MooringConfig, *, folder: str | Path = ".") -> Mooring:
    """The mooring that `config` describes, or the file that it names, relative to `folder`.

    InputError if the internal time step is unstable or the file is not supported.
    """
    moved = partial(_sea, config, Path(folder))
    if config.file is not None:
        given = config.water.model_dump(exclude_unset=True) if config.water else {}
        return ready_mooring(
            Path(folder) / config.file,
            fairleads=config.fairleads,
            sea=moved,
            water=given,
            in_space=config.dimensions == 3,
        )
    water = config.water
    assert water is not None
    bed = _bed(config, Path(folder))
    depths = (water.depth, water.depth) if bed is None else (bed.depth.min(), bed.depth.max())
    shallowest, deepest = map(float, depths)
    sea = moved(water.depth, water.gravity)
    file = ReadFile(Path("the description"), text=line_file(config, deepest=deepest))
    attached = Attachments(file)
    winches = tuple(k for k, line in enumerate(config.lines.values()) if line.winch)
    segments = segments_of(
        file, attached, NamedFiles(file), lines=config.lines, depth=shallowest, winches=winches
    )
    moving = with_moving_nodes(file, attached, segments)
    scheme = config.solver.scheme or cheapest_scheme(moving.values())
    step = internal_step(moving, scheme=scheme, wanted=config.solver.time_step)
    options = [(repr(step), "dtM"), (scheme, "tScheme")]
    if sea:
        options.append(MOVING_WATER)
    if bed:
        options.append((FILE, "SeafloorFile"))
    number = point_numbers(config)
    names = {str(number[name]): f"anchor {name}" for name in config.anchors}
    names |= {str(number[name]): f"point {name}" for name in config.points}
    return Mooring(
        text=text_of(file, attached, options, known=True),
        fairleads=tuple(
            Fairlead(
                name,
                *in_space(place or (0.0, 0.0)),
                placed=place is not None,
                moves_in_space=config.dimensions == 3,
            )
            for name, place in config.fairleads.items()
        ),
        lines=tuple(config.lines),
        time_step=step,
        net=net_of(file, attached, segments, names) if bed is None else None,
        at_rest=config.static_equilibrium,
        bed=-deepest,
        scheme=scheme,
        sea=sea,
        kinds=kinds_of(segments, moving, bed=-shallowest),
        files={} if bed is None else {FILE: bed.file},
        failures=tuple(
            Failure(((k, 1),), tension=strength)
            for k, line in enumerate(config.lines.values())
            if line.breaks and (strength := config.line_types[line.type].breaking_strength)
        ),
        winches=winches,
        strengths={
            name: strength
            for name, line in config.lines.items()
            if (strength := config.line_types[line.type].breaking_strength)
        },
        anchors={name: number[name] for name in config.anchors},
        points={name: number[name] for name in config.points},
    )


def _bed(config: MooringConfig, folder: Path) -> Bathymetry | None:
    """The seabed that is not flat; InputError for places below it."""
    if config.seabed.bathymetry is None:
        return None
    bed = bathymetry(config.seabed.bathymetry, folder=folder)
    points = {name: point.position for name, point in config.points.items()}
    groups = {"anchors": config.anchors, "fairleads": config.fairleads, "points": points}
    places = {(key, name): at for key, group in groups.items() for name, at in group.items() if at}
    InputError.raise_for(
        Problem(
            f"{keys[1]} at z = {place[2]:g} m lies below the seabed, there at {-depth:g} m",
            "use a larger z, or check the bathymetry",
            keys=keys,
        )
        for keys, at in places.items()
        for place in [in_space(at)]
        for depth in [bed.at(*place[:2])]
        if place[2] < -depth - ROUNDED
    )
    return bed


def _sea(config: MooringConfig, folder: Path, depth: float, gravity: float) -> Sea | None:
    """The water of `depth` [m] that waves and a current move, None if it stands still."""
    problems = [
        Problem(text, remedy, keys=place)
        for place, text, remedy in current_problems(
            config.current, depth=depth, dimensions=config.dimensions
        )
    ]
    InputError.raise_for(problems)
    waves = wave_systems(config.systems, depth=depth, gravity=gravity, folder=folder)
    if not config.moves_water:
        return None
    return Sea(waves, config.current, config.stretching, depth=depth, gravity=gravity)
