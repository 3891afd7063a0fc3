"""Start values of free attitudes, which are quaternions, by roll, pitch and yaw."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from m4e_fmi.joints.joint_type import ATTITUDE, QUATERNION, attitude, quaternion_of
from m4e_fmi.space import Rotation


def angles_of_attitudes(names: Iterable[str], known: Collection[str]) -> list[str]:
    """Those of `names` that are an angle, as body.hull.theta, of a quaternion that is `known`."""
    split = ((name, *name.rpartition(".")[::2]) for name in names)
    return [
        name
        for name, owner, part in split
        if part in ATTITUDE and all(f"{owner}.{e}" in known for e in QUATERNION)
    ]


def with_quaternions(values: Mapping[str, float], starts: Mapping[str, float]) -> dict[str, float]:
    """`values` with quaternions in place of angles [rad]; of an attitude, what is not given stays.

    `starts` has the present values of the quaternions. ValueError names an attitude that is given
    in both ways.
    """
    given = angles_of_attitudes(values, starts)
    result = {name: value for name, value in values.items() if name not in given}
    for owner in dict.fromkeys(name.rpartition(".")[0] for name in given):
        quaternion = [f"{owner}.{part}" for part in QUATERNION]
        both = [name for name in quaternion if name in values]
        if both:
            raise ValueError(f"{both[0]} is given, too; give either angles or all of e0 … e3")
        present = attitude(Rotation.of_quaternion([starts[name] for name in quaternion]))
        angles = (
            values.get(f"{owner}.{part}", now) for part, now in zip(ATTITUDE, present, strict=True)
        )
        result |= zip(quaternion, quaternion_of(*angles), strict=True)
    return result


def no_attitudes(values: Mapping[str, float]) -> list[str]:
    """Owners of quaternions among `values` that are zero, and so no attitude."""
    owners = (name.removesuffix(".e0") for name in values if name.endswith(".e0"))
    parts = ((owner, [values.get(f"{owner}.{e}", 1.0) for e in QUATERNION]) for owner in owners)
    return [owner for owner, quaternion in parts if not any(quaternion)]
