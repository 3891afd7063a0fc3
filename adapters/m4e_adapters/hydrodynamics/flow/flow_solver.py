"""Potential flow of hulls at one frequency at a time, by Capytaine.

The direct boundary integral equation is used: its forces on a smooth closed surface converge with
the square of the panel size, those of Capytaine's default ("indirect") only with the first power.
With a waterline the observed order is 1.4 (added mass) and 0.9 (at infinite frequency).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np

from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.flow.capytaine_setup import (
    accurate_finite_depth,
    import_capytaine,
    kept_warnings,
)
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_fmi.errors import RunError

METHOD = "direct"
DEEP = 20.0  # wavenumber times depth of water without a bottom
MIRRORED = {1: ("sway", "roll", "yaw"), 0: ("surge", "pitch", "yaw")}
"""Motions that change sign in the mirror image in y = 0 (1) and in x = 0 (0)."""


class FlowSolver:
    """Radiation and diffraction of all hulls together, interactions included."""

    def __init__(self, hulls: Sequence[Hull], water: Water) -> None:
        self._capytaine = import_capytaine()
        self._medium = {"water_depth": water.depth, "rho": water.density, "g": water.gravity}
        self._solver = self._capytaine.BEMSolver(method=METHOD)
        with kept_warnings() as self._warnings:
            self._body = capytaine_body(self._capytaine, hulls)
        self._signs = _signs(hulls)

    def at(self, omega: float, directions: Sequence[float]) -> dict[str, np.ndarray]:
        """Solution at `omega` [rad/s] for nβ `directions` [deg]: (n, n) and (nβ, n), SI.

        Keys: `added_mass` and `radiation_damping` (n, n), `excitation` (nβ, n), 0 at infinity, as
        of `Coefficients`; `warnings` (texts). RunError if there is no solution.
        """
        names = list(self._body.dofs)
        n = len(names)
        added_mass, damping = np.zeros((2, n, n))
        excitation = np.zeros((len(directions), n), dtype=complex)
        common = {"body": self._body, "omega": omega, **self._medium}
        with kept_warnings() as warnings, accurate_finite_depth():
            for j, name in enumerate(names):
                problem = self._capytaine.RadiationProblem(radiating_dof=name, **common)
                result = _solution(self._solver, problem, omega)
                added_mass[:, j] = [result.added_masses[i] for i in names]
                damping[:, j] = [result.radiation_dampings[i] for i in names]
            for j, direction in enumerate(directions if math.isfinite(omega) else ()):
                angle = math.radians(direction)
                problem = self._capytaine.DiffractionProblem(wave_direction=angle, **common)
                result = _solution(self._solver, problem, omega)
                incident = self._capytaine.bem.airy_waves.froude_krylov_force(problem)
                excitation[j] = [result.forces[i] + incident[i] for i in names]
        alike = np.ones((n, n), dtype=bool)
        for signs in self._signs:
            alike &= np.equal.outer(signs, signs)
        return {
            "added_mass": added_mass * alike,
            "radiation_damping": damping * alike,
            "excitation": excitation,
            "warnings": np.array([*self._warnings, *warnings], dtype=str),
        }

    def far_field(
        self, omega: float, directions: Sequence[float], angles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Kochin functions H at `omega` [rad/s], of unit motions (n, nθ), of unit waves (nβ, nθ).

        In m2/s and m3/s, m2/s; for waves from `directions` [deg], at `angles` (nθ,) [rad]. With the
        potential φ and its normal derivative on the hull, 4π H(θ) = ∫ (∂φ/∂n − φ ∂/∂n) e dS, where
        e = cosh k(z + h)/cosh kh · e^{−ik(x cos θ + y sin θ)}, k the wavenumber, h the depth.
        """
        common = {"body": self._body, "omega": omega, **self._medium}
        with kept_warnings(), accurate_finite_depth():
            problems = [
                self._capytaine.RadiationProblem(radiating_dof=name, **common)
                for name in self._body.dofs
            ]
            problems += [
                self._capytaine.DiffractionProblem(wave_direction=math.radians(beta), **common)
                for beta in directions
            ]
            mesh, water = self._body.mesh, problems[0]
            wave, slope = _outgoing(
                mesh.faces_centers,
                mesh.faces_normals,
                angles,
                k=water.wavenumber,
                depth=water.water_depth,
            )
            found = []
            for problem in problems:
                result = _solution(self._solver, problem, omega, details=True)
                on_hull = self._body.hull_mask
                flux = mesh.faces_areas * problem.boundary_condition[on_hull]
                potential = mesh.faces_areas * result.potential[on_hull]
                found.append(flux @ wave - potential @ slope)
        count = len(self._body.dofs)
        both = np.array(found) / (4.0 * math.pi)
        return both[:count], both[count:]


