"""The outputs of the FMU: loads on all hulls by name, and what is odd about them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import TypedDict

import numpy as np

from .hull_load import HullLoad, IncidentWaves, Load

POSE = ("x", "y", "z", "phi", "theta", "psi")
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
OF_PLANE = ("force_x", "force_z", "moment_y")


class HullData(TypedDict):
    """A hull called `name`: the arguments of `HullLoad`, `neutral_mass` [kg], and the `y` [m] that
    it keeps in the plane.
    """

    name: str
    vertices: list[list[float]]
    triangles: list[list[int]]
    neutral_mass: float
    y: float


class PressureData(TypedDict):
    """All hulls, `weight` ρ g [N/m3], 2 or 3 `dimensions`, `depth` [m]; `waves`, None if still."""

    bodies: list[HullData]
    weight: float
    dimensions: int
    depth: float
    waves: dict[str, list[float] | float] | None


class HullOutputs:
    """The hulls of `data`: their loads follow time and pose at once."""

    def __init__(self, data: PressureData) -> None:
        self._bodies, self._depth = data["bodies"], data["depth"]
        self._waves = IncidentWaves(data["waves"]) if data["waves"] else None
        self._forces = OF_PLANE if data["dimensions"] == 2 else FORCES
        self._hulls = [
            HullLoad(body["vertices"], body["triangles"], weight=data["weight"], waves=self._waves)
            for body in self._bodies
        ]
        self._told: set[tuple[str, str]] = set()
        self._last: dict[str, Load] = {}

    def at(self, given: Mapping[str, float], time: float) -> dict[str, float]:
        """All outputs at `time` [s] for the `given` inputs, by name, SI.

        ValueError for a pose without a finite pressure.
        """
        found: dict[str, float] = {}
        for body, hull in zip(self._bodies, self._hulls, strict=True):
            name = body["name"]
            kept = {"y": body["y"], "phi": 0.0, "psi": 0.0}  # in the plane
            pose = [
                given[place] if (place := f"{name}.{key}") in given else kept[key] for key in POSE
            ]
            load = self._last[name] = hull.at(pose[:3], pose[3:], time)
            if not isfinite(sum(pose) + load.hydrostatic.sum() + load.froude_krylov.sum()):
                raise ValueError(f"{name} has no finite pressure at x, y, z = {pose[:3]} m")
            found[f"{name}.neutral_mass"] = body["neutral_mass"]
            found |= {f"{name}.{key}": value for key, value in self._of(load)}
        if self._waves:
            found["wave.elevation"] = float(self._waves.elevation(np.zeros((1, 2)), time)[0])
        return found

    def _of(self, load: Load) -> Iterator[tuple[str, float]]:
        """Outputs of one body."""
        parts = {"": load.hydrostatic + load.froude_krylov, "hydrostatic_": load.hydrostatic}
        if self._waves:
            parts["froude_krylov_"] = load.froude_krylov
            yield "water_level", load.water_level
        for part, wrench in parts.items():
            for force, value in zip(FORCES, wrench.tolist(), strict=True):
                if force in self._forces:
                    yield f"{part}{force}", value
        yield "wetted_volume", load.wetted_volume

    def doubts(self, time: float) -> Iterator[str]:
        """Hulls that have left the water or touch the bed where `at` was asked last; each once."""
        for name, load in self._last.items():
            if load.wetted_volume <= 0.0 and self._is_new(name, "dry"):
                yield f"{name} is wholly out of the water (t = {time:.4g} s): no force on it"
            if load.lowest < -self._depth and self._is_new(name, "aground"):
                yield (
                    f"{name} reaches down to z = {load.lowest:.4g} m (t = {time:.4g} s), below the "
                    f"sea bed at z = {-self._depth:.4g} m: the bed exerts no force on it"
                )

    def _is_new(self, name: str, doubt: str) -> bool:
        known = (name, doubt) in self._told
        self._told.add((name, doubt))
        return not known
