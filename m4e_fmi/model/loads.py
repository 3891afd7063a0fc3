"""Loads of a model. Frozen; quantities are numbers or expressions.

Unlike geometry and masses, loads may depend on the time `t`, on tables, and on the motion: an
expression names variables as the FMU does, `joint.<name>.q` and `u`; `body.<name>.x`, `z`, `theta`,
`vx`, `vz`, `omega`; `point.<name>.x`, `z`, `vx`, `vz`.

`type` is a load's name in files; a quantity that is None is not used. Of the fields in `either`,
one is given.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, TypeAlias, get_args

from m4e_fmi.model.elements import ORIGIN, Axes, Quantity, Vector
from m4e_fmi.model.quantity import given

QuantityOrVector: TypeAlias = "Quantity | Vector"


@dataclass(frozen=True)
class _Described:
    description: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class TensionSpring(_Described):
    """Tension stiffness·l [N] along the line between two points; it pushes, too.

    Where the points coincide the line has no direction and there is no force; of a spring whose
    `length` is the number 0 the force is linear in their distance, there and everywhere.

    The extension l is distance − length. A `law` in `l` and its rate `ld` [m/s] is the tension
    itself.
    """

    points: tuple[str, str]
    stiffness: Quantity | None = given("N/m", None, bound="seldom negative")
    length: Quantity | None = given("m", None, bound="not negative")
    law: Quantity | None = given("N", None)

    type: ClassVar = "tension_spring"
    either: ClassVar = ("stiffness", "law")
    required: ClassVar = ("length",)
    law_variables: ClassVar = ("l", "ld")


@dataclass(frozen=True)
class TensionDamper(_Described):
    """Tension damping·ld [N] along the line between two points, ld their speed apart [m/s].

    A `law` in `ld` is the tension itself.
    """

    points: tuple[str, str]
    damping: Quantity | None = given("N.s/m", None, bound="seldom negative")
    law: Quantity | None = given("N", None)

    type: ClassVar = "tension_damper"
    either: ClassVar = ("damping", "law")
    law_variables: ClassVar = ("ld",)


@dataclass(frozen=True)
class TensionStop(_Described):
    """Keeps the distance of two points above `lower` and below `upper` [m], or one of the two.

    Beyond a limit by d the force back is stiffness·d + damping·ḋ, in which damping never exceeds
    what stiffness does: it grows from zero at contact and never pulls back. (So does ElastoGap of
    the Modelica Standard Library.) A slack rope is a stop with `upper` only.
    """

    points: tuple[str, str]
    stiffness: Quantity = given("N/m", bound="positive")
    lower: Quantity | None = given("m", None, bound="not negative")
    upper: Quantity | None = given("m", None, bound="not negative")
    damping: Quantity = given("N.s/m", 0.0, bound="not negative")

    type: ClassVar = "tension_stop"


@dataclass(frozen=True)
class Bushing(_Described):
    """Holds two points together: force stiffness·r + damping·ṙ [N] on the first one.

    r leads from the first point to the second, in world axes; the second feels the opposite. It is
    linear in r, so the points may coincide and pass through one another.
    """

    points: tuple[str, str]
    stiffness: Quantity = given("N/m", 0.0, bound="seldom negative")
    damping: Quantity = given("N.s/m", 0.0, bound="seldom negative")

    type: ClassVar = "bushing"


@dataclass(frozen=True)
class TorsionSpring(_Described):
    """Moment stiffness·theta [N·m] on the first body, the opposite on the second.

    The twist theta is θ₂ − θ₁ − angle with absolute angles about +Y, 0 for the ground; `angle` is
    θ₂ − θ₁ where the spring rests. A `law` in `theta` and its rate `thetad` [rad/s] is the moment
    itself. In space theta is the angle by which the second body is turned from the first, at most
    180°, and the moment is about the axis of that turn; there `angle` is 0.
    """

    bodies: tuple[str, str]
    stiffness: Quantity | None = given("N.m/rad", None, bound="seldom negative")
    angle: Quantity = given("rad", 0.0)
    law: Quantity | None = given("N.m", None)

    type: ClassVar = "torsion_spring"
    either: ClassVar = ("stiffness", "law")
    law_variables: ClassVar = ("theta", "thetad")


@dataclass(frozen=True)
class TorsionDamper(_Described):
    """Moment damping·thetad [N·m] on the first body, the opposite on the second.

    thetad is ω₂ − ω₁ [rad/s]. A `law` in `thetad` is the moment itself.
    """

    bodies: tuple[str, str]
    damping: Quantity | None = given("N.m.s/rad", None, bound="seldom negative")
    law: Quantity | None = given("N.m", None)

    type: ClassVar = "torsion_damper"
    either: ClassVar = ("damping", "law")
    law_variables: ClassVar = ("thetad",)


@dataclass(frozen=True)
class PointForce(_Described):
    """A force (F_x, F_z) [N] at a point, in world axes or in those of the point's body."""

    point: str
    force: Vector = given("N", is_vector=True)
    axes: Axes = "world"

    type: ClassVar = "point_force"


