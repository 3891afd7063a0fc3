"""A program in waves: the forces of waves are inputs, known for each frequency and direction.

Waves are written e^{−iωt}: a wave of complex amplitude a has the elevation Re[a e^{−iωt}] at
x = y = 0, and makes the force Re[X a e^{−iωt}].
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.analysis.points import Floats, OperatingPoint
from m4e_fmi.errors import InputError
from m4e_fmi.program import TIME, Program, evaluated

Complex = NDArray[np.complex128]
MOST = 10.0
"""Largest peak enhancement of a JONSWAP sea."""


@dataclass(frozen=True)
class Sea:
    """An irregular sea: the sum of waves of `omega` (k,) [rad/s] and `amplitudes` (k,) [m].

    Their phases are random. `directions` (k,) [rad] are those that they travel to, from +X towards
    +Y. `doubts` say why there is no such sea, if there is none.
    """

    omega: Floats = field(repr=False)
    amplitudes: Floats = field(repr=False)
    directions: Floats = field(repr=False)
    doubts: tuple[str, ...] = ()

    @property
    def direction(self) -> float:
        """The mean direction [rad]: that of the sum of arrows as long as the waves have energy."""
        if np.all(self.directions == self.directions[0]):
            return float(self.directions[0])
        energy = self.amplitudes**2
        return float(np.arctan2(energy @ np.sin(self.directions), energy @ np.cos(self.directions)))

    def turned_to(self, direction: float) -> Sea:
        """The same sea, turned so that `direction` [rad] is the mean one."""
        turn = direction - self.direction
        return replace(self, directions=self.directions + turn)

    @property
    def significant_height(self) -> float:
        """4 √m₀ [m]."""
        return 4.0 * float(np.sqrt(np.sum(self.amplitudes**2) / 2.0))

    @property
    def energy_period(self) -> float:
        """2π m₋₁/m₀ [s]."""
        energy = self.amplitudes**2
        return float(2.0 * np.pi * np.sum(energy / self.omega) / np.sum(energy))


class WaveForces(Protocol):
    """Forces of waves on a program, whose `inputs` they are, the elevation at x = y = 0 among them.

    `highest` [rad/s] is the frequency up to which they were computed; beyond it they fall off.
    `values` below are those of the program's parameters, states and calculated parameters by name.
    """

    @property
    def inputs(self) -> Sequence[str]:
        """Names of the inputs, m of them."""
        ...

    @property
    def highest(self) -> float:
        """The highest computed angular frequency [rad/s]."""
        ...

    @property
    def notes(self) -> Sequence[str]:
        """Lines on what they leave out."""
        ...

    def per_amplitude(
        self, omega: Floats, directions: Floats, values: Mapping[str, float]
    ) -> Complex:
        """Each input per amplitude of the wave, (k, m) [unit of the input / m].

        For waves of `omega` (k,) [rad/s] that travel to `directions` (k,) [rad]. InputError for a
        direction that is not known.
        """
        ...

    def breaking_heights(self, omega: Floats) -> Floats:
        """Heights (k,) [m] at which regular waves of `omega` (k,) [rad/s] break."""
        ...

    def own_sea(self, values: Mapping[str, float]) -> Sea | None:
        """The irregular sea that the program was configured with, if it was."""
        ...

    def own_direction(self, values: Mapping[str, float]) -> float | None:
        """The direction [rad] that the program was configured with; None in still water."""
        ...

    def jonswap(
        self, significant_height: float, peak_period: float, enhancement: float, direction: float
    ) -> Sea:
        """A JONSWAP sea: height [m], peak period [s], peak enhancement [1], direction [rad]."""
        ...


@dataclass(frozen=True)
class InWaves:
    """A `program` with the forces of waves as inputs; `forces` by the part that they act on.

    The part "" is the program itself. Names of a part begin with that of the part in the program.
    """

    program: Program
    forces: Mapping[str, WaveForces]

    @property
    def inputs(self) -> list[str]:
        """Names of all inputs that are forces of waves, in the order of `per_amplitude`."""
        return [
            _joined(part, name) for part, forces in self.forces.items() for name in forces.inputs
        ]

    @property
    def highest(self) -> float:
        """The angular frequency [rad/s] up to which the forces of all parts were computed."""
        return min(forces.highest for forces in self.forces.values())

    def per_amplitude(
        self, omega: Floats, directions: Floats | float, point: OperatingPoint
    ) -> Complex:
        """All `inputs` per amplitude of the wave, (k, m), for `omega` (k,) [rad/s].

        `directions` (k,) or scalar [rad] are those that the waves travel to.
        """
        angles = np.broadcast_to(np.asarray(directions, dtype=float), np.shape(omega))
        parts = [
            forces.per_amplitude(omega, angles, self._values(part, point))
            for part, forces in self.forces.items()
        ]
        return np.concatenate(parts, axis=1)

    def breaking_heights(self, omega: Floats) -> Floats:
        """Heights (k,) [m] at which regular waves of `omega` (k,) [rad/s] break, in any part."""
        return np.min([forces.breaking_heights(omega) for forces in self.forces.values()], axis=0)

    def own_direction(self, point: OperatingPoint) -> float:
        """The direction [rad] of the parts' waves; 0 in still water. InputError if they differ."""
        given = (f.own_direction(self._values(part, point)) for part, f in self.forces.items())
        found = list(dict.fromkeys(angle for angle in given if angle is not None))
        if len(found) > 1:
            raise InputError.single(
                f"{self.program.name}: waves of its components travel in different directions",
                "give one for all: --headings",
            )
        return found[0] if found else 0.0

    def own_sea(self, point: OperatingPoint) -> Sea:
        """The sea that the parts were configured with.

        InputError if there is none, or if that of one part is not that of another.
        """
        seas = [f.own_sea(self._values(part, point)) for part, f in self.forces.items()]
        found = [sea for sea in seas if sea is not None]
        name = self.program.name
        if not found:
            raise InputError.single(
                f"{name}: it was configured with no irregular sea",
                "give one: --sea HEIGHT PERIOD, or `waves: {spectrum: jonswap, …}` in its file",
            )
        first = found[0]
        if len(found) < len(seas) or not all(_same(first, sea) for sea in found[1:]):
            raise InputError.single(
                f"{name}: the components in water have different seas",
                "give one for all: --sea HEIGHT PERIOD",
            )
        return first

    def jonswap(
        self, significant_height: float, peak_period: float, enhancement: float, direction: float
    ) -> Sea:
        """A JONSWAP sea: height [m], peak period [s], peak enhancement [1], direction [rad].

        InputError for numbers that no sea has.
        """
        given = (significant_height, peak_period, enhancement)
        sound = significant_height > 0 and peak_period > 0 and 1.0 <= enhancement <= MOST
        if not (sound and all(map(math.isfinite, (*given, direction)))):
            message = f"no JONSWAP sea has height, peak period and enhancement {given}"
            raise InputError.single(message, f"positive ones, the last from 1 to {MOST:g}")
        forces = next(iter(self.forces.values()))
        return forces.jonswap(significant_height, peak_period, enhancement, direction)

    def _values(self, part: str, point: OperatingPoint) -> dict[str, float]:
        """Parameters, states and calculated parameters of a part, by their names in it."""
        known = {**point.values, TIME: point.time}
        program = self.program
        for one in program.parts if part else ():
            if one.name == part:
                nodes = evaluated(program.tape, list(one.nodes.values()), known)
                known = {name: nodes[node] for name, node in one.nodes.items()}
                known, program = {**known, TIME: point.time}, one.program
        calculated = evaluated(program.tape, program.constants, known)
        named = zip(program.calculated, program.constants, strict=True)
        return {**known, **{v.name: calculated[node] for v, node in named}}


def _joined(part: str, name: str) -> str:
    return f"{part}.{name}" if part else name


def _same(one: Sea, other: Sea) -> bool:
    return (
        np.array_equal(one.directions, other.directions)
        and np.array_equal(one.omega, other.omega)
        and np.array_equal(one.amplitudes, other.amplitudes)
    )
