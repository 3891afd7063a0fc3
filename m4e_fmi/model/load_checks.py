"""Checks of single loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, get_args

from m4e_fmi.errors import suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.joints import ATTITUDE, JOINT_TYPES, TURNING
from m4e_fmi.model.elements import GROUND, Axes
from m4e_fmi.model.findings import (
    TIME,
    Complaint,
    Known,
    ModelFinding,
    Names,
    expressions,
    quantities,
    reference,
)
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.loads import JointStop, Load, TensionStop

MOTION = {
    2: {
        "body": ("x", "z", "theta", "vx", "vz", "omega"),
        "point": ("x", "z", "vx", "vz"),
        "joint": ("q", "u"),
    },
    3: {
        "body": ("x", "y", "z", *ATTITUDE, "vx", "vy", "vz", *TURNING),
        "point": ("x", "y", "z", "vx", "vy", "vz"),
        "joint": ("q", "u", "q1", "u1", "q2", "u2", "q3", "u3"),
    },
}
"""Variables of the motion that a load may depend on, by dimensions."""


class LoadChecks:
    """The checks of one model's loads; `model` needs its joints and loads only."""

    def __init__(self, model: Groups, names: Names) -> None:
        self.model = model
        self.names = names
        plain = names.parameters | names.tables | {TIME}
        self.known = Known(plain, self._motion_complaint, model.dimensions)
        self.types = JOINT_TYPES[model.dimensions]
        self.motion = MOTION[model.dimensions]

    def findings(self) -> Iterator[ModelFinding]:
        """All findings on the loads, in the order of the file."""
        for name, load in self.model.loads.items():
            at = ("loads", name)
            yield from self._ends(at, load)
            yield from self._choices(at, load)
            yield from quantities(at, load, self.known, leaving_out=("law",))
            yield from self._law(at, load)

    def _motion_complaint(self, name: str) -> Complaint | None:
        """Complaint about a name like ``joint.hinge.q``; None if it is right."""
        kind, _, rest = name.partition(".")
        element, _, variable = rest.rpartition(".")
        if kind not in self.motion or not element:
            remedy = "the motion is joint.<name>.q, body.<name>.vx, point.<name>.z and the like"
            return f"{name!r} is not declared", remedy
        group = {"body": "bodies", "point": "points", "joint": "joints"}[kind]
        declared = getattr(self.names, group)
        if element not in declared:
            return f"unknown {kind} {element!r} in {name!r}", suggestion(element, declared, group)
        if variable not in self.motion[kind]:
            return f"a {kind} has no {variable!r} here", f"known: {', '.join(self.motion[kind])}"
        joint = self.model.joints.get(element)
        joint_type = self.types.get(joint.type) if kind == "joint" and joint else None
        if joint and joint_type:
            names = [name for c in joint_type.efforts.values() for name in (c.position, c.velocity)]
            if variable not in names:
                remedy = f"use the motion of its body: body.{joint.child}.x, theta, vx, …"
                remedy = f"it has {', '.join(names)}" if names else remedy
                return f"{element!r} is a {joint.type} joint and has no {variable}", remedy
        return None

    def _ends(self, at: Location, load: Any) -> Iterator[ModelFinding]:
        """The bodies, points or joint on which a load acts."""
        names = self.names
        if getattr(load, "body", None) == GROUND:
            message = "a load on the ground moves nothing"
            yield ModelFinding((*at, "body"), message, "name a body, or leave the load out")
        elif hasattr(load, "body"):
            yield from reference((*at, "body"), load.body, names.bodies, "bodies")
        elif hasattr(load, "point"):
            yield from reference((*at, "point"), load.point, names.points, "points")
        elif hasattr(load, "joint"):
            yield from reference((*at, "joint"), load.joint, names.joints, "joints")
            yield from self._along(at, load)
        else:
            yield from self._pair(at, load, "points" if hasattr(load, "points") else "bodies")

    def _along(self, at: Location, load: Any) -> Iterator[ModelFinding]:
        """The coordinate of a joint along which a load acts."""
        joint = self.model.joints.get(load.joint)
        if joint is None or joint.type not in self.types:
            return
        known = [c.position for c in self.types[joint.type].efforts.values()]
        if not known:
            message = f"{load.joint!r} is a {joint.type} joint, on which no effort can act"
            names = [name for name, t in self.types.items() if t.efforts]
            yield ModelFinding(
                (*at, "joint"), message, f"name one that has coordinates: {', '.join(names)}"
            )
        elif load.along and load.along not in known:
            message = f"a {joint.type} joint has no coordinate {load.along!r}"
            yield ModelFinding((*at, "along"), message, f"known: {', '.join(known)}")
        elif len(known) > 1 and not load.along:
            message = f"{load.joint!r} is a {joint.type} joint with {len(known)} coordinates"
            yield ModelFinding(
                at, message, f"add 'along: {known[0]}' or another of {', '.join(known)}"
            )

    def _pair(self, at: Location, load: object, field: str) -> Iterator[ModelFinding]:
        known = self.names.points if field == "points" else self.names.bodies | {GROUND}
        ends = getattr(load, field)
        if len(ends) != 2:
            yield ModelFinding((*at, field), f"expected two {field}, got {len(ends)}")
            return
        for index, end in enumerate(ends):
            place = (*at, field, index)
            yield from reference(place, end, known, field)
        if ends[0] == ends[1]:
            yield ModelFinding((*at, field), f"both ends are {ends[0]!r}", f"name two {field}")

    def _choices(self, at: Location, load: Load) -> Iterator[ModelFinding]:
        """Fields that are missing or exclude each other."""
        for field in getattr(load, "required", ()):
            if getattr(load, field) is None:
                yield ModelFinding(at, f"missing key {field!r}", f"add '{field}: …' here")
        either = getattr(load, "either", ())
        given = [field for field in either if getattr(load, field) is not None]
        if either and len(given) != 1:
            message = f"expected one of {' and '.join(map(repr, either))}, got {len(given)}"
            remedy = "a law is the whole force or moment" if given else f"add '{either[0]}: …' here"
            yield ModelFinding((*at, given[-1]) if given else at, message, remedy)
        if isinstance(load, TensionStop | JointStop) and load.lower is None and load.upper is None:
            yield ModelFinding(at, "a stop without a limit", "add 'lower: …' or 'upper: …' here")
        angle = getattr(load, "angle", 0.0) if self.known.dimensions == 3 else 0.0
        if angle not in (0.0, "0"):
            message = "in space a torsion spring rests where its bodies are parallel"
            remedy = (
                "leave 'angle' out; about a joint use a joint_effort, -k*(joint.NAME.q - angle)"
            )
            yield ModelFinding((*at, "angle"), message, remedy)
        axes = getattr(load, "axes", "world")
        if axes not in get_args(Axes):
            remedy = suggestion(str(axes), get_args(Axes))
            yield ModelFinding((*at, "axes"), f"unknown axes {axes!r}", remedy)

    def _law(self, at: Location, load: object) -> Iterator[ModelFinding]:
        law = getattr(load, "law", None)
        if law is None:
            return
        variables: tuple[str, ...] = getattr(load, "law_variables", ())
        known = replace(self.known, names=self.known.names | set(variables))
        yield from expressions((*at, "law"), law, known)
        for name in sorted(self.names.parameters | self.names.tables):
            if name in variables:
                message = f"{name!r} is what the law depends on, and also a parameter or table"
                yield ModelFinding((*at, "law"), message, "rename the parameter or table")
