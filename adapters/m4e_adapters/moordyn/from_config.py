"""A mooring from its section of a system file."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from m4e_adapters.hydrodynamics.config import current_problems
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.moordyn.config import MooringConfig, Seabed, in_space
from m4e_adapters.moordyn.line_file import line_file
from m4e_adapters.moordyn.mooring import (
    Fairlead,
    Mooring,
    NetData,
    Sea,
    fastest_water,
    internal_step,
    net_line,
)
from m4e_adapters.moordyn.ready_files.ready_file import ready_mooring
from m4e_adapters.moordyn.stability import SPEED, Segment, clear_of_seabed
from m4e_fmi.errors import InputError, Problem


def mooring(config: MooringConfig, *, folder: str | Path = ".") -> Mooring:
    """The mooring that `config` describes, or the file that it names, relative to `folder`.

    InputError if the internal time step is unstable or the file is not supported.
    """
    moved = partial(_sea, config, Path(folder))
    if config.file is not None:
        found = ready_mooring(Path(folder) / config.file, fairleads=config.fairleads, sea=moved)
        return found.in_space() if config.dimensions == 3 else found
    water = config.water
    assert water is not None
    sea = moved(water.depth, water.gravity)
    segments = _segments(config, speed=SPEED + (sea.speed if sea else 0.0))
    moving = {name: s for name, s in segments.items() if config.lines[name].segments > 1}
    step = internal_step(moving, scheme=config.solver.scheme, wanted=config.solver.time_step)
    return Mooring(
        text=line_file(config, time_step=step),
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
        net=_net(config, segments),
        at_rest=config.static_equilibrium,
        bed=-water.depth,
        scheme=config.solver.scheme,
        sea=sea,
        fastest=fastest_water(moving, scheme=config.solver.scheme, step=step),
    )


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
    """Points (anchors, then fairleads) and lines, for their static equilibrium."""
    water = config.water
    assert water is not None
    held = [
        {"position": in_space(place), "force": None, "name": f"anchor {name}", "anchor": True}
        for name, place in config.anchors.items()
    ]
    moved = [{"position": (0.0, 0.0, 0.0), "force": None} for _ in config.fairleads]
    number = {name: k for k, name in enumerate([*config.anchors, *config.fairleads])}
    lines = [
        net_line(
            segments[name],
            ends=(number[line.from_], number[line.to]),
            count=line.segments,
            length=line.unstretched_length,
            gravity=water.gravity,
        )
        for name, line in config.lines.items()
    ]
    return {
        "points": [*held, *moved],
        "fairleads": list(range(len(held), len(held) + len(moved))),
        "lines": lines,
        "bed": -water.depth,
        "bed_stiffness": config.seabed.stiffness,
    }


def _segments(config: MooringConfig, *, speed: float) -> dict[str, Segment]:
    """A segment of every line, at most at `speed` [m/s]."""
    found = {}
    for name, line in config.lines.items():
        kind, length = config.line_types[line.type], line.unstretched_length / line.segments
        held = [config.anchors[end][-1] for end in (line.from_,) if end in config.anchors]
        bed = config.seabed
        if config.water and clear_of_seabed(
            held, length=line.unstretched_length, depth=config.water.depth
        ):
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
            speed=speed,
        )
    return found
