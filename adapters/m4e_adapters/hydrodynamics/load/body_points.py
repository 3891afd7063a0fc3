"""Points of bodies above the waves: their height over the undisturbed surface, the air gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import BodyPoint
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.heading import Axes, Number, reference_places
from m4e_adapters.hydrodynamics.load.motions import Motions
from m4e_fmi.program import Recorder, Variable, cos, sin


@dataclass(frozen=True)
class OnBody:
    """A point `name` of body number `body`; `arm` (x, y, z) [m] leads there from the centre of
    gravity, in the axes in which hulls are drawn."""

    name: str
    body: int
    arm: tuple[float, float, float]

    def place(self, coefficients: Coefficients, reference: Axes | None) -> tuple[Number, Number]:
        """Its place (x, y) [m] in the reference pose, whose heading has the axes `reference`."""
        if reference is None:
            x, y, _ = coefficients.places[self.body].tolist()
            return x + self.arm[0], y + self.arm[1]
        x, y = reference_places(coefficients.centers, reference)[self.body]
        along, across, *_ = reference.to_world([*self.arm, 0.0, 0.0, 0.0])
        return x + along, y + across


def points_on_bodies(
    coefficients: Coefficients, points: Mapping[str, BodyPoint]
) -> tuple[OnBody, ...]:
    """The configured points, whose `at` is their place in the reference pose with heading 0."""
    found = []
    for name, point in points.items():
        body = list(coefficients.bodies).index(point.body)
        center = coefficients.places[body].tolist()
        x, y, z = (p - c for p, c in zip(point_in_space(point.at), center, strict=True))
        found.append(OnBody(name, body, (x, y, z)))
    return tuple(found)


def record_air_gaps(
    recorder: Recorder,
    coefficients: Coefficients,
    moved: Motions,
    points: Sequence[OnBody],
    elevations: Sequence[Number],
) -> None:
    """Outputs `<point>.elevation` and `<point>.air_gap`; `elevations` are those at the points."""
    for point, elevation in zip(points, elevations, strict=True):
        own = coefficients.own(point.body)
        x, y, z = point.arm
        angles = {
            motion.name: angle
            for motion, angle in zip(coefficients.body_motions, moved.position[own], strict=True)
            if motion.is_rotation
        }
        roll, pitch = angles.get("roll", 0.0), angles["pitch"]
        height = cos(pitch) * (sin(roll) * y + cos(roll) * z) - sin(pitch) * x
        heave = moved.displacement[own][coefficients.heave]
        height = height + heave + float(coefficients.places[point.body][2])
        text = f"undisturbed water at the reference place of {point.name}"
        recorder.output(Variable(f"{point.name}.elevation", "m", text), elevation)
        text = f"height of {point.name} above the undisturbed water at its reference place"
        recorder.output(Variable(f"{point.name}.air_gap", "m", text), height - elevation)
