"""Slender members in waves and a current as a Program."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, places_in_space, point_in_space
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import elevation_at_origin, record_elevation_input
from m4e_adapters.hydrodynamics.seas.system_seas import lines_on
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.current import (
    RecordedCurrent,
    record_current,
)
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedFlow
from m4e_adapters.morison.added_mass import (
    Matrix,
    added_mass,
    has_added_mass,
    publish_added_mass,
    turning_load,
)
from m4e_adapters.morison.config import FIXED, MorisonConfig
from m4e_adapters.morison.loads import (
    NO_LOAD,
    Load,
    MemberLoad,
    joined,
    member_load,
    record_coefficients,
)
from m4e_adapters.morison.motion import BodyMotion, record_body
from m4e_adapters.morison.vectors import Number
from m4e_adapters.morison.waves import MemberWaves, load_in_waves
from m4e_fmi.program import Program, Recorder, Variable

SLENDER = 0.2
"""Diameter over the length of waves, above which they are scattered."""


def morison_program(
    config: MorisonConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The program of the members, called `name`; files of their waves are in `folder`.

    Inputs `<body>.{x,z,theta,vx,vz,omega}`, in space all six motions, outputs
    `<body>.{force_x,force_z,moment_y}` about the centre of gravity and their parts `drag_…`,
    `inertia_…`, `buoyancy_…`, `fixed.…` of all fixed members about the reference point,
    `<member>.force_…`, `.wet_length`, `wave.elevation`, and `added_mass[i,j]` if a member of a body
    has some.
    """
    recorder = Recorder(name, "slender members by Morison's equation")
    systems = _systems(config, folder, progress)
    in_space = config.dimensions == 3
    flow = RecordedFlow(
        water=config.water,
        time=recorder.time,
        waves=[system.record(recorder, in_space=in_space) for system in systems],
        current=_current(recorder, config),
        stretching=config.stretching,
    )
    recorder.output(elevation_at_origin(config.dimensions), flow.elevation_at_origin())
    surface = wave_height(systems)

    def load(member: str, body: BodyMotion) -> MemberLoad:
        own = config.members[member]
        return member_load(own, record_coefficients(recorder, member, own), body, flow, surface)

    _record_members(recorder, config, flow, load)
    return recorder.program()


def members_in_waves(
    config: MorisonConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
    **_: object,
) -> tuple[Program, MemberWaves]:
    """The program with what waves do to the members as inputs, and what that is in any wave."""
    recorder = Recorder(name, "slender members by Morison's equation, in any waves")
    systems = _systems(config, folder, progress)
    for system in systems:
        system.record(recorder, in_space=config.dimensions == 3)
    flow = RecordedFlow(
        water=config.water, time=recorder.time, waves=[], current=_current(recorder, config)
    )
    record_elevation_input(recorder, config.dimensions)

    def load(member: str, body: BodyMotion) -> MemberLoad:
        known = record_coefficients(recorder, member, config.members[member])
        return load_in_waves(recorder, config, member, known, body, flow)

    _record_members(recorder, config, flow, load)
    return recorder.program(), MemberWaves(config=config, systems=systems, water=config.water)


def _systems(
    config: MorisonConfig, folder: Path, progress: Callable[[str], object]
) -> Sequence[WaveSystem]:
    """The configured waves, after what is doubtful has been told."""
    water = config.water
    systems = wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)
    for text in doubts(config, systems):
        progress(text)
    return systems


def _current(recorder: Recorder, config: MorisonConfig) -> RecordedCurrent:
    in_space = config.dimensions == 3
    return record_current(recorder, config.current, depth=config.water.depth, in_space=in_space)


def _record_members(
    recorder: Recorder,
    config: MorisonConfig,
    flow: RecordedFlow,
    load: Callable[[str, BodyMotion], MemberLoad],
) -> None:
    """Inputs and outputs of all bodies and members, whose loads are made by `load`."""
    matrices: dict[str, Matrix] = {}
    for body, section in config.bodies.items():
        moves = record_body(recorder, body, section.center_of_gravity, config.dimensions)
        _record_loads(recorder, config, body, moves, flow, load)
        matrices[body] = added_mass(config.of_body(body), moves, config.water.density)
    if config.of_body(None):
        point = point_in_space(config.reference_point or (0.0, 0.0))
        _record_loads(recorder, config, FIXED, BodyMotion(point, point), flow, load)
    if has_added_mass([m for m in config.members.values() if m.body is not None]):
        publish_added_mass(recorder, matrices, config.dimensions)