@dataclass(frozen=True)
class BodyForce(_Described):
    """A force (F_x, F_z) [N] at a centre of gravity, and a moment about +Y [N·m].

    In space both are vectors. They are in world axes or in those of the body.
    """

    body: str
    force: Vector = given("N", ORIGIN, is_vector=True)
    moment: QuantityOrVector = given("N.m", 0.0, counts=(3,))
    axes: Axes = "world"

    type: ClassVar = "body_force"


@dataclass(frozen=True)
class PointDrag(_Described):
    """Force −coefficient·|v|v [N] at a point, v its velocity against the `flow` (world axes, m/s).

    The coefficient is ½ρC_d·area [kg/m].
    """

    point: str
    coefficient: Quantity = given("kg/m", bound="not negative")
    flow: Vector = given("m/s", ORIGIN, is_vector=True)

    type: ClassVar = "point_drag"


@dataclass(frozen=True)
class BodyDrag(_Described):
    """Force −coefficient·|v|v [N] at a centre of gravity and moment −moment_coefficient·|ω|ω [N·m].

    v is the velocity against the `flow` (world axes, m/s). The coefficient is ½ρC_d·area [kg/m].
    """

    body: str
    coefficient: Quantity = given("kg/m", 0.0, bound="not negative")
    moment_coefficient: Quantity = given("N.m.s2/rad2", 0.0, bound="not negative")
    flow: Vector = given("m/s", ORIGIN, is_vector=True)

    type: ClassVar = "body_drag"


@dataclass(frozen=True)
class JointEffort(_Described):
    """Moment [N·m] or force [N] of a joint on its child, along one of the joint's coordinates.

    The opposite acts on the parent. `along` names the coordinate (q1, q2, …) of a joint that has
    several.
    """

    joint: str
    effort: Quantity = given("N.m or N")
    along: str = ""

    type: ClassVar = "joint_effort"


@dataclass(frozen=True)
class JointFriction(_Described):
    """Coulomb friction, made smooth: effort −`effort`·tanh(rate/`velocity`) of a joint.

    The rate is that of the child against the parent, whatever the joint's coordinate. `effort` is
    the friction while it slides [N·m or N], reached to 76 % at `velocity` [rad/s or m/s]. `along`
    is as in `JointEffort`.
    """

    joint: str
    effort: Quantity = given("N.m or N", bound="not negative")
    velocity: Quantity = given("rad/s or m/s", bound="positive")
    along: str = ""

    type: ClassVar = "joint_friction"


@dataclass(frozen=True)
class JointStop(_Described):
    """Keeps a joint above `lower` and below `upper` [rad or m], or one of the two.

    What is limited is the child's angle or displacement against its parent, whatever the joint's
    coordinate. The effort back is as in `TensionStop`. `along` is as in `JointEffort`.
    """

    joint: str
    stiffness: Quantity = given("N.m/rad or N/m", bound="positive")
    lower: Quantity | None = given("rad or m", None)
    upper: Quantity | None = given("rad or m", None)
    damping: Quantity = given("N.m.s/rad or N.s/m", 0.0, bound="not negative")
    along: str = ""

    type: ClassVar = "joint_stop"


Load = (
    TensionSpring
    | TensionDamper
    | TensionStop
    | Bushing
    | TorsionSpring
    | TorsionDamper
    | PointForce
    | BodyForce
    | PointDrag
    | BodyDrag
    | JointEffort
    | JointFriction
    | JointStop
)
LOAD_TYPES: dict[str, type[Load]] = {kind.type: kind for kind in get_args(Load)}
