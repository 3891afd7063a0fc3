"""Members with what waves do to them as inputs, for the response to any wave.

Forces of the water's acceleration and of the pressure on buoyant members are linear in the waves:
each member has its own as inputs `<member>.wave_force_…`. They are those of waves of small height
at the pose about which the response is: up to the still water, and by the change of buoyancy with
the surface there. Drag is not linear: inputs are the velocities of the water at its points,
`<member>.wave_velocity_…`, in axes that turn with the member.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import (
    MOTIONS,
    places_in_space,
    point_in_space,
)
from m4e_adapters.hydrodynamics.seas.sea import ELEVATION_INPUT
from m4e_adapters.hydrodynamics.seas.system_seas import SystemWaves
from m4e_adapters.hydrodynamics.seas.water.kinematics import velocity_per_amplitude, wavenumber
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedFlow
from m4e_adapters.morison.config import Member, MorisonConfig
from m4e_adapters.morison.loads import (
    NO_LOAD,
    Load,
    MemberLoad,
    buoyant_load,
    drag_at,
    joined,
)
from m4e_adapters.morison.motion import Axis, BodyMotion, axis_of
from m4e_adapters.morison.strips import Coefficients, boundaries, load_points
from m4e_adapters.morison.vectors import ZERO, Number, Vector, add, difference, scaled
from m4e_fmi.errors import InputError
from m4e_fmi.program import Recorder, Variable

COARSER = 3
"""Segments of a member over those for the drag here."""
NEAR = 0.1
"""Of the largest height or depth of a member: from there on segments are longer (`boundaries`)."""
RISE = 1e-6
"""Of the surface, m, for the change of buoyancy with it."""


Direction = tuple[float, float, float]
"""A unit vector in the reference pose."""


def still(x: Number, y: Number) -> Number:
    """Elevation of still water [m]."""
    del x, y
    return 0.0


def parts_of(member: Member, segments: int) -> list[float]:
    """Places [m] on the member between which its `segments` are here."""
    return boundaries(member, NEAR * max(abs(end[-1]) for end in member.ends), segments)


def drag_places(member: Member) -> list[float]:
    """Those for the drag, which are fewer."""
    return parts_of(member, math.ceil(member.segments / COARSER))


def drag_directions(member: Member, dimensions: int) -> list[tuple[str, Direction]]:
    """Directions, in the reference pose, in which the velocity of the water has drag, by name."""
    first, second = (np.array(point_in_space(end)) for end in member.ends)
    along = (second - first) / member.length
    across = np.array([along[2], 0.0, -along[0]])
    if dimensions == 3:
        across = np.cross(np.eye(3)[int(np.argmin(np.abs(along)))], along)
        across /= np.linalg.norm(across)
    found = [("a", across)]
    if dimensions == 3:
        found.append(("b", np.cross(along, across)))
    if member.tangential_drag > 0.0 or member.end_drag > 0.0:
        found.append(("along", along))
    return [(name, (float(v[0]), float(v[1]), float(v[2]))) for name, v in found]


def drag_count(member: Member) -> int:
    """The number of points at which a member has drag here."""
    ends = 2 if member.end_drag > 0.0 or member.end_added_mass > 0.0 else 0
    return 3 * (len(drag_places(member)) - 1) + ends


def wave_inputs(config: MorisonConfig, name: str) -> Iterator[Variable]:
    """The inputs that stand for the waves on a member, in order of `MemberWaves`."""
    member = config.members[name]
    for part in ("", "buoyancy_") if member.is_buoyant else ("",):
        for motion in MOTIONS[config.dimensions]:
            text = f"{part}{motion.force} of small waves on {name}, about the centre of its body"
            yield Variable(f"{name}.wave_{part}{motion.force}", motion.force_unit, text)
    for way, _ in drag_directions(member, config.dimensions):
        for k in range(drag_count(member)):
            text = f"velocity of the water in waves, of one of the points of {name}"
            yield Variable(f"{name}.wave_velocity_{way}[{k + 1}]", "m/s", text)


def load_in_waves(
    recorder: Recorder,
    config: MorisonConfig,
    name: str,
    known: Coefficients,
    body: BodyMotion,
    flow: RecordedFlow,
) -> MemberLoad:
    """The load on a member in still water and a current (`flow`), and in waves that are inputs."""
    member = config.members[name]
    given: list[Number] = [recorder.input(v) for v in wave_inputs(config, name)]
    wrenches = [_wrench(config, given)]
    if member.is_buoyant:
        wrenches.append(_wrench(config, given))
    count, velocities = drag_count(member), given
    ways = [body.turned(way) for _, way in drag_directions(member, config.dimensions)]
    axis, density = axis_of(member, body), flow.water.density
    drag: Load = NO_LOAD
    wet: Number = 0.0
    points = load_points(member, known, axis, body, drag_places(member), still, density)
    for k, point in enumerate(points):
        parts = [scaled(velocities[k + j * count], way) for j, way in enumerate(ways)]
        x, y = flow.current.velocity(body.place[2] + point.arm[2])
        water = add((x, y, 0.0), *parts)
        drag = joined(drag, drag_at(point, axis, difference(water, body.velocity_at(point.arm))))
        wet = wet + point.length
    weight = density * flow.water.gravity
    lifted = buoyant_load(member, axis, body, [0.0, member.length], [0.0, 0.0], weight)
    for wrench in wrenches[1:]:
        lifted = joined(lifted, wrench)
    return MemberLoad(drag, wrenches[0], lifted, wet)


def _wrench(config: MorisonConfig, given: list[Number]) -> Load:
    """The load of the first of the `given` inputs, which are removed."""
    found: list[Number] = [0.0] * 6
    for place in places_in_space(config.dimensions):
        found[place] = given.pop(0)
    return (found[0], found[1], found[2]), (found[3], found[4], found[5])


@dataclass(kw_only=True)
class MemberWaves(SystemWaves):
    """Waves on the members of `config`: `m4e_fmi.analysis.response.WaveForces`."""

    config: MorisonConfig

    @property
    def inputs(self) -> list[str]:
        """The elevation at x = y = 0, and of each member the loads and velocities."""
        names = (v.name for name in self.config.members for v in wave_inputs(self.config, name))
        return [ELEVATION_INPUT, *names]

    def per_amplitude(
        self, omega: np.ndarray, directions: np.ndarray, values: Mapping[str, float]
    ) -> np.ndarray:
        """Each input per amplitude, (k, m) [SI], for waves of `omega` (k,) [rad/s].

        They travel to `directions` (k,) [rad]. InputError for drag along a member that has none in
        its configuration.
        """
        water = _Water(self.config, omega, directions)
        columns = [np.ones((len(omega), 1), dtype=complex)]
        for name, member in self.config.members.items():
            body = _pose(self.config, member.body, values)
            columns.append(self._load(water, name, body, values))
            columns.append(self._velocities(water, name, body, values))
        return np.concatenate(columns, axis=1)

    def _load(
        self, water: _Water, name: str, body: BodyMotion, values: Mapping[str, float]
    ) -> np.ndarray:
        """Of small waves on a member, (k, motions) [N, N.m] per m; then of its buoyancy."""
        member, density = self.config.members[name], self.config.water.density
        axis, along = _numeric(member, body)
        known = _known(name, member, values)
        places = parts_of(member, member.segments)
        total = np.zeros((len(water.omega), 6), dtype=complex)
        for point in load_points(member, known, axis, body, places, still, density):
            push = water.acceleration(_place(body, point.arm))
            tangential = (push @ along)[:, None] * along
            push = point.mass_across * (push - tangential) + point.mass_along * tangential
            arm = np.array(point.arm, dtype=float)
            total += np.concatenate([push, np.cross(arm, push)], axis=1)
        kept = places_in_space(self.config.dimensions)
        if not member.is_buoyant:
            return total[:, kept]
        lifted = np.zeros_like(total)
        for k, s in enumerate(places):
            change = self._risen(member, axis, body, places, k)
            lifted += water.crest(_place(body, axis.at(s)))[:, None] * change
        return np.concatenate([total[:, kept], lifted[:, kept]], axis=1)

    def _risen(
        self, member: Member, axis: Axis, body: BodyMotion, places: Sequence[float], number: int
    ) -> np.ndarray:
        """Change (6,) of the buoyancy with the surface at one of the `places`, [N/m, N]."""
        weight = self.config.water.density * self.config.water.gravity
        found = []
        for rise in (RISE, -RISE):
            levels = [rise if k == number else 0.0 for k in range(len(places))]
            load = buoyant_load(member, axis, body, places, levels, weight)
            found.append(np.array([*load[0], *load[1]], dtype=float))
        return (found[0] - found[1]) / (2.0 * RISE)

    def _velocities(
        self, water: _Water, name: str, body: BodyMotion, values: Mapping[str, float]
    ) -> np.ndarray:
        """Velocities of the water at the points of a member, (k, inputs) [1/s]."""
        config, member = self.config, self.config.members[name]
        ways = drag_directions(member, config.dimensions)
        known = _known(name, member, values)
        if known.tangential_drag > 0.0 and ways[-1][0] != "along":
            message = f"{name}.tangential_drag is changed from 0"
            raise InputError.single(message, "give the member a tangential_drag in its file")
        axis, _ = _numeric(member, body)
        points = load_points(
            member, known, axis, body, drag_places(member), still, config.water.density
        )
        flows = [water.velocity(_place(body, point.arm)) for point in points]
        columns = [
            flow @ np.array(body.turned(way), dtype=float) for _, way in ways for flow in flows
        ]
        return np.stack(columns, axis=1)


class _Water:
    """Waves of `omega` (k,) [rad/s] to `directions` (k,) [rad], of amplitude 1 m."""

    def __init__(self, config: MorisonConfig, omega: np.ndarray, directions: np.ndarray) -> None:
        self.omega, self._directions, self._depth = omega, directions, config.water.depth
        self._number = wavenumber(omega, depth=self._depth, gravity=config.water.gravity)

    def velocity(self, place: tuple[float, float, float]) -> np.ndarray:
        """(k, 3) [1/s] at a place (x, y, z) [m]."""
        return velocity_per_amplitude(
            self.omega, self._directions, place, depth=self._depth, number=self._number
        )

    def acceleration(self, place: tuple[float, float, float]) -> np.ndarray:
        """(k, 3) [1/s2]."""
        return -1j * self.omega[:, None] * self.velocity(place)

    def crest(self, place: tuple[float, float, float]) -> np.ndarray:
        """The elevation there per amplitude (k,) [1]."""
        x, y, _ = place
        way = x * np.cos(self._directions) + y * np.sin(self._directions)
        return np.exp(1j * self._number * way)


def _pose(config: MorisonConfig, body: str | None, values: Mapping[str, float]) -> BodyMotion:
    """A body where `values` have it, or what the moments on fixed members are about."""
    if body is None:
        point = point_in_space(config.reference_point or (0.0, 0.0))
        return BodyMotion(point, point)
    center = point_in_space(config.bodies[body].center_of_gravity)
    names = ("x", "y", "z", "phi", "theta", "psi")
    starts = dict(zip(names, (*center, *ZERO), strict=True))
    x, y, z, phi, theta, psi = (
        float(values.get(f"{body}.{name}", start)) for name, start in starts.items()
    )
    return BodyMotion(center, (x, y, z), angles=(phi, theta, psi))


def _known(name: str, member: Member, values: Mapping[str, float]) -> Coefficients:
    """The coefficients of a member, where `values` have them."""
    return Coefficients(
        drag=values.get(f"{name}.drag", member.drag),
        tangential_drag=values.get(f"{name}.tangential_drag", member.tangential_drag),
        inertia=values.get(f"{name}.inertia", member.inertia_coefficient),
        end_drag=values.get(f"{name}.end_drag", member.end_drag),
    )


def _numeric(member: Member, body: BodyMotion) -> tuple[Axis, np.ndarray]:
    """The axis, and its unit vector (3,) [1]."""
    axis = axis_of(member, body)
    return axis, np.array(axis.along, dtype=float)


def _place(body: BodyMotion, arm: Vector) -> tuple[float, float, float]:
    x, y, z = np.array(add(body.place, arm), dtype=float).tolist()
    return x, y, z
