"""Motions of bodies with members, and members in them."""

from __future__ import annotations

from dataclasses import dataclass

from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, point_in_space
from m4e_adapters.morison.config import Member
from m4e_adapters.morison.vectors import (
    ZERO,
    Number,
    Vector,
    add,
    cross,
    difference,
    scaled,
    turned,
)
from m4e_fmi.program import Recorder, Variable


@dataclass(frozen=True)
class BodyMotion:
    """A body now: its centre of gravity, or what moments are about, at `place` [m], in the
    reference pose at `reference` [m]; velocity, angular velocity `spin` [rad/s], angles [rad].
    """

    reference: tuple[float, float, float]
    place: Vector
    velocity: Vector = ZERO
    spin: Vector = ZERO
    angles: Vector = ZERO

    def arm(self, point: tuple[float, float, float]) -> Vector:
        """To a point (x, y, z) [m] of the reference pose, as it is turned now [m]."""
        x, y, z = (p - r for p, r in zip(point, self.reference, strict=True))
        return turned((x, y, z), *self.angles)

    def turned(self, vector: tuple[float, float, float]) -> Vector:
        """A vector of the reference pose, as it is turned now."""
        return turned(vector, *self.angles)

    def velocity_at(self, arm: Vector) -> Vector:
        """Of what is at the `arm` [m]."""
        return add(self.velocity, cross(self.spin, arm))


@dataclass(frozen=True)
class Axis:
    """The axis of a member now, from the `arm` [m] of its first end along the unit vector."""

    arm: Vector
    along: Vector
    length: float

    def at(self, s: Number) -> Vector:
        """The arm [m] of the point at `s` [m] from the first end."""
        return add(self.arm, scaled(s, self.along))


def axis_of(member: Member, body: BodyMotion) -> Axis:
    """The axis of a member of the body."""
    first, second = map(point_in_space, member.ends)
    arm = body.arm(first)
    along = scaled(1.0 / member.length, difference(body.arm(second), arm))
    return Axis(arm, along, member.length)


def record_body(recorder: Recorder, body: str, center: tuple[float, ...], dims: int) -> BodyMotion:
    """Inputs of a body: pose and velocity of its centre of gravity."""
    x, y, z = point_in_space(center)
    starts = {"x": x, "y": y, "z": z}
    pose: dict[str, Number] = {"x": x, "y": y, "z": z, "phi": 0.0, "theta": 0.0, "psi": 0.0}
    rates: dict[str, Number] = {}
    for motion in MOTIONS[dims]:
        text = f"{motion.position} of the centre of gravity, world frame"
        if motion.is_rotation:
            text = f"{motion.name} angle from the reference pose"
            text += ", R = R_z(psi) R_y(theta) R_x(phi) from body to world axes" * (dims == 3)
        name, start = f"{body}.{motion.position}", starts.get(motion.position, 0.0)
        pose[motion.position] = recorder.input(Variable(name, motion.unit, text, start=start))
    for motion in MOTIONS[dims]:
        what = "angular velocity" if motion.is_rotation else "velocity"
        of = f"{what} of {motion.name}" if dims == 3 else f"rate of {body}.{motion.position}"
        text = f"{of}, world frame"
        name, unit = f"{body}.{motion.velocity}", f"{motion.unit}/s"
        rates[motion.velocity] = recorder.input(Variable(name, unit, text))
    return BodyMotion(
        reference=(x, y, z),
        place=(pose["x"], pose["y"], pose["z"]),
        velocity=(rates["vx"], rates.get("vy", 0.0), rates["vz"]),
        spin=(rates.get("omega_x", 0.0), rates["omega"], rates.get("omega_z", 0.0)),
        angles=(pose["phi"], pose["theta"], pose["psi"]),
    )
