"""Moments and rotational springs from Chrono's, of what moves in space."""

from __future__ import annotations

from m4e_fmi.model.chrono.functions import scaled, times
from m4e_fmi.model.chrono.loads import Loads
from m4e_fmi.model.chrono.mechanism import Joining, unit
from m4e_fmi.model.chrono.rotation import Vector3
from m4e_fmi.model.chrono.sections import BodyLoadSection, MotorSection, RsdaSection
from m4e_fmi.model.chrono.spatial import SpatialMechanism
from m4e_fmi.model.chrono.tree import Branch
from m4e_fmi.model.elements import GROUND, Quantity
from m4e_fmi.model.loads import BodyForce
from m4e_fmi.model.names import identifier

HINGES = ("revolute", "cylindrical")
NOTHING = (0.0, 0.0, 0.0)


class SpatialLoads(Loads[SpatialMechanism]):
    """Loads in space: a moment between two moving bodies acts about the hinge that joins them."""

    def _twisted(self, rsda: RsdaSection, name: str, free: float) -> None:
        """An effort about the hinge: Chrono's angle, that of body2 against body1, is its own."""
        branch = self._hinge(rsda.body1, rsda.body2, rsda.axis)
        if branch is None:
            message = "a rotational spring or damper needs a hinge about its axis"
            remedy = "join its two bodies by a REVOLUTE joint with this axis, or use tsdas"
            self.places.say(rsda, message, ("axis",), remedy)
            return
        joint = f"joint.{self.mechanism.joint_of[branch.child]}"
        own = self._coordinate(branch, "rad")
        rest = self.mechanism.angles[branch.child]
        rest += self._sense(branch, rsda.body2, rsda.axis) * free
        twist = f"{joint}.{own.position}" if rest == 0 else f"({joint}.{own.position} {-rest:+})"
        coefficients = (rsda.spring_coefficient, twist), (
            rsda.damping_coefficient, f"{joint}.{own.velocity}"
        )  # fmt: skip
        terms = [f"{value!r}*{motion}" for value, motion in coefficients if value]
        self._effort(name, branch, "rad", f"-({' + '.join(terms)})" if terms else 0.0)

    def _torque(self, motor: MotorSection, effort: Quantity) -> None:
        name = identifier(motor.name)
        branch = self.mechanism.branch_of(motor) or self._hinge(
            motor.body1, motor.body2, motor.axis
        )
        if branch is not None:
            sense = self._sense(branch, motor.body1, motor.axis)
            self._effort(name, branch, "rad", times(sense, effort))
        elif self.mechanism.holder(motor.body2) == GROUND:
            self._moment(name, motor.body1, scaled(unit(motor.axis), effort))
        elif self.mechanism.holder(motor.body1) == GROUND:
            axis = self.mechanism.in_body(motor.body2, unit(motor.axis))
            self._moment(name, motor.body2, scaled(axis, times(-1.0, effort)), local=True)
        else:
            message = "a torque without a spindle between two moving bodies cannot be represented"
            remedy = "let body2 be fixed, or use 'spindle: REVOLUTE'"
            self.places.say(motor, message, ("spindle",), remedy)

    def _body_torque(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        name = identifier(load.name)
        own = self.mechanism.in_body(load.body, vector) if load.local_load else vector
        self._moment(name, load.body, scaled(own, scale), local=load.local_load)

    def _moment(
        self, name: str, body: str, moment: tuple[Quantity, ...], *, local: bool = False
    ) -> None:
        axes = "body" if local else "world"
        self._add(name, BodyForce(self._name(body), NOTHING, moment, axes))

    def _hinge(self, body1: str, body2: str, axis: Vector3) -> Branch[Joining] | None:
        """The joint that lets two bodies turn about an axis against each other, and no other."""
        ends = {self.mechanism.holder(body1), self.mechanism.holder(body2)}
        for branch in self.mechanism.branches:
            turns = self.mechanism.kind(branch.joining).name in HINGES
            if turns and self.mechanism.is_along(branch, ends, axis):
                return branch
        return None
