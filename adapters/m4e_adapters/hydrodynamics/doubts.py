"""Seas that break, hulls of an absurd size, hulls that capsize: allowed, and seldom meant.

A wave breaks above 0.142 λ tanh kh (R. Miche, "Mouvements ondulatoires de la mer en profondeur
constante ou décroissante", Annales des Ponts et Chaussées 114, 1944), and above 0.78 h, which is
where a solitary wave does. A sea is too steep where 2π Hs/(g Tp²) is above 1/15 for Tp ≤ 8 s, above
1/25 for Tp ≥ 15 s, or above what is linear between: the steepness criteria of DNV-RP-C205,
"Environmental conditions and environmental loads".
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Regular, Still, Water, Waves
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.seas.sea import wavelength
from m4e_adapters.hydrodynamics.seas.waves import wavenumber

STEEPEST, OF_DEPTH = 0.142, 0.78  # heights that break, over wavelength and over depth
PERIODS, STEEPNESSES = (8.0, 15.0), (1 / 15, 1 / 25)  # [s] of the peak, and limits there
LENGTHS = (0.01, 1000.0)  # [m] of hulls
BODIES_APART = 1000.0  # length of a hull over that of the shortest
WAVES_APART = 100.0  # length of a hull over that of the waves
UNSTABLE = -1e-3  # metacentric height over the size of a body, beyond the panels' noise


def sea_doubts(waves: Waves, water: Water) -> Iterator[str]:
    """Waves that would break before they are so high; a line each."""
    if isinstance(waves, Still):
        return
    regular = isinstance(waves, Regular)
    period = waves.period if regular else waves.peak_period
    height = waves.height if regular else waves.significant_height
    breaking = breaking_height(period, water)
    noun, of = ("wave height", "") if regular else ("significant wave height", "peak ")
    if height > breaking:
        depth = "deep water" if math.isinf(water.depth) else f"{water.depth:g} m of water"
        yield (
            f"the {noun} of {height:.4g} m is above {breaking:.3g} m, at which waves of a "
            f"{of}period of {period:g} s break in {depth}: no such sea exists: make it lower or "
            "longer"
        )
    steepness = 2 * math.pi * height / (water.gravity * period**2)
    limit = float(np.interp(period, PERIODS, STEEPNESSES))
    if not regular and steepness > limit and height <= breaking:
        yield (
            f"the sea is too steep: 2 pi Hs/(g Tp^2) is {steepness:.3g} (Hs {height:g} m, Tp "
            f"{period:g} s), seas have up to {limit:.3g} at this period (DNV-RP-C205): make it "
            "lower or longer"
        )


def breaking_height(period: float, water: Water) -> float:
    """Height [m] above which a regular wave of `period` [s] breaks."""
    omega = np.array(2 * math.pi / period)
    k = float(wavenumber(omega, depth=water.depth, gravity=water.gravity))
    return min(STEEPEST * 2 * math.pi / k * math.tanh(k * water.depth), OF_DEPTH * water.depth)


def size_doubts(hulls: Sequence[Hull], config: HydrodynamicsConfig) -> Iterator[str]:
    """Hulls of sizes that no hull has, or none beside the others or in these waves; a line each."""
    lengths = {hull.name: float(np.ptp(hull.panels.vertices, axis=0).max()) for hull in hulls}
    shortest = min(lengths, key=lambda name: lengths[name])
    water = config.water
    waves = wavelength(config.waves, depth=water.depth, gravity=water.gravity)
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
