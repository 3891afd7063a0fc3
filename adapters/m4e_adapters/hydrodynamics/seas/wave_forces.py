"""The load of the water with the forces of waves as inputs, for its response to any wave.

In place of a sea the program has the inputs `wave.elevation_input` and, in the axes of the heading,
`<body>.wave_force_…`; `HullWaves` has what they are for waves of any frequency and direction. The
parameters of the configured sea stay, and its amplitudes are calculated parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Regular, Still
from m4e_adapters.hydrodynamics.heading import Axes, reference_places
from m4e_adapters.hydrodynamics.seas.sea import (
    AnyWaves,
    Number,
    excitation_in_space,
    record_components,
    record_direction,
    record_ramp,
)
from m4e_adapters.hydrodynamics.seas.waves import component_amplitudes, part_edges
from m4e_fmi.analysis.response import Sea
from m4e_fmi.program import Recorder, Scalar, Variable

ELEVATION = "wave.elevation_input"
COMPONENTS = 300  # of a sea that is asked for


@dataclass
class HullWaves:
    """Forces of waves on the hulls of `coefficients`: `m4e_fmi.analysis.response.WaveForces`.

    `waves` are the configured ones.
    """

    coefficients: Coefficients
    waves: AnyWaves
    _own: np.ndarray = field(default_factory=lambda: np.zeros(0), repr=False)

    @property
    def inputs(self) -> list[str]:
        """The elevation at x = y = 0, and the force on each motion of each body."""
        c = self.coefficients
        forces = [f"{body}.wave_{motion.force}" for body in c.bodies for motion in c.body_motions]
        return [ELEVATION, *forces]

    @property
    def highest(self) -> float:
        """The highest frequency [rad/s] of the coefficients."""
        return float(self.coefficients.omega[-1])

    def record(
        self,
        recorder: Recorder,
        waves: AnyWaves,
        coefficients: Coefficients,
        *,
        heading: Number,
        places: Sequence[tuple[Number, Number]],
    ) -> list[Number]:
        """Record the inputs in place of a sea, as `sea.record_sea`; the force on each motion.

        Other than of a sea, `heading` and `places` are asked for by `per_amplitude` only.
        """
        del heading, places
        if not isinstance(waves, Still):
            omega, amplitudes, _ = record_components(recorder, waves)
            if coefficients.dimensions == 3:
                record_direction(recorder, waves)
            record_ramp(recorder, waves)
            self._record_amplitudes(recorder, omega, amplitudes)
        text = "elevation of the undisturbed water at x = y = 0"
        elevation = recorder.input(Variable(ELEVATION, "m", text))
        recorder.output(Variable("wave.elevation", "m", text), elevation)
        units = [motion.force_unit for motion in coefficients.body_motions]
        units *= len(coefficients.bodies)
        text = "force of waves, in the axes of the heading"
        return [
            recorder.input(Variable(name, unit, text))
            for name, unit in zip(self.inputs[1:], units, strict=True)
        ]

    def _record_amplitudes(
        self, recorder: Recorder, omega: np.ndarray, amplitudes: Sequence[Scalar]
    ) -> None:
        self._own = omega
        for k, amplitude in enumerate(amplitudes):
            text = f"amplitude of the wave component of {omega[k]:.6g} rad/s"
            recorder.calculate(Variable(_amplitude(k), "m", text), amplitude)

    def per_amplitude(
        self, omega: np.ndarray, direction: float, values: Mapping[str, float]
    ) -> np.ndarray:
        """Each input per amplitude, (k, m), for waves of `omega` (k,) [rad/s] to `direction` [rad].

        InputError for a direction that the coefficients are not for.
        """
        c = self.coefficients
        if c.dimensions == 2:
            forces = c.towards(math.degrees(direction)).excitation_at(omega)
        else:
            reference = values["heading"]
            places = reference_places(c.centers, Axes.at(reference))
            heading = reference + values.get("heading_change", 0.0)
            c = c.towards(math.degrees(direction - heading))
            table = np.array(excitation_in_space(c, omega, direction, heading, places), dtype=float)
            forces = table[..., 0] + 1j * table[..., 1]
        return np.concatenate([np.ones((len(omega), 1)), forces], axis=1)

    def own_sea(self, values: Mapping[str, float]) -> Sea | None:
        """The configured sea, if it is irregular."""
        if isinstance(self.waves, Still | Regular):
            return None
        amplitudes = np.array([values[_amplitude(k)] for k in range(len(self._own))])
        direction = self.own_direction(values)
        assert direction is not None
        return Sea(self._own, amplitudes, direction)

    def own_direction(self, values: Mapping[str, float]) -> float | None:
        """The configured direction [rad]; None in still water."""
        if isinstance(self.waves, Still):
            return None
        return values.get("wave.direction", math.radians(self.waves.direction))

    def jonswap(
        self, significant_height: float, peak_period: float, enhancement: float, direction: float
    ) -> Sea:
        """A JONSWAP sea: height [m], peak period [s], peak enhancement [1], direction [rad].

        Frequencies are in the middle of the parts that a configured sea has one in, at random.
        """
        edges = part_edges(2.0 * math.pi / peak_period, COMPONENTS, enhancement=enhancement)
        omega = 0.5 * (edges[:-1] + edges[1:])
        amplitudes = component_amplitudes(
            omega.tolist(),
            np.diff(edges).tolist(),
            significant_height=significant_height,
            peak_period=peak_period,
            enhancement=enhancement,
        )
        return Sea(omega, np.array(amplitudes, dtype=float), direction)


def _amplitude(k: int) -> str:
    return f"wave.amplitude[{k + 1}]"
