"""Systems of waves as the components that `IncidentWaves` adds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber

Data = dict[str, list[float] | float]


def wave_data(systems: Sequence[WaveSystem]) -> Data | None:
    """The argument of `IncidentWaves`, the same sea as `sea.record_sea` makes; None of still water.

    Of each component rad/s, rad/m, m, rad, rad, and the time [s] in which it grows.
    """
    if not systems:
        return None
    rows = []
    for system in systems:
        omega, amplitude, direction = system.known({})
        number = wavenumber(omega, depth=system.depth, gravity=system.gravity)
        length = system.default_ramp if system.ramp_time is None else system.ramp_time
        ramp = np.full(len(omega), length)
        rows.append([omega, number, amplitude, system.known_phases({}), direction, ramp])
    columns = (np.concatenate(parts).tolist() for parts in zip(*rows, strict=True))
    names = ("omega", "wavenumber", "amplitude", "phase", "direction", "ramp_time")
    return {**dict(zip(names, columns, strict=True)), "depth": systems[0].depth}
