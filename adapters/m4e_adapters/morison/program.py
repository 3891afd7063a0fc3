"""Slender members in waves and a current as a Program."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, places_in_space, point_in_space
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import elevation_at_origin
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.current import current_doubts, record_current
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedFlow
from m4e_adapters.morison.added_mass import (
    Matrix,
    added_mass,
    has_added_mass,
    publish_added_mass,
    turning_load,
)
from m4e_adapters.morison.config import FIXED, Member, MorisonConfig
from m4e_adapters.morison.motion import BodyMotion, record_body
from m4e_adapters.morison.strips import MemberLoad, member_load, record_coefficients
from m4e_adapters.morison.vectors import ZERO, Number, Vector, add
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
    `inertia_…`, `fixed.…` of all fixed members about the reference point, `<member>.force_…`,
    `.wet_length`, `wave.elevation`, and `added_mass[i,j]` if a member of a body has some.
    """
    recorder = Recorder(name, "slender members by Morison's equation")
    water, in_space = config.water, config.dimensions == 3
    systems = wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)
    for text in doubts(config, systems):
        progress(text)
    flow = RecordedFlow(
        water=water,
        time=recorder.time,
        waves=[system.record(recorder, in_space=in_space) for system in systems],
        current=record_current(recorder, config.current, depth=water.depth, in_space=in_space),
        stretching=config.stretching,
    )
    recorder.output(elevation_at_origin(config.dimensions), flow.elevation_at_origin())
    surface = wave_height(systems)
    matrices: dict[str, Matrix] = {}
    for body, section in config.bodies.items():
        moves = record_body(recorder, body, section.center_of_gravity, config.dimensions)
        members = config.of_body(body)
        _record_loads(recorder, config, body, members, moves, flow, surface)
        matrices[body] = added_mass(members, moves, water.density)
    if fixed := config.of_body(None):
        point = point_in_space(config.reference_point or (0.0, 0.0))
        _record_loads(recorder, config, FIXED, fixed, BodyMotion(point, point), flow, surface)
    if has_added_mass([m for m in config.members.values() if m.body is not None]):
        publish_added_mass(recorder, matrices, config.dimensions)
    return recorder.program()


def wave_height(systems: Sequence[WaveSystem]) -> float:
    """√2 standard deviations [m] of the elevation: the amplitude of a regular wave."""
    return math.sqrt(sum(float(np.sum(system.configured()[1] ** 2)) for system in systems))


def doubts(config: MorisonConfig, systems: Sequence[WaveSystem]) -> Iterator[str]:
    """Lines on waves that there are not, thick members, and what may count twice."""
    for text in (text for system in systems for text in system.doubts({})):
        yield f"warning: {text}"
    for text in current_doubts(config.current, has_waves=bool(systems)):
        yield f"warning: {text}"
    thickest = max(config.members, key=lambda name: config.members[name].diameter)
    diameter = config.members[thickest].diameter
    shortest = min((system.length for system in systems), default=float("inf"))
    if diameter > SLENDER * shortest:
        yield (
            f"warning: {thickest} is {diameter:g} m thick, the waves are {shortest:.3g} m long: it "
            f"scatters them, and Morison's equation holds up to {SLENDER:g} of their length"
        )
    heavy = [n for n, m in config.members.items() if m.body and m.inertia_coefficient > 0.0]
    if heavy:
        yield (
            f"{', '.join(heavy)}: forces of waves on the volume of these members are in here; of a "
            "part that a hydrodynamics component has too, they count twice: give such members "
            "'added_mass: 0, inertia: 0'"
        )


def _record_loads(
    recorder: Recorder,
    config: MorisonConfig,
    body: str,
    members: Mapping[str, Member],
    moves: BodyMotion,
    flow: RecordedFlow,
    surface: float,
) -> None:
    """Outputs of the members of a body, and of their sum."""
    drag, inertia = (ZERO, ZERO), (ZERO, ZERO)
    for name, member in members.items():
        known = record_coefficients(recorder, name, member)
        load = member_load(member, known, moves, flow, surface)
        _record_member(recorder, config, name, load)
        turning = (ZERO, ZERO) if body == FIXED else turning_load(member, moves, flow)
        drag = _sum(drag, load.drag)
        inertia = _sum(_sum(inertia, load.inertia), turning)
    whole = f"of the water on the members of {body} about its centre of gravity, less added_mass"
    if body == FIXED:
        whole = "of the water on the fixed members about the reference point"
    _record_wrench(recorder, config, f"{body}.", _sum(drag, inertia), whole)
    part = f"part of {body}'s: drag"
    _record_wrench(recorder, config, f"{body}.drag_", drag, part)
    part = f"part of {body}'s: acceleration of the water"
    _record_wrench(recorder, config, f"{body}.inertia_", inertia, part)


def _sum(one: tuple[Vector, Vector], other: tuple[Vector, Vector]) -> tuple[Vector, Vector]:
    return add(one[0], other[0]), add(one[1], other[1])


def _record_wrench(
    recorder: Recorder,
    config: MorisonConfig,
    prefix: str,
    wrench: tuple[Vector, Vector],
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
