"""Motions of a floating body: surge, heave and pitch in the plane, all six in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

X_Y_PAIRS = (0, 3)  # where vectors over `SPACE` have components along X, those along Y follow


@dataclass(frozen=True)
class Motion:
    """One motion: its variables' last names, and whether it is a rotation."""

    name: str
    position: str
    velocity: str
    force: str
    is_rotation: bool = False

    @property
    def unit(self) -> str:
        """That of the position: m or rad."""
        return "rad" if self.is_rotation else "m"

    @property
    def force_unit(self) -> str:
        """N or N.m."""
        return "N.m" if self.is_rotation else "N"

    @property
    def drag_unit(self) -> str:
        """That of force over velocity squared."""
        return "N.m.s2/rad2" if self.is_rotation else "N.s2/m2"


SURGE = Motion("surge", "x", "vx", "force_x")
SWAY = Motion("sway", "y", "vy", "force_y")
HEAVE = Motion("heave", "z", "vz", "force_z")
ROLL = Motion("roll", "phi", "omega_x", "moment_x", is_rotation=True)
PITCH = Motion("pitch", "theta", "omega", "moment_y", is_rotation=True)
YAW = Motion("yaw", "psi", "omega_z", "moment_z", is_rotation=True)

SPACE = (SURGE, SWAY, HEAVE, ROLL, PITCH, YAW)
PLANE = (SURGE, HEAVE, PITCH)
MOTIONS = {2: PLANE, 3: SPACE}
"""The motions of a body by the number of dimensions; rotations are about +X, +Y, +Z."""


def places_in_space(dimensions: int) -> list[int]:
    """Where the motions of 2 or 3 `dimensions` are among the six."""
    return [SPACE.index(motion) for motion in MOTIONS[dimensions]]


def point_in_space(point: Sequence[float]) -> tuple[float, float, float]:
    """(x, y, z) [m] of a point (x, z) of the plane, or of (x, y, z)."""
    return float(point[0]), float(point[1]) if len(point) > 2 else 0.0, float(point[-1])


def mass_unit(row: Motion, column: Motion) -> str:
    """Unit of force in one motion over acceleration in another."""
    return ("kg", "kg.m", "kg.m2")[row.is_rotation + column.is_rotation]
