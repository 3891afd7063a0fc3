"""Froude-Krylov's part of the excitation: that of the undisturbed waves.

It is the part that Capytaine adds to the diffraction, summed over the same panels in the same way:
what is left of the excitation without it is the diffraction as it was solved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.flow.bem import assembled, felt_motions, wave_directions
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.flow.flow_solver import capytaine_body
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber

WHOLE = ("froude_krylov", "diffraction")


def excited_by(
    coefficients: Coefficients, hulls: Sequence[Hull], parts: tuple[str, ...]
) -> Coefficients:
    """`coefficients`, solved for `hulls`, with those `parts` of the excitation alone."""
    if parts == WHOLE:
        return coefficients
    if not parts:
        return coefficients.without_excitation()
    undisturbed = _undisturbed(coefficients, hulls)
    excitation, harmonics = undisturbed.excitation, undisturbed.harmonics
    if parts == ("diffraction",):
        excitation = coefficients.excitation - excitation
        harmonics = coefficients.harmonics - harmonics
    return replace(coefficients, excitation=excitation, harmonics=harmonics, excited_by=parts)


def _undisturbed(coefficients: Coefficients, hulls: Sequence[Hull]) -> Coefficients:
    """Coefficients of the same hulls whose excitation is Froude-Krylov's part."""
    c = coefficients
    water = Water(density=c.density, depth=c.depth, gravity=c.gravity)
    table = {
        name: np.zeros((len(c.omega) + 1, *c.added_mass_inf.shape))
        for name in ("added_mass", "radiation_damping")
    }
    rings = [*_rings(c, hulls, water)]
    return assembled(hulls, water, c.omega, c.wave_direction, table, rings)


def _rings(c: Coefficients, hulls: Sequence[Hull], water: Water) -> Iterator[np.ndarray]:
    """The force (nβ, n) [N/m, N.m/m] at each frequency, in the directions of its solution."""
    body, felt = capytaine_body(import_capytaine(), hulls), felt_motions(hulls)
    x, y, z = np.asarray(body.mesh.faces_centers).T
    for omega in c.omega.tolist():
        k = float(wavenumber(np.array(omega), depth=c.depth, gravity=c.gravity))
        head = np.exp(k * z)
        if np.isfinite(c.depth):
            head = (head + np.exp(-k * (z + 2 * c.depth))) / (1 + np.exp(-2 * k * c.depth))
        ring = []
        for direction in np.radians(wave_directions(hulls, water, omega, c.wave_direction)):
            way = k * (x * np.cos(direction) + y * np.sin(direction))
            pressure = c.density * c.gravity * head * np.exp(1j * way)
            forces = body.integrate_pressure(pressure)
            ring.append([forces[name] for name in body.dofs])
        yield np.array(ring) @ felt
