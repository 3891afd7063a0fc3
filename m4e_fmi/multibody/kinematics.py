"""Frames of all bodies, over any scalar, at a cost that grows with their number.

Every body has an origin, which is where its joint holds it, such as the hinge of a revolute body or
the centre of gravity of a floating one. `joints` says how each follows from the parent's;
`velocity_transformation` makes the paper's B and Ḃ from the same frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from m4e_fmi.joints import GROUND_FRAME, Frame, Mount
from m4e_fmi.model.elements import vector
from m4e_fmi.model.expression import NOTHING, Expression, Values
from m4e_fmi.multibody.topology import Link, Topology
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import AXES, Vector


def frames(
    tree: Topology, q: Sequence[AnyScalar], u: Sequence[AnyScalar], values: Values
) -> list[Frame]:
    """The frame of every link for coordinates `q` (n,), velocities `u` (n,) in m, rad, per s.

    `values` are those of the parameters by name.
    """
    result: list[Frame] = []
    for link in tree.links:
        mount = Mount(
            parent=result[link.parent] if link.parent >= 0 else GROUND_FRAME,
            q=[q[k] for k in link.coordinates],
            u=[u[k] for k in link.speeds],
            vector=partial(evaluated, link, values),
            is_relative=link.is_relative,
        )
        result.append(link.joint_type.frame(mount))
    return result


def evaluated(link: Link, values: Values, field: str) -> Vector:
    """A vector of a link's joint, such as ``joint_to_child`` [m]."""
    return in_space(vector(link.joint, field), values)


def in_space(parts: Sequence[Expression], values: Values) -> Vector:
    """A vector (x, z) or (x, y, z) of the author's; what he wrote as 0 is always zero."""
    found = [0 if part == NOTHING else part.evaluate(values) for part in parts]
    x, y, z = found if len(found) == len(AXES) else (found[0], 0, found[1])
    return x, y, z