def _outgoing(
    centers: np.ndarray, normals: np.ndarray, angles: np.ndarray, *, k: float, depth: float
) -> tuple[np.ndarray, np.ndarray]:
    """e of `FlowSolver.far_field` and its normal derivative, (nf, nθ) [1] and [1/m].

    On panels with `centers` (nf, 3) [m] and `normals` (nf, 3) [1], at `angles` (nθ,) [rad], for the
    wavenumber `k` [rad/m] in water of `depth` [m].
    """
    x, y, z = centers.T
    across, athwart, up = normals.T
    if k * depth < DEEP:
        profile = np.cosh(k * (z + depth)) / math.cosh(k * depth)
        rise = np.tanh(k * (z + depth))
    else:
        profile, rise = np.exp(k * z), np.ones_like(z)
    way = np.outer(x, np.cos(angles)) + np.outer(y, np.sin(angles))
    wave = profile[:, None] * np.exp(-1j * k * way)
    along = np.outer(across, np.cos(angles)) + np.outer(athwart, np.sin(angles))
    return wave, k * wave * ((up * rise)[:, None] - 1j * along)


def _solution(solver: Any, problem: Any, omega: float, *, details: bool = False) -> Any:
    from capytaine.green_functions.abstract_green_function import GreenFunctionEvaluationError

    try:
        return solver.solve(problem, keep_details=details, _check_wavelength=False)
    except GreenFunctionEvaluationError as error:
        raise RunError(
            f"the potential flow cannot be solved at {omega:.4g} rad/s: {error}",
            "look for panels that overlap or touch those of another body; else raise "
            "frequencies.minimum",
        ) from None


def _planes(hulls: Sequence[Hull]) -> list[int]:
    """The planes y = 0 (1) and x = 0 (0) in which all hulls are their own mirror images."""
    surfaces = [p for hull in hulls for p in (hull.panels, hull.lid) if p is not None]
    return [axis for axis in (1, 0) if all(p.half(axis) is not None for p in surfaces)]


def _signs(hulls: Sequence[Hull]) -> list[np.ndarray]:
    """+1 or −1 of each motion (n,) in the mirror images in those planes that hold all centres too.

    Motions of different signs do not feel each other.
    """
    found = []
    for axis in _planes(hulls):
        moving = [hull for hull in hulls if not hull.fixed]
        if any(point_in_space(hull.center)[axis] for hull in moving):
            continue
        motions = [motion.name for hull in moving for motion in MOTIONS[len(hull.center)]]
        found.append(np.array([-1.0 if name in MIRRORED[axis] else 1.0 for name in motions]))
    return found


def capytaine_body(capytaine: ModuleType, hulls: Sequence[Hull]) -> Any:
    """All hulls as one Capytaine body; planes of symmetry that all share are used.

    Capytaine's rotations are ours, about +X, +Y, +Z: Pitch is v = (z, 0, −x) at (x, y, z) from the
    centre and turns +Z towards +X.
    """
    planes = _planes(hulls)

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
        dofs = {}
        if not hull.fixed:
            names = [motion.name.capitalize() for motion in MOTIONS[len(hull.center)]]
            center = point_in_space(hull.center)
            dofs = capytaine.rigid_body_dofs(rotation_center=center, only=names)
        bodies.append(
            capytaine.FloatingBody(
                mesh=mesh(hull.panels), lid_mesh=mesh(hull.lid), dofs=dofs, name=f"body{k}"
            )
        )
    return capytaine.Multibody(bodies) if len(bodies) > 1 else bodies[0]
