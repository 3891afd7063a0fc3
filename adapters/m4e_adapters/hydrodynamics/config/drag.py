"""Drag of a body."""

from __future__ import annotations

from typing import Literal

from m4e_adapters.hydrodynamics.config.numbers import NotNegative
from m4e_fmi.files.document import Section


class LinearDrag(Section):
    """Linear drag: `surge`, `sway`, `heave` in N/(m/s), `roll`, `pitch`, `yaw` in N.m/(rad/s)."""

    surge: NotNegative = 0.0
    sway: NotNegative = 0.0
    heave: NotNegative = 0.0
    roll: NotNegative = 0.0
    pitch: NotNegative = 0.0
    yaw: NotNegative = 0.0


class Drag(Section):
    """Quadratic drag F = −c |v| v at the centre of gravity, and `linear` drag −c v.

    `surge`, `sway`, `heave` in N/(m/s)2, `roll`, `pitch`, `yaw` in N.m/(rad/s)2. Default 0: none.
    Sway, roll and yaw are motions of space. With `water: moving` v is the velocity relative to the
    water, waves and current, at the centre of gravity in the reference pose; rotations stay
    relative to water at rest. With `water: still` it is that of the body. Default: moving, if there
    is a current, otherwise still.
    """

    surge: NotNegative = 0.0
    sway: NotNegative = 0.0
    heave: NotNegative = 0.0
    roll: NotNegative = 0.0
    pitch: NotNegative = 0.0
    yaw: NotNegative = 0.0
    linear: LinearDrag = LinearDrag()
    water: Literal["still", "moving"] | None = None

    @property
    def feels_current(self) -> bool:
        """True of drag in a horizontal motion, in moving water."""
        slows = any((self.surge, self.sway, self.linear.surge, self.linear.sway))
        return slows and self.water != "still"


OF_SPACE = ("sway", "roll", "yaw")


def drag_beyond_the_plane(drag: Drag) -> list[tuple[str, ...]]:
    """Keys of motions that are of space."""
    found: list[tuple[str, ...]] = []
    for motion in OF_SPACE:
        found += [(motion,)] if motion in drag.model_fields_set else []
        found += [("linear", motion)] if motion in drag.linear.model_fields_set else []
    return found
