"""Checks of single joints: their types, axes and start values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import get_args

from m4e_fmi.errors import suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.joints import JOINT_TYPES, JointType
from m4e_fmi.model.elements import GROUND, AngleReference, Axes, Joint
from m4e_fmi.model.findings import (
    Known,
    ModelFinding,
    Names,
    expressions,
    quantities,
    reference,
    vectors,
)
from m4e_fmi.space import AXES

SPACES = {2: "the plane", 3: "space"}
AXES_OF_JOINTS = ("direction", "axis", "second_axis")
PARALLEL = 1e-9
"""Cosine of a right angle, and what a cosine is less than 1, that rounding can have made."""


def joint_findings(
    at: Location, joint: Joint, names: Names, known: Known
) -> Iterator[ModelFinding]:
    """Everything wrong with a joint."""
    yield from reference((*at, "child"), joint.child, names.bodies, "bodies")
    yield from reference((*at, "parent"), joint.parent, names.bodies | {GROUND}, "bodies")
    yield from quantities(at, joint, known)
    types = JOINT_TYPES[known.dimensions]
    if joint.type not in types:
        remedy = suggestion(joint.type, types, "types")
        message = f"unknown type {joint.type!r}"
        if joint.type in JOINT_TYPES[3]:
            message = f"a {joint.type} joint is one of space, and the model is planar"
            remedy = f"write 'dimensions: 3' on top, or take another type: {', '.join(types)}"
        yield ModelFinding((*at, "type"), message, remedy)
        return
    if joint.parent == joint.child and joint.child in names.bodies:
        message = f"the joint joins body {joint.child!r} to itself"
        yield ModelFinding((*at, "parent"), message, "name another body, or ground")
    if types[joint.type].is_free:
        yield from _of_free(at, joint, types)
    yield from _axes(at, joint, known.dimensions)
    if joint.reaction_axes not in get_args(Axes):
        remedy = suggestion(joint.reaction_axes, get_args(Axes))
        yield ModelFinding((*at, "reaction_axes"), f"unknown axes {joint.reaction_axes!r}", remedy)
    if joint.coordinate is not None and joint.coordinate not in get_args(AngleReference):
        message = f"unknown coordinate {joint.coordinate!r}"
        remedy = suggestion(joint.coordinate, get_args(AngleReference))
        yield ModelFinding((*at, "coordinate"), message, remedy)
    elif not types[joint.type].chooses_angle and (
        joint.coordinate == "relative" or (joint.coordinate and known.dimensions == 3)
    ):
        message = f"in {SPACES[known.dimensions]} a {joint.type} joint has no coordinate to choose"
        yield ModelFinding((*at, "coordinate"), message, "leave it out")
    for field in types[joint.type].vectors:
        if getattr(joint, field) is not None:
            yield from vectors((*at, field), getattr(joint, field), known)
    for key, value in joint.initial.items():
        keys = types[joint.type].start_keys
        if key not in keys:
            message = f"a {joint.type} joint has no initial {key!r}"
            remedy = suggestion(key, keys) or "leave it out"
            yield ModelFinding((*at, "initial", key), message, remedy)
        yield from expressions((*at, "initial", key), value, known)


def _of_free(at: Location, joint: Joint, types: Mapping[str, JointType]) -> Iterator[ModelFinding]:
    if joint.parent != GROUND:
        message = f"a {joint.type} joint is always to the ground"
        yield ModelFinding((*at, "parent"), message, "leave 'parent' out")
    for field in ("parent_to_joint", "joint_to_child"):
        if getattr(joint, field) not in ((0.0, 0.0), [0.0, 0.0]):
            message = f"a {joint.type} joint has no {field}"
            place = "x, z" if types is JOINT_TYPES[2] else "x, y, z"
            remedy = f"give the start position under 'initial': {place}"
            yield ModelFinding((*at, field), message, remedy)


def _axes(at: Location, joint: Joint, dimensions: int) -> Iterator[ModelFinding]:
    for field in AXES_OF_JOINTS:
        needed = field in JOINT_TYPES[dimensions][joint.type].vectors
        if needed == (getattr(joint, field) is not None):
            continue
        verb, remedy = "has no", "leave it out"
        if needed:
            verb, remedy = "needs", f"add '{field}: {'[x, y, z]' if dimensions == 3 else '[x, z]'}'"
        message = f"in {SPACES[dimensions]} a {joint.type} joint {verb} {field!r}"
        yield ModelFinding((*at, field), message, remedy)


def axis_findings(
    at: Location, joint: Joint, computed: Mapping[Location, float]
) -> Iterator[ModelFinding]:
    """Axes without a length, and pairs of them that leave a joint without a freedom."""
    known: dict[str, list[float]] = {}
    for field in AXES_OF_JOINTS:
        count = len(getattr(joint, field) or ())
        entries = [computed.get((*at, field, k), math.nan) for k in range(count)]
        if entries and not any(entries):
            words, example = field.replace("_", " "), "[1, 0]" if count == 2 else "[1, 0, 0]"
            yield ModelFinding(
                (*at, field), f"the {words} has no length", f"give a vector such as {example}"
            )
        elif len(entries) == len(AXES):
            known[field] = [entry / math.hypot(*entries) for entry in entries]
    axis, second, direction = (known.get(field) for field in ("axis", "second_axis", "direction"))
    if axis and second and abs(_dot(axis, second)) > 1 - PARALLEL:
        message = "both axes are the same: the joint has one freedom only"
        yield ModelFinding((*at, "second_axis"), message, "give another axis, or a revolute joint")
    if axis and direction and abs(_dot(axis, direction)) > PARALLEL:
        message = "the direction is not at right angles to the axis"
        yield ModelFinding((*at, "direction"), message, "give a direction in the plane")


def _dot(a: Iterable[float], b: Iterable[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))