def wave_height(systems: Sequence[WaveSystem]) -> float:
    """√2 standard deviations [m] of the elevation: the amplitude of a regular wave."""
    return math.sqrt(sum(float(np.sum(system.configured()[1] ** 2)) for system in systems))


def doubts(config: MorisonConfig, systems: Sequence[WaveSystem]) -> Iterator[str]:
    """Lines on waves that there are not, thick members, and what may count twice."""
    yield from lines_on(systems)
    thickest = max(config.members, key=lambda name: config.members[name].diameter)
    diameter = config.members[thickest].diameter
    shortest = min((system.length for system in systems), default=float("inf"))
    if diameter > SLENDER * shortest:
        yield (
            f"warning: {thickest} is {diameter:g} m thick, the waves are {shortest:.3g} m long: it "
            f"scatters them, and Morison's equation holds up to {SLENDER:g} of their length"
        )
    carried = [name for name, member in config.members.items() if member.body]
    if carried:
        yield (
            f"note: {', '.join(carried)}: inertia, buoyancy and drag of these members are in here, "
            "unless they say otherwise; of a part that a hydrodynamics component has too, they "
            "count twice: give such members 'added_mass: 0, inertia: 0', and drag in one of the two"
        )


def _record_loads(
    recorder: Recorder,
    config: MorisonConfig,
    body: str,
    moves: BodyMotion,
    flow: RecordedFlow,
    load: Callable[[str, BodyMotion], MemberLoad],
) -> None:
    """Outputs of the members of a body, and of their sum."""
    drag, inertia, lifted = NO_LOAD, NO_LOAD, NO_LOAD
    members = config.of_body(None if body == FIXED else body)
    for name, member in members.items():
        own = load(name, moves)
        _record_member(recorder, config, name, own)
        drag, inertia = joined(drag, own.drag), joined(inertia, own.inertia)
        lifted = joined(lifted, own.buoyancy)
        if body != FIXED:
            inertia = joined(inertia, turning_load(member, moves, flow))
    whole = f"of the water on the members of {body} about its centre of gravity, less added_mass"
    if body == FIXED:
        whole = "of the water on the fixed members about the reference point"
    total = joined(joined(drag, inertia), lifted)
    _record_wrench(recorder, config, f"{body}.", total, whole)
    part = f"part of {body}'s: drag"
    _record_wrench(recorder, config, f"{body}.drag_", drag, part)
    part = f"part of {body}'s: acceleration of the water"
    _record_wrench(recorder, config, f"{body}.inertia_", inertia, part)
    if any(member.is_buoyant for member in members.values()):
        part = f"part of {body}'s: buoyancy of still water up to the surface"
        _record_wrench(recorder, config, f"{body}.buoyancy_", lifted, part)


def _record_wrench(
    recorder: Recorder,
    config: MorisonConfig,
    prefix: str,
    wrench: Load,
    text: str,
) -> None:
    values: list[Number] = [*wrench[0], *wrench[1]]
    kept = places_in_space(config.dimensions)
    for motion, place in zip(MOTIONS[config.dimensions], kept, strict=True):
        variable = Variable(f"{prefix}{motion.force}", motion.force_unit, f"{motion.force} {text}")
        recorder.output(variable, values[place])


def _record_member(recorder: Recorder, config: MorisonConfig, name: str, load: MemberLoad) -> None:
    for axis, value in zip("xyz", load.force, strict=True):
        if axis != "y" or config.dimensions == 3:
            text = f"force of the water on {name} along {axis}, without added_mass"
            recorder.output(Variable(f"{name}.force_{axis}", "N", text), value)
    text = f"length of {name} below the surface"
    recorder.output(Variable(f"{name}.wet_length", "m", text), load.wet_length)
