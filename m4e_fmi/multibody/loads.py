"""Forces, moments and efforts of loads, their power and their potential, over any scalar.

A load between two bodies resists the growth of a distance, of a twist or of a joint's displacement:
where it acts decides which, its kind how strongly. A part of the resistance may have a potential;
the power of all else changes the total energy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from m4e_fmi.model import (
    BodyDrag,
    BodyForce,
    Bushing,
    JointEffort,
    JointFriction,
    JointStop,
    PointDrag,
    PointForce,
    TensionDamper,
    TensionSpring,
    TensionStop,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.elements import quantity, vector
from m4e_fmi.model.expression import NOTHING
from m4e_fmi.model.loads import Load
from m4e_fmi.model.potential import potential
from m4e_fmi.model.quantity import quantities_of
from m4e_fmi.multibody.topology import MotionValues, in_space
from m4e_fmi.program import AnyScalar, atan2, maximum, minimum, sign, tanh
from m4e_fmi.space import (
    ABOUT_Y,
    TURN,
    ZERO,
    Rotation,
    Vector,
    Y,
    added,
    dot,
    is_zero,
    minus,
    norm,
    plus,
    scaled,
    subtracted,
)

_BetweenPoints = TensionSpring | TensionDamper | TensionStop | Bushing
_Elastic = TensionSpring | TorsionSpring | TensionStop | JointStop | Bushing

FORCES, MOMENTS = ("force_x", "force_y", "force_z"), ("moment_x", "moment", "moment_z")


@dataclass(frozen=True)
class _Action:
    """A force [N] in world axes at a named point, or at a body's CG with a moment [N·m].

    Or the effort [N·m or N] of a joint along its coordinate of some `number`, which acts on its
    child and back on its parent.
    """

    force: Vector = ZERO
    point: str = ""
    body: str = ""
    moment: Vector = ZERO
    joint: str = ""
    number: int = 0
    effort: AnyScalar = 0


@dataclass(frozen=True)
class Acting:
    """Effect of a load in a state: `actions`; its `potential` energy [J], 0 if it has none.

    `power` [W] is the rate at which it changes the total energy: that of its actions, less what
    comes out of the potential. It is the integer 0 for a load that has a potential only. `measures`
    are what the load exerts and what it depends on, by the names of the outputs: see
    `load_outputs`.
    """

    actions: list[_Action]
    power: AnyScalar = 0
    potential: AnyScalar = 0
    measures: Mapping[str, AnyScalar] = field(default_factory=dict)


@dataclass(frozen=True)
class _Resistance:
    """Resistance to the growth of a length or angle: all of it, and what of it has no potential.

    `measures` are those of `Acting` that only this kind of load has.
    """

    total: AnyScalar
    lost: AnyScalar
    potential: AnyScalar = 0
    measures: Mapping[str, AnyScalar] = field(default_factory=dict)


def acting(load: Load, motion: MotionValues) -> Acting:
    """Effect of `load` in a state."""
    if isinstance(load, BodyForce | PointForce | BodyDrag | PointDrag):
        return _applied(load, motion)
    if isinstance(load, TorsionSpring | TorsionDamper):
        return _twisting(load, motion)
    if isinstance(load, JointEffort | JointFriction | JointStop):
        return _in_joint(load, motion)
    return _between_points(load, motion)


def _applied(load: BodyForce | PointForce | BodyDrag | PointDrag, motion: MotionValues) -> Acting:
    """A force in world or body axes, or drag."""
    at_body = isinstance(load, BodyForce | BodyDrag)
    state = motion.state
    body = load.body if at_body else state.model.points[load.point].body
    frame = state.frame(body)
    velocity = frame.velocity if at_body else state.points[load.point].velocity
    torque = ZERO
    if isinstance(load, BodyDrag | PointDrag):
        wind = subtracted(velocity, _vector(load, "flow", motion))
        force = scaled(-_value(load, "coefficient", motion) * norm(wind), wind)
        if isinstance(load, BodyDrag):
            resistance = -_value(load, "moment_coefficient", motion)
            parts = [part for part in frame.omega if not is_zero(part)]
            # |ω|; of a turn about one coordinate axis without a root
            speed = abs(parts[0]) if len(parts) == 1 else norm(frame.omega)
            torque = scaled(resistance * speed, frame.omega)
    else:
        force = _vector(load, "force", motion)
        if isinstance(load, BodyForce):
            if isinstance(load.moment, (tuple, list)):
                torque = _vector(load, "moment", motion)
            else:  # about +Y
                torque = 0, _value(load, "moment", motion), 0
        if load.axes == "body":
            force, torque = frame.rotation(force), frame.rotation(torque)
    power = dot(force, velocity)
    measures = _named(FORCES, force, motion)
    if not at_body:
        return Acting([_Action(force, point=load.point)], power, measures=measures)
    power = plus(power, dot(torque, frame.omega))
    measures = {**measures, **_named(MOMENTS, torque, motion)}
    return Acting([_Action(force, body=body, moment=torque)], power, measures=measures)


def _between_points(load: _BetweenPoints, motion: MotionValues) -> Acting:
    """A tension along the line between two points, or what needs no line.

    Where the points coincide a tension has no direction, and is no force.
    """
    start, end = (motion.state.points[name] for name in load.points)
    line, apart = subtracted(end.position, start.position), subtracted(end.velocity, start.velocity)
    if isinstance(load, Bushing):
        return _held_together(load, motion, line, apart)
    if isinstance(load, TensionSpring) and load.law is None and quantity(load, "length") == NOTHING:
        return _held_together(load, motion, line, apart)
    length = norm(line)
    rate = dot(apart, line) / length
    found = _resistance(load, motion, length, rate)
    measures = {"tension": found.total, "distance": length, "distance_rate": rate}
    return _resisting(found, rate, _opposite(load, scaled(found.total / length, line)), measures)


def _held_together(
    load: Bushing | TensionSpring, motion: MotionValues, line: Vector, rate: Vector
) -> Acting:
    """Stiffness and damping against any motion of one point from the other: no distance divides."""
    stiffness = _value(load, "stiffness", motion)
    elastic = scaled(stiffness, line)
    power, potential = 0, dot(elastic, line) / 2
    force, lost = elastic, None
    if isinstance(load, Bushing) and quantity(load, "damping") != NOTHING:
        lost = scaled(_value(load, "damping", motion), rate)
        force = added(elastic, lost)
    if not _is_constant(load, motion):
        lost, potential = force, 0
    if lost is not None:
        power = -dot(lost, rate)
    extension = norm(line)
    measures = {**_named(FORCES, force, motion), "extension": extension}
    if isinstance(load, TensionSpring):
        measures = {"tension": stiffness * extension, "extension": extension}
    return Acting(_opposite(load, force), power, potential, measures)


def _opposite(load: _BetweenPoints, force: Vector) -> list[_Action]:
    """`force` on the first point of a load, the opposite on the second."""
    first, second = load.points
    return [_Action(force, point=first), _Action(scaled(-1, force), point=second)]


def _twisting(load: TorsionSpring | TorsionDamper, motion: MotionValues) -> Acting:
    """A moment about +Y in the plane; in space along the rotation vector, or against turning."""
    first, second = (motion.state.frame(name) for name in load.bodies)
    apart = subtracted(second.omega, first.omega)
    if motion.state.tree.is_planar:
        axis, twist, rate = ABOUT_Y, minus(second.angle, first.angle), apart[Y]
    elif isinstance(load, TorsionDamper):
        rate = norm(apart)
        axis, twist = scaled(1 / rate, apart), 0
    else:
        vector = _rotation_vector(first.rotation, second.rotation)
        twist = norm(vector)
        axis = scaled(1 / twist, vector)
        rate = dot(apart, axis)
    found = _resistance(load, motion, twist, rate)
    moment = scaled(found.total, axis)
    actions = [
        _Action(body=load.bodies[0], moment=moment),
        _Action(body=load.bodies[1], moment=subtracted(ZERO, moment)),
    ]
    measures = {"moment": found.total, "twist_rate": rate}
    return _resisting(found, rate, actions, measures)


def _in_joint(load: JointEffort | JointFriction | JointStop, motion: MotionValues) -> Acting:
    number = motion.state.link(load.joint).joint_type.number_of(load.along)
    position, rate = motion.state.joint(load.joint, number)
    found = _resistance(load, motion, position, rate)
    action = _Action(joint=load.joint, number=number, effort=-found.total)
    return _resisting(found, rate, [action], {"effort": action.effort})


def _resisting(
    found: _Resistance, rate: AnyScalar, actions: list[_Action], measures: Mapping[str, AnyScalar]
) -> Acting:
    lossless = isinstance(found.lost, int)
    power = 0 if lossless else -(found.lost * rate)
    return Acting(actions, power, found.potential, {**measures, **found.measures})


def _resistance(load: Load, motion: MotionValues, s: AnyScalar, rate: AnyScalar) -> _Resistance:
    """Resistance of `load` to the growth of `s`."""
    return _RESISTANCES[type(load)](load, motion, s, rate)


def _spring(
    load: TensionSpring | TorsionSpring, motion: MotionValues, s: AnyScalar, rate: AnyScalar
) -> _Resistance:
    rest, name = ("length", "extension") if isinstance(load, TensionSpring) else ("angle", "twist")
    extension = s - _value(load, rest, motion)
    measures = {name: extension}
    if load.law is not None:
        force, energy = _by_law(load, motion, extension, rate)
    else:
        force = _value(load, "stiffness", motion) * extension
        energy = force * extension / 2 if _is_constant(load, motion) else None
    if energy is None:
        return _Resistance(force, force, measures=measures)
    return _Resistance(force, 0, energy, measures)


def _by_law(
    load: TensionSpring | TorsionSpring, motion: MotionValues, e: AnyScalar, rate: AnyScalar
) -> tuple[AnyScalar, AnyScalar]:
    """Tension or moment, and its potential energy; None if none is known."""
    law, (variable, speed) = quantity(load, "law"), load.law_variables
    values = motion.with_(**{variable: e, speed: rate})
    energy = None
    if _is_constant(load, motion, allowed=variable):
        energy = potential(law, variable)
    return law.evaluate(values), None if energy is None else energy.evaluate(values)


def _damper(
    load: TensionDamper | TorsionDamper, motion: MotionValues, s: AnyScalar, rate: AnyScalar
) -> _Resistance:
    del s
    if load.law is None:
        force = _value(load, "damping", motion) * rate
    else:
        (speed,) = load.law_variables
        force = quantity(load, "law").evaluate(motion.with_(**{speed: rate}))
    return _Resistance(force, force)


def _stop(
    load: TensionStop | JointStop, motion: MotionValues, s: AnyScalar, rate: AnyScalar
) -> _Resistance:
    """Nothing between the limits; beyond, stiffness and a damping that it bounds."""
    stiffness, damping = (_value(load, name, motion) for name in ("stiffness", "damping"))
    total, lost, energy, gap = 0, 0, 0, None
    for name, side in (("lower", -1), ("upper", 1)):
        if getattr(load, name) is None:
            continue
        limit = _value(load, name, motion)
        room = limit - s if side > 0 else s - limit
        gap = room if gap is None else minimum(gap, room)
        depth = maximum(0, s - limit if side > 0 else limit - s)
        back = stiffness * depth
        energy = energy + back * depth / 2
        if quantity(load, "damping") != NOTHING:
            # at rest without contact both bounds and the rate are 0, where minimum and maximum have
            # derivatives by the rate: sign has none, and is 0 there
            speed = sign(depth) * (rate if side > 0 else -rate)
            more = minimum(maximum(damping * speed, -back), back)
            lost = lost + more if side > 0 else lost - more
            back = back + more
        total = total + back if side > 0 else total - back
    if not _is_constant(load, motion):
        return _Resistance(total, total, measures={"gap": gap})
    return _Resistance(total, lost, energy, {"gap": gap})


def _friction(
    load: JointFriction, motion: MotionValues, s: AnyScalar, rate: AnyScalar
) -> _Resistance:
    del s
    force = _value(load, "effort", motion) * tanh(rate / _value(load, "velocity", motion))
    return _Resistance(force, force)


def _effort(load: JointEffort, motion: MotionValues, s: AnyScalar, rate: AnyScalar) -> _Resistance:
    del s, rate
    force = -_value(load, "effort", motion)
    return _Resistance(force, force)


_RESISTANCES: dict[type, Callable[..., _Resistance]] = {
    TensionSpring: _spring,
    TorsionSpring: _spring,
    TensionDamper: _damper,
    TorsionDamper: _damper,
    TensionStop: _stop,
    JointStop: _stop,
    JointFriction: _friction,
    JointEffort: _effort,
}


def _value(load: Load, name: str, motion: MotionValues) -> AnyScalar:
    return quantity(load, name).evaluate(motion)


def _vector(load: Load, name: str, motion: MotionValues) -> Vector:
    return in_space(vector(load, name), motion)


def _rotation_vector(first: Rotation, second: Rotation) -> Vector:
    """The turn from the axes of one body to those of another [rad], in world axes, up to 180°."""
    M = [[dot(to, of) for of in first.rows] for to in second.rows]
    twice_sine = (minus(M[2][1], M[1][2]), minus(M[0][2], M[2][0]), minus(M[1][0], M[0][1]))
    sine = norm(twice_sine)
    angle = atan2(sine, plus(plus(M[0][0], M[1][1]), minus(M[2][2], 1)))
    return scaled(angle / sine, twice_sine)


def _named(names: Sequence[str], vector: Vector, motion: MotionValues) -> dict[str, AnyScalar]:
    """The parts of a force or moment that the model has, by the names of outputs."""
    first = 0 if names is FORCES else TURN
    return {names[c]: vector[c] for c in range(TURN) if first + c in motion.state.tree.components}


def _is_constant(load: _Elastic, motion: MotionValues, *, allowed: str = "") -> bool:
    """True if all scalars of the load depend on parameters only, or a law on the allowed name."""
    given = [name for name in quantities_of(load) if getattr(load, name) is not None]
    names = frozenset().union(*(quantity(load, name).names() for name in given))
    return names <= {*motion.state.model.parameters, allowed}
