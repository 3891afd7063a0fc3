"""Hulls of an absurd size, hulls that capsize, currents on nothing: allowed, and seldom meant."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from m4e_adapters.hydrodynamics.config import Drag, HydrodynamicsConfig, Water, wave_sections
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.current import current_doubts

LENGTHS = (0.01, 1000.0)  # [m] of hulls
BODIES_APART = 1000.0  # length of a hull over that of the shortest
WAVES_APART = 100.0  # length of a hull over that of the waves
UNSTABLE = -1e-3  # metacentric height over the size of a body, beyond the panels' noise


def size_doubts(
    hulls: Sequence[Hull], config: HydrodynamicsConfig, systems: Sequence[WaveSystem]
) -> Iterator[str]:
    """Hulls of sizes that no hull has, or none beside the others or in these waves; a line each."""
    lengths = {hull.name: float(np.ptp(hull.panels.vertices, axis=0).max()) for hull in hulls}
    shortest = min(lengths, key=lambda name: lengths[name])
    waves = min((system.length for system in systems), default=math.inf)
    for name, length in lengths.items():
        told = f"the hull of body {name!r} measures {length:.4g} m"
        if config.bodies[name].shape.mesh is not None:
            remedy = "a mesh is in m; one in mm has 'scale: 0.001'"
        else:
            remedy = "lengths are in m"
        if not LENGTHS[0] <= length <= LENGTHS[1]:
            yield f"{told}, hulls have {LENGTHS[0]:g} to {LENGTHS[1]:g} m: {remedy}"
        elif length > BODIES_APART * lengths[shortest]:
            yield f"{told}, that of {shortest!r} {lengths[shortest]:.4g} m: {remedy}"
        elif length > WAVES_APART * waves:
            yield f"{told}, the waves are {waves:.4g} m long: {remedy}"


def stability_doubts(hulls: Sequence[Hull], water: Water) -> Iterator[str]:
    """Hulls that capsize if they float freely; a line each."""
    for hull in hulls:
        if hull.fixed:
            continue
        volume = hull.hydrostatics.volume
        heights = {"pitch": hull.hydrostatics.metacentric_height(hull.center)}
        if len(hull.center) == 3:
            heights["roll"] = hull.hydrostatics.transverse_metacentric_height(hull.center)
        for motion, height in heights.items():
            if height >= UNSTABLE * math.cbrt(volume):
                continue
            stiffness = water.density * water.gravity * volume * height
            yield (
                f"body {hull.name!r} is unstable in {motion}, with a stiffness of {stiffness:.4g} "
                f"N.m/rad, weight included (GM = {height:.3g} m): floating freely it capsizes: "
                "lower center_of_gravity"
            )


def flow_doubts(config: HydrodynamicsConfig) -> Iterator[str]:
    """A current beside waves, or one that acts on nothing; a line each."""
    yield from current_doubts(config.current, has_waves=bool(wave_sections(config.waves)))
    drags = [body.drag for body in config.bodies.values() if body.drag.water != "still"]
    if config.current is not None and not any(map(_slows, drags)):
        yield "the current acts on nothing: no body has drag in moving water (drag: {surge: …})"


def _slows(drag: Drag) -> bool:
    """True of drag in a horizontal motion."""
    return any((drag.surge, drag.sway, drag.linear.surge, drag.linear.sway))
