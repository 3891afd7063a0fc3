"""The sea of a component as an animation shows it: all its waves, as they are at the start."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import Water, Waves
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import ELEVATION
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_fmi.report.animation.scene import Train
from m4e_fmi.report.animation.scene import Water as ShownWater
from m4e_fmi.report.animation.shown import Shown, ShownHull


def shown_sea(
    water: Water,
    waves: Waves,
    *,
    folder: Path,
    values: Mapping[str, float],
    hulls: tuple[ShownHull, ...] = (),
) -> Shown:
    """The `water` with its `waves` and bed, and `hulls` in it, for `values` of parameters.

    Files of the waves are in `folder`.
    """
    trains = []
    for one in wave_systems(waves, depth=water.depth, gravity=water.gravity, folder=folder):
        omega, amplitude, direction = one.known(values)
        number = wavenumber(omega, depth=one.depth, gravity=one.gravity)
        ramp = one.ramp_time
        if ramp:  # else there is no such parameter
            ramp = values.get(f"{one.name}.ramp_time", ramp)
        phase, way = one.known_phases(values), np.broadcast_to(direction, omega.shape)
        trains.append(Train(omega, number, amplitude, phase, way, ramp))
    return Shown(
        hulls=hulls,
        water=ShownWater(water.depth, tuple(trains), ELEVATION, water.density),
        floor=None if math.isinf(water.depth) else -water.depth,
    )
