"""The waves of a configuration as the components that `incident_waves` adds."""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.config import Jonswap, Regular, Still, Water, Waves
from m4e_adapters.hydrodynamics.seas.sea import RAMP_PERIODS
from m4e_adapters.hydrodynamics.seas.waves import (
    component_amplitudes,
    component_frequencies,
    component_phases,
    part_edges,
    wavenumber,
)

Data = dict[str, list[float] | float]


def wave_data(waves: Waves, water: Water) -> Data | None:
    """The argument of `IncidentWaves`, the same sea as `sea.record_sea` makes; None of still water.

    The components are n numbers each of rad/s, rad/m, m, rad, rad.
    """
    if isinstance(waves, Still):
        return None
    if isinstance(waves, Regular):
        period, amplitudes, phase = waves.period, [0.5 * waves.height], np.array([waves.phase])
        omega = np.array([2 * math.pi / period])
    else:
        period = waves.peak_period
        rng = np.random.Generator(np.random.PCG64(waves.seed))
        enhancement = waves.peak_enhancement if isinstance(waves, Jonswap) else 1.0
        edges = part_edges(2 * math.pi / period, waves.components, enhancement=enhancement)
        omega = component_frequencies(edges, rng)
        phase = component_phases(waves.components, rng)
        amplitudes = component_amplitudes(
            omega.tolist(),
            np.diff(edges).tolist(),
            significant_height=waves.significant_height,
            peak_period=period,
            enhancement=enhancement,
        )
    direction = math.radians(waves.direction)
    return {
        "omega": omega.tolist(),
        "wavenumber": wavenumber(omega, depth=water.depth, gravity=water.gravity).tolist(),
        "amplitude": [float(a) for a in amplitudes],
        "phase": phase.tolist(),
        "direction": [direction] * len(omega),
        "depth": water.depth,
        "ramp_time": RAMP_PERIODS * period if waves.ramp_time is None else waves.ramp_time,
    }
