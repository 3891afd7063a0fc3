"""Vectors, rotations, wrenches, motion subspaces and inertias of the X–Z plane, over any scalar.

The only folder that knows the dimensions of space: joints and algorithms use these types and do not
look inside. World frame X right, Z up; θ > 0 turns +Z towards +X (about +Y). Imports `program`.
Start with `vectors`, then `freedoms`.
"""

from m4e_fmi.space.freedoms import Component, Freedom, Twist
from m4e_fmi.space.inertia import Elimination, Inertia
from m4e_fmi.space.vectors import (
    AXES,
    DOFS,
    TURN,
    ZERO,
    Matrix,
    Rotation,
    Vector,
    Wrench,
    X,
    Z,
    add_force,
    added,
    dot,
    moment,
    norm,
    scaled,
    subtracted,
    swung,
    tilde,
    unit,
)

__all__ = [
    "AXES",
    "DOFS",
    "TURN",
    "ZERO",
    "Component",
    "Elimination",
    "Freedom",
    "Inertia",
    "Matrix",
    "Rotation",
    "Twist",
    "Vector",
    "Wrench",
    "X",
    "Z",
    "add_force",
    "added",
    "dot",
    "moment",
    "norm",
    "scaled",
    "subtracted",
    "swung",
    "tilde",
    "unit",
]
