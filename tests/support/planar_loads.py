"""Random loads of every kind, and what they do by virtual work, to any number of digits.

The reference computes displacements as functions of the coordinates, and their rates and the work
along them as difference quotients; expressions are read by Python itself.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import mpmath

from m4e_fmi.model import (
    BodyDrag,
    BodyForce,
    Bushing,
    Joint,
    JointEffort,
    JointFriction,
    JointStop,
    PointDrag,
    PointForce,
    Table,
    TensionDamper,
    TensionSpring,
    TensionStop,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.loads import Load

if TYPE_CHECKING:
    from support.planar_trees import Numbers, Reference

Function = Callable[[list[Any]], Any]

TABLES = {"gust": Table((-1.0, 0.0, 0.5, 2.5), (0.0, 3.0, -1.0, 1.0))}
"""With slopes that doubles hold exactly."""


def random_loads(numbers: Numbers, joints: Mapping[str, Joint]) -> dict[str, Load]:
    """Loads of all kinds; points p0 … p3 and a far `anchor` must be there."""
    r, pair, between = numbers.random, numbers.pair, numbers.between
    bodies = [joint.child for joint in joints.values()]
    first, second = (r.choice(bodies) for _ in range(2))
    ends = ("ground" if first == second else first, second)
    moving = [name for name, joint in joints.items() if joint.type in ("revolute", "prismatic")]
    signals = ["t", "gust", f"body.{first}.theta", f"body.{second}.vx", "point.p0.vz", "point.p1.x"]
    signals += [f"joint.{name}.{variable}" for name in moving for variable in "qu"]

    def varying() -> str:
        """An expression in a parameter and something that changes."""
        form = r.choice(["{a}*{s}", "{a} + sin({s})", "{a}*tanh({s}) - {s}", "{a}*abs({s})"])
        return form.format(a=between(0.1, 1), s=r.choice(signals))

    k, c, l0 = between(0.1, 1), between(0.1, 1), between(40, 60)
    spring_laws = [f"{k}*l*abs(l)", f"{k}*l + {c}*ld*abs(l)", f"{k}*tanh(l) + {c}*max(0, l)", "3*l"]
    twist_laws = [
        f"{k}*sin(theta)", f"{k}*theta**3 + {c}*theta", f"{k}*theta + {c}*thetad + t", "gust*theta"
    ]  # fmt: skip
    loads: dict[str, Load] = {
        "spring": TensionSpring(("anchor", "p0"), k, between(48, 50)),
        "damper": TensionDamper(("p1", "anchor"), c),
        "rope": TensionStop(("p0", "anchor"), k, None, l0, c),
        "bumper": TensionStop(("p2", "anchor"), k, l0, None, r.choice([c, 0.0])),
        "rubber_foot": Bushing(("p1", "anchor"), between(0.01, 0.1), between(0.1, 1)),
        "winch": TensionSpring(("p3", "anchor"), varying(), l0),
        "rubber": TensionSpring(("anchor", "p3"), length=l0, law=r.choice(spring_laws)),
        "valve": TensionDamper(("p2", "anchor"), law=f"{k}*ld*abs(ld)"),
        "twist": TorsionSpring(ends, between(0.1, 2), between(-1, 1)),
        "brake": TorsionDamper(ends, between(0.1, 2)),
        "coil": TorsionSpring(ends, angle=between(-1, 1), law=r.choice(twist_laws)),
        "oil": TorsionDamper(ends, law=f"{c}*tanh(thetad)*{varying()}"),
        "push": PointForce("p2", pair()),
        "blow": PointForce("p1", ("gust", varying()), "body"),
        "lift": BodyForce(second, pair(), between(-1, 1)),
        "steer": BodyForce(first, (varying(), varying()), varying(), "body"),
        "keel": BodyDrag(second, between(0.1, 1), between(0.1, 1), (varying(), "gust")),
        "sail": PointDrag("p0", between(0.1, 1), pair()),
    }
    if moving:
        joint = r.choice(moving)
        loads |= {
            "motor": JointEffort(joint, varying()),
            "rub": JointFriction(joint, between(0.1, 1), between(0.1, 1)),
            "hit": JointStop(joint, k, between(-0.5, -0.1), between(0.1, 0.5), c),
            "end": JointStop(r.choice(moving), varying(), None, between(-0.2, 0.2)),
        }
    kept = r.sample(sorted(loads), k=min(len(loads), 10))
    return {name: load for name, load in loads.items() if name in kept}


def work(reference: Reference, load: Load, along: list[Any]) -> Any:
    """Work of `load` along a change of the coordinates."""
    if isinstance(load, BodyForce | PointForce | BodyDrag | PointDrag):
        return _applied(reference, load, along)
    if isinstance(load, Bushing):
        return sum(_held(reference, load, axis, along) for axis in (0, 1))
    s = _resisted(reference, load)
    return -_resistance(reference, load, s) * reference.slope(s, along)


def _applied(
    reference: Reference, load: BodyForce | PointForce | BodyDrag | PointDrag, along: list[Any]
) -> Any:
    point = "" if isinstance(load, BodyForce | BodyDrag) else load.point
    body = load.body if isinstance(load, BodyForce | BodyDrag) else _body(reference, point)

    def axis(k: int) -> Function:
        if k < 2 and point:
            return lambda q: reference.point(point, q)[k]
        return lambda q: reference.pose(body, q)[k]

    moment: Any = 0
    if isinstance(load, BodyDrag | PointDrag):
        flow = [number(reference, part) for part in load.flow]
        wind = [reference.slope(axis(k), reference.u) - flow[k] for k in (0, 1)]
        scale = -number(reference, load.coefficient) * mpmath.hypot(*wind)
        force = [scale * part for part in wind]
        if isinstance(load, BodyDrag):
            omega = reference.slope(axis(2), reference.u)
            moment = -number(reference, load.moment_coefficient) * abs(omega) * omega
    else:
        force = [number(reference, part) for part in load.force]
        if load.axes == "body":
            theta = reference.pose(body, reference.q)[2]
            (x, z), c, s = force, mpmath.cos(theta), mpmath.sin(theta)
            force = [c * x + s * z, c * z - s * x]
        if isinstance(load, BodyForce):
            moment = number(reference, load.moment)
    parts = (*force, moment)
    return sum(parts[k] * reference.slope(axis(k), along) for k in (0, 1, 2))


def _held(reference: Reference, load: Bushing, axis: int, along: list[Any]) -> Any:
    """Effect of a bushing along one axis of the world."""

    def way(q: list[Any]) -> Any:
        first, second = (reference.point(name, q)[axis] for name in load.points)
        return second - first

    force = number(reference, load.stiffness) * way(reference.q)
    force += number(reference, load.damping) * reference.slope(way, reference.u)
    return -force * reference.slope(way, along)


def _body(reference: Reference, point: str) -> str:
    return reference.model.points[point].body


def _resisted(reference: Reference, load: Any) -> Function:
    """The distance, twist or displacement whose growth a load resists."""
    if isinstance(load, TorsionSpring | TorsionDamper):
        first, second = load.bodies
        return lambda q: reference.pose(second, q)[2] - reference.pose(first, q)[2]
    if isinstance(load, JointEffort | JointFriction | JointStop):
        return displacement(reference, load.joint)

    def length(q: list[Any]) -> Any:
        ends = [reference.point(name, q) for name in load.points]
        return mpmath.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])

    return length


def displacement(reference: Reference, name: str) -> Function:
    """Of a joint's child against its parent."""
    joint = reference.model.joints[name]
    if joint.type == "revolute":
        return lambda q: reference.pose(joint.child, q)[2] - reference.pose(joint.parent, q)[2]
    (k,) = reference.tree.links[reference.tree.index(joint.child)].coordinates
    return lambda q: q[k]


