"""Hydrostatics and righting arms of bodies that their members carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.geometry.hydrostatics import Hydrostatics
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.stability import HEEL, PITCH, Curve
from m4e_adapters.hydrodynamics.stability_report import ANGLES, Stability
from m4e_adapters.morison.buoyancy import displaced_energy
from m4e_adapters.morison.config import Member, MorisonConfig
from m4e_adapters.morison.loads import NO_LOAD, buoyant_load, joined
from m4e_adapters.morison.motion import BodyMotion, axis_of

STEP = 1e-5
"""Of heave [m] and turns [rad], for derivatives."""
Floats = np.ndarray


def stability_of(config: MorisonConfig) -> list[Stability]:
    """Stability of the bodies that have buoyant members which are in the water."""
    floats = (
        Afloat(
            name,
            point_in_space(body.center_of_gravity),
            [m for m in config.of_body(name).values() if m.is_buoyant],
        )
        for name, body in config.bodies.items()
    )
    return [one.stability() for one in floats if one.members and one.wrench(0.0, 0.0, 0.0)[2] > 0.0]


@dataclass(frozen=True)
class Afloat:
    """A body `name` with its centre of gravity at `center` (x, y, z) [m], and buoyant `members`."""

    name: str
    center: tuple[float, float, float]
    members: Sequence[Member]

    def _pose(self, heave: float, heel: float, pitch: float) -> BodyMotion:
        x, y, z = self.center
        return BodyMotion(self.center, (x, y, z + heave), angles=(heel, pitch, 0.0))

    def wrench(self, heave: float, heel: float, pitch: float) -> Floats:
        """Force and moment about the centre of gravity over ρ g, (6,) [m3, m4]."""
        body = self._pose(heave, heel, pitch)
        total = NO_LOAD
        for m in self.members:
            ends = [0.0, m.length]
            total = joined(
                total, buoyant_load(m, axis_of(m, body), body, ends, [0.0, 0.0], weight=1.0)
            )
        return np.array([*total[0], *total[1]], dtype=float)

    def stability(self) -> Stability:
        """Its hydrostatics and righting arms."""
        angles = np.radians(ANGLES)
        curves = {}
        for about in (HEEL, PITCH):
            arms = np.array([self._arm(float(angle), about) for angle in angles])
            curves[about] = Curve(angles, arms)
        return Stability(self.name, self.center, self._hydrostatics(), {}, curves)

    def _hydrostatics(self) -> Hydrostatics:
        """Of the reference pose: moments of the waterplane from derivatives of the moments."""
        x, y, z = self.center
        volume, moments = self._at_rest[2], self._at_rest[3:5]
        body = self._pose(0.0, 0.0, 0.0)
        energy = 0.0
        for m in self.members:
            axis = axis_of(m, body)
            depths = tuple(-(body.place[2] + axis.at(s)[2]) for s in (0.0, m.length))
            given = (float(depths[0]), float(depths[1]))
            energy += float(
                displaced_energy(axis.along, given, radius=m.diameter / 2, length=m.length)
            )
        low = -energy / volume
        heave, heel, pitch = (-self._slope(k) for k in range(3))
        area, aside, along = heave[2], heave[3], -heave[4]
        second = np.array([[pitch[4], -pitch[3]], [-pitch[3], heel[3]]]) - volume * (
            low - z
        ) * np.eye(2)
        return Hydrostatics(
            float(volume),
            (x - float(moments[1] / volume), y + float(moments[0] / volume), low),
            (
                float(area),
                float(along + x * area),
                float(second[0, 0] + 2 * x * along + x * x * area),
            ),
            (
                float(aside + y * area),
                float(second[0, 1] + x * aside + y * along + x * y * area),
                float(second[1, 1] + 2 * y * aside + y * y * area),
            ),
        )

    @property
    def _at_rest(self) -> Floats:
        return self.wrench(0.0, 0.0, 0.0)

    def _slope(self, motion: int) -> Floats:
        """Derivative (6,) of the wrench by heave, heel or pitch."""
        step = STEP * np.eye(3)[motion]
        return (self.wrench(*step) - self.wrench(*-step)) / (2 * STEP)

    def _arm(self, angle: float, about: str) -> float:
        """The righting arm [m] at an angle [rad], with the displacement of the reference pose."""
        from scipy.optimize import brentq

        volume = float(self._at_rest[2])
        turns = (angle, 0.0) if about == HEEL else (0.0, angle)
        far = max(
            float(np.linalg.norm(np.array(point_in_space(end)) - self.center)) + m.diameter
            for m in self.members
            for end in m.ends
        )
        reach = 2.0 * far + abs(self.center[2])

        def excess(heave: float) -> float:
            return float(self.wrench(heave, *turns)[2]) - volume * (1.0 - 1e-12)

        heave = 0.0
        if excess(-reach) > 0.0:
            heave = float(brentq(excess, -reach, reach, xtol=1e-12))
        return -float(self.wrench(heave, *turns)[3 if about == HEEL else 4]) / volume
