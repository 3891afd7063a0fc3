"""Potential flow by Capytaine: coefficients of hulls, cached by content.

The direct boundary integral equation is used: its forces converge with the square of the panel
size, those of Capytaine's default ("indirect") only with the first power.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from m4e_adapters.hydrodynamics import cache
from m4e_adapters.hydrodynamics.capytaine_setup import (
    accurate_finite_depth,
    import_capytaine,
    kept_warnings,
)
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.mesh import Hull
from m4e_adapters.hydrodynamics.panels import Panels
from m4e_adapters.hydrodynamics.waves import angular_frequency
from m4e_fmi.code_hash import package_hash
from m4e_fmi.errors import RunError

METHOD = "direct"
DOFS = ("Surge", "Heave", "Pitch")
LIBRARIES = ("capytaine", "numpy", "scipy")  # whose versions count
PANELS_PER_WAVELENGTH = 8  # panel radius below wavelength / 8: Capytaine's own rule

Progress = Callable[[str], object]


def solve_hulls(
    hulls: Sequence[Hull],
    *,
    water: Water,
    omega: np.ndarray,
    wave_direction: float = 0.0,
    progress: Progress = print,
) -> Coefficients:
    """Coefficients of all hulls together, interactions included.

    Parameters
    ----------
    omega : (nω,) angular frequencies [rad/s], increasing; ω = ∞ is always added.
    wave_direction : 0 or 180 deg.
    progress : is told how far the solution is, and its warnings.
    """
    _warn_of_coarse_panels(hulls, water, float(omega[-1]), progress)
    key = cache.content_key(_content(hulls, water, omega, wave_direction))
    arrays = _cached(key, progress)
    if arrays is None:
        arrays = _solve(hulls, water, omega, wave_direction, progress)
        try:
            cache.store(key, arrays)
        except RunError as error:
            progress(f"the coefficients are not cached: {error.message}")
    for text in arrays["warnings"]:
        progress(f"warning: capytaine: {text}")
    return _assembled(hulls, water, omega, wave_direction, arrays)


def _cached(key: str, progress: Progress) -> dict[str, np.ndarray] | None:
    """Content of the cache under `key`; None if nothing is, or nothing that can be used."""
    try:
        arrays = cache.load(key)
    except (cache.DamagedError, OSError) as error:
        progress(f"the coefficients in the cache cannot be used and are computed again: {error}")
        return None
    if arrays is not None:
        progress("potential flow: coefficients taken from the cache")
    return arrays


def _content(
    hulls: Sequence[Hull], water: Water, omega: np.ndarray, wave_direction: float
) -> dict[str, Any]:
    """All that the solution depends on."""
    content: dict[str, Any] = {
        "code": package_hash("m4e_adapters.hydrodynamics"),
        "libraries": [f"{name} {version(name)}" for name in LIBRARIES],
        "method": METHOD,
        "water": [water.density, water.depth, water.gravity],
        "omega": omega,
        "wave_direction": wave_direction,
    }
    for k, hull in enumerate(hulls):
        content[f"center{k}"] = hull.center
        for part, panels in (("hull", hull.panels), ("lid", hull.lid)):
            if panels is not None:
                content[f"{part}{k}"] = panels.corners
    return content


def _warn_of_coarse_panels(
    hulls: Sequence[Hull], water: Water, highest: float, progress: Progress
) -> None:
    for hull in hulls:
        shortest = PANELS_PER_WAVELENGTH * hull.panels.radius
        limit = angular_frequency(2 * math.pi / shortest, depth=water.depth, gravity=water.gravity)
        if highest > limit:
            progress(
                f"warning: the panels of body {hull.name!r} (radius up to {hull.panels.radius:.3g}"
                f" m) are coarse for waves above {limit:.3g} rad/s, the highest is "
                f"{highest:.3g}: use more panels or a lower frequencies.maximum"
            )


def _solve(
    hulls: Sequence[Hull],
    water: Water,
    omega: np.ndarray,
    wave_direction: float,
    progress: Progress,
) -> dict[str, np.ndarray]:
    """Added mass and damping (nω + 1, n, n), the last at ω = ∞, and excitation (nω, n)."""
    capytaine = import_capytaine()
    n = 3 * len(hulls)
    added_mass, damping = np.zeros((2, len(omega) + 1, n, n))
    excitation = np.zeros((len(omega), n), dtype=complex)
    with kept_warnings() as warnings, accurate_finite_depth():
        body = _capytaine_body(capytaine, hulls)
        solver = capytaine.BEMSolver(method=METHOD)
        names = list(body.dofs)
        medium = {"water_depth": water.depth, "rho": water.density, "g": water.gravity}
        for k, w in enumerate([*omega, np.inf]):
            progress(f"potential flow: frequency {k + 1} of {len(omega) + 1}")
            common = {"body": body, "omega": w, **medium}
            for j, name in enumerate(names):
                problem = capytaine.RadiationProblem(radiating_dof=name, **common)
                result = _solution(solver, problem, w)
                added_mass[k, :, j] = [result.added_masses[i] for i in names]
                damping[k, :, j] = [result.radiation_dampings[i] for i in names]
            if k < len(omega):
                problem = capytaine.DiffractionProblem(
                    wave_direction=math.radians(wave_direction), **common
                )
                result = _solution(solver, problem, w)
                incident = capytaine.bem.airy_waves.froude_krylov_force(problem)
                excitation[k] = [result.forces[i] + incident[i] for i in names]
    return {
        "added_mass": added_mass,
        "radiation_damping": damping,
        "excitation": excitation,
        "warnings": np.array(warnings, dtype=str),
    }


def _solution(solver: Any, problem: Any, omega: float) -> Any:
    from capytaine.green_functions.abstract_green_function import GreenFunctionEvaluationError

    try:
        return solver.solve(problem, keep_details=False, _check_wavelength=False)
    except GreenFunctionEvaluationError as error:
        raise RunError(
            f"the potential flow cannot be solved at {omega:.4g} rad/s: {error}",
            "look for panels that overlap or touch those of another body; else raise "
            "frequencies.minimum",
        ) from None


def _capytaine_body(capytaine: Any, hulls: Sequence[Hull]) -> Any:
    """All hulls as one Capytaine body; planes of symmetry that all share are used.

    Capytaine's Pitch is the rotation about +Y, v = (z, 0, −x) at (x, z) from the centre: it turns
    +Z towards +X, as ours does.
    """
    surfaces = [p for hull in hulls for p in (hull.panels, hull.lid) if p is not None]
    planes = [axis for axis in (1, 0) if all(p.half(axis) is not None for p in surfaces)]

    def mesh(panels: Panels | None) -> Any:
        if panels is None:
            return None
        for axis in planes:
            panels = panels.half(axis) or panels
        result = capytaine.Mesh(panels.vertices, panels.faces, auto_check=False)
        for axis in planes:
            plane = "xOz" if axis == 1 else "yOz"
            result = capytaine.ReflectionSymmetricMesh(result, plane=plane)
        return result

    bodies = []
    for k, hull in enumerate(hulls):
        center = (hull.center[0], 0.0, hull.center[1])
        dofs = capytaine.rigid_body_dofs(rotation_center=center, only=list(DOFS))
        bodies.append(
            capytaine.FloatingBody(
                mesh=mesh(hull.panels), lid_mesh=mesh(hull.lid), dofs=dofs, name=f"body{k}"
            )
        )
    return capytaine.Multibody(bodies) if len(bodies) > 1 else bodies[0]


def _assembled(
    hulls: Sequence[Hull],
    water: Water,
    omega: np.ndarray,
    wave_direction: float,
    arrays: dict[str, np.ndarray],
) -> Coefficients:
    """Coefficients with hydrostatics; A and B made symmetric, which they are but for panels."""
    n = 3 * len(hulls)
    stiffness, buoyancy = np.zeros((n, n)), np.zeros(n)
    for k, hull in enumerate(hulls):
        own = slice(3 * k, 3 * k + 3)
        arguments = (hull.center, water.density, water.gravity)
        stiffness[own, own] = hull.hydrostatics.stiffness(*arguments)
        buoyancy[own] = hull.hydrostatics.buoyancy(*arguments)
    symmetric = {
        name: 0.5 * (arrays[name] + arrays[name].transpose(0, 2, 1))
        for name in ("added_mass", "radiation_damping")
    }
    result = Coefficients(
        bodies=tuple(hull.name for hull in hulls),
        centers=np.array([hull.center for hull in hulls]),
        omega=np.asarray(omega),
        added_mass=symmetric["added_mass"][:-1],
        radiation_damping=symmetric["radiation_damping"][:-1],
        added_mass_inf=symmetric["added_mass"][-1],
        excitation=arrays["excitation"],
        hydrostatic_stiffness=stiffness,
        buoyancy=buoyancy,
    )
    return replace(
        result,
        wave_direction=wave_direction,
        density=water.density,
        depth=water.depth,
        gravity=water.gravity,
    )