def _resistance(reference: Reference, load: Any, resisted: Function) -> Any:
    s, rate = resisted(reference.q), reference.slope(resisted, reference.u)

    def value(quantity: Any, **more: Any) -> Any:
        return number(reference, quantity, **more)

    match load:
        case TensionSpring():
            l = s - value(load.length)  # noqa: E741
            return value(load.law, l=l, ld=rate) if load.law else value(load.stiffness) * l
        case TorsionSpring():
            theta = s - value(load.angle)
            if load.law:
                return value(load.law, theta=theta, thetad=rate)
            return value(load.stiffness) * theta
        case TensionDamper():
            return value(load.law, ld=rate) if load.law else value(load.damping) * rate
        case TorsionDamper():
            return value(load.law, thetad=rate) if load.law else value(load.damping) * rate
        case JointEffort():
            return -value(load.effort)
        case JointFriction():
            return value(load.effort) * mpmath.tanh(rate / value(load.velocity))
    assert isinstance(load, TensionStop | JointStop)
    total = mpmath.mpf(0)
    for limit, side in ((load.lower, -1), (load.upper, 1)):
        depth = 0 if limit is None else side * (s - value(limit))
        if depth > 0:
            back = value(load.stiffness) * depth
            # back + damping, but the damping is at most as large as back
            more = value(load.damping) * side * rate
            total += side * (back + (more if abs(more) <= abs(back) else mpmath.sign(more) * back))
    return total


def number(reference: Reference, quantity: Any, **more: Any) -> Any:
    """A quantity of a load in the state of the reference."""
    if not isinstance(quantity, str):
        return mpmath.mpf(quantity)
    if quantity in reference.parameters:
        return reference.parameters[quantity]
    names = dict(reference.parameters)
    names |= {name: getattr(mpmath, name) for name in ("sin", "tanh", "sign")}
    names |= {name: interpolated(table, reference.t) for name, table in TABLES.items()}
    names |= {"t": reference.t, "variable": lambda name: variable(reference, name), **more}
    moving = re.compile(r"(joint|body|point)\.\w+\.\w+")
    text = moving.sub(lambda match: f"variable({match[0]!r})", quantity)
    return eval(text, {"abs": abs, "max": max, **names})


def interpolated(table: Table, t: Any) -> Any:
    times, values = ([mpmath.mpf(x) for x in column] for column in (table.times, table.values))
    after: Sequence[int] = [k for k, time in enumerate(times) if time >= t]
    if not after or after[0] == 0:
        return values[-1] if not after else values[0]
    k = after[0]
    share = (t - times[k - 1]) / (times[k] - times[k - 1])
    return values[k - 1] + share * (values[k] - values[k - 1])


def variable(reference: Reference, name: str) -> Any:
    kind, element, part = name.split(".")
    if kind == "joint":
        child = reference.model.joints[element].child
        (k,) = reference.tree.links[reference.tree.index(child)].coordinates
        return {"q": reference.q, "u": reference.u}[part][k]
    place = reference.pose if kind == "body" else reference.point
    axis = {"x": 0, "z": 1, "theta": 2, "vx": 0, "vz": 1, "omega": 2}[part]

    def position(q: list[Any]) -> Any:
        return place(element, q)[axis]

    rate = part in ("vx", "vz", "omega")
    return reference.slope(position, reference.u) if rate else position(reference.q)
