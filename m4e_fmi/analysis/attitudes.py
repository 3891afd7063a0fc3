"""Free attitudes in linear analysis: three small rotations in place of a quaternion's four numbers.

A change of attitude is a rotation vector θ in world axes: e becomes ½ (0, θ) e, to first order. So
what is linear in the four numbers of a quaternion becomes linear in three, and its length, which
has no effect, is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from m4e_fmi.joints import QUATERNION, TURNING
from m4e_fmi.program import Program, Variable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

ROTATIONS = ("rotation_x", "rotation_y", "rotation_z")


@dataclass(frozen=True)
class Attitude:
    """A free attitude: indices of its quaternion (4) and angular velocity (3) among the states."""

    owner: str
    quaternion: tuple[int, ...]
    turning: tuple[int, ...]

    @cached_property
    def rotations(self) -> tuple[Variable, ...]:
        """The small rotations about X, Y, Z of the world, as variables."""
        text = "Small rotation from the operating point, about +"
        return tuple(
            Variable(f"{self.owner}.{name}", "rad", text + name[-1].upper()) for name in ROTATIONS
        )


def attitudes(program: Program) -> list[Attitude]:
    """The free attitudes among the states of a program."""
    place = {v.name: k for k, v in enumerate(program.states)}
    owners = [name.removesuffix(".e0") for name in place if name.endswith(".e0")]
    found = []
    for owner in owners:
        e, omega = ([f"{owner}.{part}" for part in parts] for parts in (QUATERNION, TURNING))
        if all(name in place for name in (*e, *omega)):
            indices = (tuple(place[name] for name in names) for names in (e, omega))
            found.append(Attitude(owner, *indices))
    return found


def tangent_of(e: Sequence[float] | Floats) -> Floats:
    """T (4, 3): T θ is the change of the quaternion `e` (4,) by small rotations θ [rad]."""
    w, x, y, z = e
    return 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])


def rotated(e: Floats, step: Floats) -> Floats:
    """The quaternion `e` (4,) turned by the rotation vector `step` (3,) [rad], of length 1."""
    angle = float(np.linalg.norm(step))
    axis = step / angle if angle else step
    w, (x, y, z) = np.cos(angle / 2), np.sin(angle / 2) * axis
    turn: Any = [[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]]
    turned = np.array(turn) @ e
    return turned / np.linalg.norm(turned)
