"""The load of the water with the forces of waves as inputs, for its response to any wave.

In place of a sea the program has the inputs `wave.elevation_input` and, in the axes of the heading,
`<body>.wave_force_…`; `HullWaves` has what they are for waves of any frequency and direction. The
parameters of the configured sea stay.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.heading import Axes, reference_places
from m4e_adapters.hydrodynamics.load.drag import InWater
from m4e_adapters.hydrodynamics.seas.excitation import excitation_of
from m4e_adapters.hydrodynamics.seas.sea import (
    ELEVATION_INPUT,
    HullsInSea,
    RecordedSea,
    record_elevation_input,
)
from m4e_adapters.hydrodynamics.seas.system_seas import SystemWaves
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import velocity_per_amplitude, wavenumber
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Number, RecordedWaves
from m4e_fmi.program import Recorder, Variable


@dataclass(kw_only=True)
class HullWaves(SystemWaves):
    """Forces of waves on the hulls of `coefficients`: `m4e_fmi.analysis.response.WaveForces`.

    Waves and bodies `in_water` are those of the load that is recorded.
    """

    coefficients: Coefficients
    in_water: Sequence[InWater] = ()

    @property
    def inputs(self) -> list[str]:
        """The elevation at x = y = 0, the force on each motion of each body,
        and the velocity of the water at each body that has drag against it."""
        return [ELEVATION_INPUT, *(v.name for part in self._variables() for v in part)]

    def _variables(self) -> tuple[list[Variable], list[Variable]]:
        """Forces and velocities."""
        c = self.coefficients
        text = "force of waves, in the axes of the heading"
        forces = [
            Variable(f"{body}.wave_{motion.force}", motion.force_unit, text)
            for body in c.bodies
            for motion in c.body_motions
        ]
        text = "velocity of the water in waves at the reference place of the body, world frame"
        velocities = [
            Variable(f"{c.bodies[body.body]}.wave_velocity_{axis}", "m/s", text)
            for body in self.in_water
            for axis in ("xyz" if c.dimensions == 3 else "xz")
        ]
        return forces, velocities

    def record(
        self,
        recorder: Recorder,
        waves: Sequence[WaveSystem],
        coefficients: Coefficients,
        hulls: HullsInSea,
    ) -> RecordedSea:
        """Record the inputs in place of a sea, as `sea.record_sea`.

        Other than of a sea, how hulls meet the waves is asked for by `per_amplitude` only.
        """
        self.systems, self.in_water = waves, hulls.in_water
        for system in waves:
            system.record(recorder, in_space=coefficients.dimensions == 3)
        record_elevation_input(recorder, coefficients.dimensions)
        forces, given = ([recorder.input(v) for v in part] for part in self._variables())
        if coefficients.dimensions == 2:
            triples = [(x, 0.0, z) for x, z in zip(given[::2], given[1::2], strict=True)]
        else:
            triples = [*zip(given[::3], given[1::3], given[2::3], strict=True)]
        return RecordedSea([*forces], velocities=tuple(triples))

    def per_amplitude(
        self, omega: np.ndarray, directions: np.ndarray, values: Mapping[str, float]
    ) -> np.ndarray:
        """Each input per amplitude, (k, m), for waves of `omega` (k,) [rad/s].

        They travel to `directions` (k,) [rad]. InputError for one that the coefficients are not
        for.
        """
        c, heading, reference = self.coefficients, 0.0, None
        places: Sequence[tuple[Number, Number]] = ()
        if c.dimensions == 3:
            reference = Axes.at(values["heading"])
            places = reference_places(c.centers, reference)
            heading = values["heading"]
        forces = np.zeros((len(omega), len(c.motions)), dtype=complex)
        number = wavenumber(omega, depth=c.depth, gravity=c.gravity)
        for own, known in _directed(c, directions, heading):
            count = int(own.sum())
            mean = float(directions[own][0]) if count else 0.0
            waves = RecordedWaves(
                omega=omega[own].tolist(),
                number=number[own].tolist(),
                amplitude=[1.0] * count,
                phase=[0.0] * count,
                direction=mean,
                offsets=directions[own] - mean,
                ramp=1.0,
            )
            found = excitation_of(known, waves, heading=heading, places=places)
            table = np.array(found, dtype=float)
            forces[own] = table[..., 0] + 1j * table[..., 1]
        columns = [np.ones((len(omega), 1)), forces]
        for body in self.in_water:
            x, y, z = (float(value) for value in body.place(c, reference, ()))
            flow = velocity_per_amplitude(
                omega, directions, (x, y, z), depth=c.depth, number=number
            )
            columns.append(flow if c.dimensions == 3 else flow[:, [0, 2]])
        return np.concatenate(columns, axis=1)


def _directed(
    coefficients: Coefficients, directions: np.ndarray, heading: float
) -> Iterator[tuple[np.ndarray, Coefficients]]:
    """Which of the waves to `directions` (k,) [rad] the coefficients are for; in turn for all."""
    if coefficients.has_harmonics:
        yield np.full(len(directions), True), coefficients
        return
    for direction in np.unique(directions).tolist():
        known = coefficients.towards(math.degrees(direction - heading))
        yield directions == direction, known
