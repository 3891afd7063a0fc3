"""Sums of systems of waves: with phases, as the response to waves takes them, and as a program."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Current, Water
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem, breaking_heights, wave_doubts
from m4e_adapters.hydrodynamics.seas.water.current import record_current
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components
from m4e_adapters.hydrodynamics.seas.water.moving_water import MOVED
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Number
from m4e_adapters.hydrodynamics.seas.waves import component_amplitudes, part_edges
from m4e_fmi.analysis.response import Sea
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder, Variable

COMPONENTS = 300  # of a sea that is asked for


@dataclass(kw_only=True)
class SystemWaves:
    """Answers about waves that forces of any wave give alike, whatever the forces are.

    They are part of `m4e_fmi.analysis.response.WaveForces`. `systems` are those configured, in
    `water`. `highest` is the frequency [rad/s] up to which the forces are known, `notes` tell what
    they leave out.
    """

    systems: Sequence[WaveSystem] = field(default=(), repr=False)
    water: Water | Coefficients = field(repr=False)
    highest: float = math.inf
    notes: Sequence[str] = ()

    def breaking_heights(self, omega: np.ndarray) -> np.ndarray:
        """Heights (k,) [m] at which regular waves of `omega` (k,) [rad/s] break."""
        return breaking_heights(omega, depth=self.water.depth, gravity=self.water.gravity)

    def own_sea(self, values: Mapping[str, float]) -> Sea | None:
        """The configured sea, for `values` of parameters; None if no system is irregular.

        A record has the energy of all its rows, which its tapered ends take from a run's.
        """
        waves = self.systems
        if all(system.regular for system in waves):
            return None
        parts = [system.known(values) for system in waves]
        omega, amplitudes, directions = (np.concatenate(part) for part in zip(*parts, strict=True))
        amplitudes *= np.repeat([w.in_statistics for w in waves], [len(part[0]) for part in parts])
        doubts = [text for system in waves for text in system.doubts(values)]
        return Sea(omega, amplitudes, directions, tuple(doubts))

    def own_direction(self, values: Mapping[str, float]) -> float | None:
        """The configured direction [rad]; None in still water. InputError if there are several."""
        found = list(dict.fromkeys(system.known_direction(values) for system in self.systems))
        if len(found) > 1:
            text = "the systems of waves travel in different directions"
            raise InputError.single(text, "give one for all: --headings")
        return found[0] if found else None

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
        doubts = wave_doubts(
            significant_height,
            peak_period,
            depth=self.water.depth,
            gravity=self.water.gravity,
            regular=False,
        )
        directions = np.full(COMPONENTS, direction)
        return Sea(omega, np.array(amplitudes, dtype=float), directions, tuple(doubts))


def lines_on(waves: Sequence[WaveSystem]) -> Iterator[str]:
    """Lines of a build on `waves` as configured: notes and warnings."""
    for system in waves:
        yield from (f"note: {text}" for text in system.notes)
        yield from (f"warning: {text}" for text in system.doubts({}))


def components_of(waves: Sequence[WaveSystem], values: Mapping[str, float]) -> Components:
    """The components of all systems, for `values` of parameters by name, others as configured.

    Without ramps; there are waves.
    """
    parts = [(*system.known(values), system.known_phases(values)) for system in waves]
    omega, amplitude, direction, phase = (np.concatenate(p) for p in zip(*parts, strict=True))
    return Components(
        omega, amplitude, phase, direction, depth=waves[0].depth, gravity=waves[0].gravity
    )


def wave_data(waves: Sequence[WaveSystem]) -> dict[str, list[float] | float] | None:
    """The argument of `pressure.hull_load.IncidentWaves`; None of still water.

    Of each component rad/s, rad/m, m, rad, rad, and the time [s] in which it grows.
    """
    if not waves:
        return None
    found = components_of(waves, {})
    ramps = np.repeat([own.ramp_time for own in waves], [len(own.omega) for own in waves])
    return {
        "omega": found.omega.tolist(),
        "wavenumber": found.wavenumber.tolist(),
        "amplitude": found.amplitude.tolist(),
        "phase": found.phase.tolist(),
        "direction": found.direction.tolist(),
        "ramp_time": ramps.tolist(),
        "depth": found.depth,
    }


def water_program(
    waves: Sequence[WaveSystem], current: Current | None, *, depth: float, in_space: bool
) -> Program:
    """A program of the parameters of `waves` and a `current`, for `moving_water.MovingWater`.

    Its calculated parameters are the components' frequencies, amplitudes, phases and directions
    (`MOVED`), each of all systems; its outputs the ramps of the systems, and the velocity (x, y) of
    the current at the height of its input. `depth` in m.
    """
    recorder = Recorder("water", "waves and a current")
    recorded = [(system.name, system.record(recorder, in_space=in_space)) for system in waves]
    columns = {name: list[Number]() for name in MOVED}
    for name, own in recorded:
        columns["omega"] += own.omega
        columns["amplitude"] += own.amplitude
        columns["phase"] += own.phase
        columns["direction"] += [own.direction + offset for offset in own.offsets.tolist()]
        recorder.output(Variable(f"{name}.ramp", "1", f"ramp of {name}"), own.ramp)
    for (column, values), unit in zip(columns.items(), ("rad/s", "m", "rad", "rad"), strict=True):
        for k, value in enumerate(values):
            text = f"{column} of a component of the waves"
            recorder.calculate(Variable(f"{column}[{k + 1}]", unit, text), value)
    flowing = record_current(recorder, current, depth=depth, in_space=in_space)
    height = recorder.input(Variable("z", "m", "height"))
    for axis, value in zip("xy", flowing.velocity(height), strict=True):
        recorder.output(Variable(f"current_{axis}", "m/s", f"current along {axis}"), value)
    return recorder.program()
