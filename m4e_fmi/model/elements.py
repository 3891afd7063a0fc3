"""Parameters, bodies, joints and points. Frozen; a quantity is a number or an expression.

In Python an expression may also be one of SymPy.

SI units and radians. World frame: X right, Z up; θ > 0 turns +Z towards +X. Geometry is given in
the pose q = 0, where every body frame (origin at the body's centre of gravity) is parallel to the
world's.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

from m4e_fmi.model.expression import Expression, Values
from m4e_fmi.model.quantity import Quantity, Vector, as_expression, given
from m4e_fmi.units import parse_unit

if TYPE_CHECKING:
    from m4e_fmi.model.shapes import Shape

GROUND = "ground"
NEUTRAL = "neutral"
"""Mass of a body that is that of the water it displaces."""

Inertia: TypeAlias = "Quantity | tuple[Quantity, ...]"
AngleReference = Literal["absolute", "relative"]
Axes = Literal["world", "body"]


def identifier(name: str) -> str:
    """A name of ours for any name: letters, digits and _, a letter first, never `ground`."""
    text = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
    if not text or not text[0].isalpha():
        text = f"n{text}"
    return f"{text}_body" if text == GROUND else text


def quantity(owner: object, name: str) -> Expression:
    """Field `name` of `owner` as an expression."""
    return as_expression(getattr(owner, name))


class _Origin(tuple[float, ...]):
    """The vector of those who give none, which has the dimensions of any model."""

    __slots__ = ()


ORIGIN = _Origin((0.0, 0.0))


def is_origin(value: object) -> bool:
    """True of a vector that was not given."""
    return isinstance(value, _Origin)


def vector(owner: object, name: str) -> tuple[Expression, ...]:
    """Field `name` of `owner`, (x, z) or (x, y, z), as expressions."""
    return tuple(map(as_expression, getattr(owner, name)))


def inertia_of(body: Body) -> tuple[Expression, ...]:
    """The inertia of a body: I_yy in the plane; three moments, or these and I_xy, I_yz, I_zx."""
    entries = body.inertia if isinstance(body.inertia, (tuple, list)) else (body.inertia,)
    return tuple(map(as_expression, entries))


@dataclass(frozen=True)
class Parameter:
    """A named number: `value` in `unit`, converted to SI where it is used.

    A `tunable` one may change while an FMU of the model runs.
    """

    value: float
    unit: str
    description: str = ""
    tunable: bool = False


def parameter_values(parameters: Mapping[str, Parameter]) -> Values:
    """Value of each parameter in SI units."""
    return Values({name: p.value * parse_unit(p.unit).factor for name, p in parameters.items()})


@dataclass(frozen=True)
class Body:
    """A rigid body: mass [kg], inertia about its centre of gravity [kg·m²].

    The inertia is that about Y in the plane. In space it is (I_xx, I_yy, I_zz), or these and the
    entries I_xy, I_yz, I_zx of the tensor, in body axes; I_xy is −∫ x y dm.

    The mass "neutral" is that of the displaced water: a parameter ``body.<name>.neutral_mass``
    without a value, which a hydrodynamics component of a system sets.
    With `added_mass` the model gets an added-mass matrix for this body, to be set from outside
    (hydrodynamics); it acts on the world-frame acceleration of the centre of gravity. In space a
    body may have a `shape`, in which it is drawn.
    """

    mass: Quantity = given("kg", bound="positive")
    inertia: Inertia = given("kg.m2", bound="positive", counts=(3, 6))
    description: str = ""
    added_mass: bool = False
    shape: Shape | None = None

    @property
    def is_neutral(self) -> bool:
        """True if the mass is that of the displaced water."""
        return isinstance(self.mass, str) and self.mass.strip() == NEUTRAL


def neutral_mass(body: str) -> str:
    """Name of the parameter that is the mass of a body with ``mass: neutral``."""
    return f"body.{body}.neutral_mass"


def neutral_symbol(body: str) -> str:
    """Symbol of that parameter in equations."""
    return f"neutral_mass_{body}"


@dataclass(frozen=True)
class Joint:
    """Motion of `child` relative to `parent` that a joint of some `type` allows.

    `parent_to_joint` leads from the parent's centre of gravity (from the origin, for the ground) to
    the joint, `joint_to_child` from there to the child's centre of gravity [m]. `direction` of a
    prismatic joint is fixed in the parent; its length does not matter. A floating joint is to the
    ground and has neither. A fixed joint welds the child to its parent, or to the ground. `initial`
    gives start values: q, u (rad or m, per s) or, for a floating joint, x, z, theta, vx, vz, omega.

    The coordinate q of a revolute joint is the absolute angle of its child, or with `coordinate`
    "relative" that angle less the parent's. The joint's reaction is given in world axes or, with
    `reaction_axes` "body", in those of the child, as loads of a section are.
    """

    type: str
    child: str
    parent: str = GROUND
    parent_to_joint: Vector = given("m", ORIGIN, is_vector=True)
    joint_to_child: Vector = given("m", ORIGIN, is_vector=True)
    direction: Vector | None = None
    coordinate: AngleReference | None = None
    initial: dict[str, Quantity] = field(default_factory=dict)
    description: str = ""
    axis: Vector | None = None
    second_axis: Vector | None = None
    reaction_axes: Axes = "world"


@dataclass(frozen=True)
class Point:
    """A point of `body`, at (x, z) [m] from its centre of gravity (from the origin, if ground)."""

    body: str
    at: Vector = given("m", is_vector=True)
    description: str = ""
