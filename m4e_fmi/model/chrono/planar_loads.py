"""Moments and rotational springs from Chrono's, of what moves in the X–Z plane: all about Y."""

from __future__ import annotations

import math

from m4e_fmi.model.chrono.functions import times
from m4e_fmi.model.chrono.loads import Loads
from m4e_fmi.model.chrono.mechanism import SMALL, LeavesPlaneError, parallel
from m4e_fmi.model.chrono.planar import PlanarMechanism
from m4e_fmi.model.chrono.rotation import Vector3
from m4e_fmi.model.chrono.sections import BodyLoadSection, MotorSection, RsdaSection
from m4e_fmi.model.elements import GROUND, Quantity
from m4e_fmi.model.loads import BodyForce, TorsionDamper, TorsionSpring
from m4e_fmi.model.names import identifier


class PlanarLoads(Loads[PlanarMechanism]):
    """Loads in the plane; LeavesPlaneError where one leads out of it."""

    def _twisted(self, rsda: RsdaSection, name: str, free: float) -> None:
        sense, ends = _about_y(rsda.axis), (self._name(rsda.body1), self._name(rsda.body2))
        stiffness, damping = rsda.spring_coefficient, rsda.damping_coefficient
        poses = [self.mechanism.poses[self.mechanism.holder(b)] for b in (rsda.body1, rsda.body2)]
        if stiffness or not damping:
            angle = poses[1].angle - poses[0].angle + sense * free
            self._add(name, TorsionSpring(ends, stiffness or 0.0, angle))
        if damping:
            self._add(f"{name}_damper" if stiffness else name, TorsionDamper(ends, damping))

    def _torque(self, motor: MotorSection, effort: Quantity) -> None:
        sense = _about_y(motor.axis)
        ends = [(motor.body1, sense), (motor.body2, -sense)]
        moving = [(b, factor) for b, factor in ends if self.mechanism.holder(b) != GROUND]
        for suffix, (body, factor) in zip(("", "_back"), moving, strict=False):
            name = identifier(motor.name) + suffix
            self._add(name, BodyForce(self._name(body), moment=times(factor, effort)))

    def _body_torque(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        if max(abs(vector[0]), abs(vector[2])) > SMALL * math.hypot(*vector):
            raise LeavesPlaneError
        name = identifier(load.name)
        self._add(name, BodyForce(self._name(load.body), moment=times(vector[1], scale)))


def _about_y(axis: Vector3) -> float:
    """1 or −1, as an axis leads to +Y or −Y."""
    if not parallel(axis, (0, 1, 0)):
        raise LeavesPlaneError
    return math.copysign(1.0, axis[1])
