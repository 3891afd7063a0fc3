"""A mooring from its section of a system file."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from m4e_adapters.hydrodynamics.config import current_problems
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.moordyn.bathymetry import FILE, Bathymetry, bathymetry
from m4e_adapters.moordyn.config import MooringConfig, Seabed, in_space
from m4e_adapters.moordyn.line_file import line_file, point_numbers
from m4e_adapters.moordyn.mooring import (
    Failure,
    Fairlead,
    Mooring,
    NetData,
    Sea,
    internal_step,
    kinds_of,
    net_line,
)
from m4e_adapters.moordyn.ready_files.ready_file import ready_mooring
from m4e_adapters.moordyn.stability import FLOW, Segment, cheapest_scheme, clear_of_seabed
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
        found = ready_mooring(
            Path(folder) / config.file, fairleads=config.fairleads, sea=moved, water=given
        )
        return (found.in_space() if config.dimensions == 3 else found).named()
    water = config.water
    assert water is not None
    bed = _bed(config, Path(folder))
    depths = (water.depth, water.depth) if bed is None else (bed.depth.min(), bed.depth.max())
    sea = moved(water.depth, water.gravity)
    segments = _segments(config, shallowest=float(depths[0]))
    moving = {
        name: segment
        for name, segment in segments.items()
        for line in [config.lines[name]]
        if line.segments > 1 or {line.from_, line.to} & config.points.keys()
    }
    scheme = config.solver.scheme or cheapest_scheme(moving.values())
    step = internal_step(moving, scheme=scheme, wanted=config.solver.time_step)
    number = point_numbers(config)
    return Mooring(
        text=line_file(config, time_step=step, scheme=scheme, deepest=float(depths[1])),
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
        net=_net(config, segments) if bed is None else None,
        at_rest=config.static_equilibrium,
        bed=-float(depths[1]),
        scheme=scheme,
        sea=sea,
        kinds=kinds_of(segments, moving, bed=-float(depths[0])),
        files={} if bed is None else {FILE: bed.file},
        failures=tuple(
            Failure(((k, 1),), tension=strength)
            for k, line in enumerate(config.lines.values())
            if line.breaks and (strength := config.line_types[line.type].breaking_strength)
        ),
        winches=tuple(k for k, line in enumerate(config.lines.values()) if line.winch),
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


def _net(config: MooringConfig, segments: dict[str, Segment]) -> NetData:
    """Points (anchors, fairleads, free points) and lines, for their static equilibrium."""
    water = config.water
    assert water is not None
    held = [
        {"position": in_space(place), "force": None, "name": f"anchor {name}", "anchor": True}
        for name, place in config.anchors.items()
    ]
    moved = [{"position": (0.0, 0.0, 0.0), "force": None} for _ in config.fairleads]
    free = []
    for name, point in config.points.items():
        lift = point.volume * water.density * water.gravity
        x, y, z = in_space(point.force or (0.0, 0.0))
        force = (x, y, z + lift - point.mass * water.gravity)
        known = {"name": f"point {name}", "buoyancy": lift}
        free.append({"position": in_space(point.position), "force": force, **known})
    number = point_numbers(config)
    lines = [
        net_line(
            segments[name],
            ends=(number[line.from_] - 1, number[line.to] - 1),
            count=line.segments,
            length=line.unstretched_length,
            gravity=water.gravity,
        )
        for name, line in config.lines.items()
    ]
    return {
        "points": [*held, *moved, *free],
        "fairleads": list(range(len(held), len(held) + len(moved))),
        "lines": lines,
        "bed": -water.depth,
        "bed_stiffness": config.seabed.stiffness,
    }


def _segments(config: MooringConfig, *, shallowest: float) -> dict[str, Segment]:
    """A segment of every line, above a bed of this least depth [m]."""
    found = {}
    for name, line in config.lines.items():
        kind, length = config.line_types[line.type], line.unstretched_length / line.segments
        held = [config.anchors[end][-1] for end in (line.from_,) if end in config.anchors]
        bed, ends = config.seabed, (line.from_, line.to)
        clear = clear_of_seabed(held, length=line.unstretched_length, depth=shallowest)
        if clear and not line.winch:
            bed = Seabed(stiffness=0.0, damping=0.0)
        found[name] = Segment(
            length=length,
            diameter=kind.diameter,
            mass_per_length=kind.mass_per_length,
            axial_stiffness=kind.axial_stiffness,
            damping=kind.damping(length),
            bending_stiffness=kind.bending_stiffness,
            seabed_stiffness=bed.stiffness,
            seabed_damping=bed.damping,
            water_density=config.water.density if config.water else 0.0,
            drag_coefficient=kind.drag_coefficient,
            added_mass_coefficient=kind.added_mass_coefficient,
            axial_drag_coefficient=kind.axial_drag_coefficient,
            axial_added_mass_coefficient=kind.axial_added_mass_coefficient,
            friction=max(
                bed.friction * bed.friction_damping,
                *(_damping(config, end, kind.mass_per_length * length) for end in ends),
            ),
        )
    return found


def _damping(config: MooringConfig, end: str, mass: float) -> float:
    """Damping [N·s/m] of a node with `mass` [kg] as fast as that of a free point by its drag.

    0 at other ends.
    """
    point = config.points.get(end)
    if point is None or config.water is None:
        return 0.0
    density = config.water.density
    whole = point.mass + density * point.volume * point.added_mass_coefficient + mass / 2
    return density * point.drag_area * FLOW * mass / whole
