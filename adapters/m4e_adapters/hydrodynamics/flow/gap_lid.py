"""Damped lids on the water between hulls: panels, and their condition in the integral equation.

Without viscosity the water in a narrow gap resonates far too much. On a lid, a part of the free
surface, a resistance ρ ν per area and per vertical velocity acts: φ_tt + ν φ_t + g φ_z = 0, so

    ∂φ/∂z = (ω² + i ω ν)/g · φ = (K + δ) φ,  K = ω²/g

(X.-B. Chen 2004, with ν = ε ω there). The Green function G has ∂G/∂z = K G at the free surface, so
that a lid adds δ ∫ G φ dS to the direct integral equation and nothing else: no source of its own,
no wave but those that the equation makes. With the potential on the lid as further unknowns its
matrix gets the columns δ S, and 1 + δ S at the lid. Waves that come in are scattered by −δ φ of
theirs. The condition is linear and causal, and takes ½ ρ ν ω²/g ∫ |φ|² dS of power.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from m4e_adapters.hydrodynamics.config import GapLid
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.lid import loops, waterline
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid, joined
from m4e_fmi.errors import InputError, Problem

if TYPE_CHECKING:
    from capytaine import DefaultMatrixEngine, DiffractionProblem

FEWEST = 2  # panels across half a lid
INSIDE = 1e-3  # of a panel's side, by which it may reach over a waterline


@dataclass(frozen=True)
class DampedLid:
    """`panels` at z = 0 outside of all hulls, normals down, each with its `damping` (nf,) [1/s]."""

    panels: Panels
    damping: np.ndarray

    def rates(self, centers: np.ndarray) -> np.ndarray:
        """The damping (n,) [1/s] of panels with these `centers` (n, 3) [m], 0 of those of hulls."""
        from scipy.spatial import KDTree

        reach = 1e-6 * self.panels.size
        distance, k = KDTree(self.panels.centers).query(centers)
        return np.where(distance < reach, self.damping[np.asarray(k)], 0.0)


def damped_lid(lids: Sequence[GapLid], hulls: Sequence[Hull]) -> DampedLid | None:
    """The lids as one, without the panels that reach into a hull; None of none.

    InputError for lids that overlap, or are not on free water.
    """
    if not lids:
        return None
    problems = list(_overlaps(lids))
    found: list[tuple[Panels, float]] = []
    side = min(math.sqrt(np.linalg.norm(hull.panels.normals, axis=1).mean()) for hull in hulls)
    surfaces = [hull.closed for hull in hulls]
    hull_lines = [[s.vertices[loop] for loop in loops(waterline(s))] for s in surfaces]
    for k, lid in enumerate(lids):
        panels = _grid(lid, side)
        covered = np.zeros(len(panels.faces), dtype=bool)
        for lines in hull_lines:
            covered |= _covers(lines, panels)
        free = panels.selected(~covered)
        if not len(free.faces):
            text = f"gap lid {k + 1} is not on free water: hulls cover all of it"
            remedy = "give the middle, length and width of the gap: center_x, center_y, ..."
            problems.append(Problem(text, remedy, keys=("gap_lids", k)))
        found.append((free, lid.damping))
    InputError.raise_for(problems)
    panels = joined(*(part for part, _ in found))
    rates = np.repeat([rate for _, rate in found], [len(part.faces) for part, _ in found])
    return DampedLid(panels, rates)


def _overlaps(lids: Sequence[GapLid]) -> Iterator[Problem]:
    for k, second in enumerate(lids):
        for first in lids[:k]:
            x = abs(first.center_x - second.center_x)
            y = abs(first.center_y - second.center_y)
            room = 1.0 - 1e-9
            if (
                2 * x < (first.length + second.length) * room
                and 2 * y < (first.width + second.width) * room
            ):
                text = f"gap lid {k + 1} overlaps another one"
                yield Problem(text, "give each part of the water one lid", keys=("gap_lids", k))


def _grid(lid: GapLid, side: float) -> Panels:
    """A rectangle of nearly square panels, normals down."""
    along, across = (2 * max(FEWEST, math.ceil(0.5 * w / side)) for w in (lid.length, lid.width))
    x = lid.center_x + lid.length * (np.arange(along + 1) / along - 0.5)
    y = lid.center_y + lid.width * (np.arange(across + 1) / across - 0.5)
    return grid(np.array([[(u, v, 0.0) for u in x] for v in y]))


def _covers(lines: Sequence[np.ndarray], panels: Panels) -> np.ndarray:
    """Which panels reach into a hull with these closed waterlines (n, 3) [m], (nf,).

    Lines within others are around free water.
    """
    corners = panels.corners + INSIDE * (panels.centers[:, None] - panels.corners)
    points = np.concatenate([corners, panels.centers[:, None]], axis=1)
    x, y = points[..., 0, None], points[..., 1, None]
    crossed = np.zeros(points.shape[:2], dtype=int)
    for line in lines:
        a, b = line, np.roll(line, -1, axis=0)
        between = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
        right = x < a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
        crossed += (between & right).sum(axis=-1)
    return (crossed % 2 == 1).any(axis=1)


def damped_engine(lid: DampedLid, gravity: float) -> DefaultMatrixEngine:
    """Capytaine's engine of matrices, with the condition on the lid; for the direct method.

    `gravity` [m/s2].
    """
    capytaine = import_capytaine()
    from capytaine.tools.block_circulant_matrices import (
        BlockCirculantMatrix,
        NestedBlockCirculantMatrix,
    )

    class GapLidEngine(capytaine.DefaultMatrixEngine):
        def _build_matrices_with_symmetries(self, mesh1, mesh2, **given):  # pyrefly: ignore[implicit-any-parameter, unannotated-return]
            S, D = super()._build_matrices_with_symmetries(mesh1, mesh2, **given)
            omega = _omega(given["wavenumber"], given["water_depth"], gravity)
            if not 0.0 < omega < math.inf:
                return S, D
            nested, factor = isinstance(D, NestedBlockCirculantMatrix), omega / gravity
            if not (nested or isinstance(D, BlockCirculantMatrix)):
                return S, _with_lid(S, D, lid.rates(mesh2.faces_centers), factor, own=True)
            part = mesh2.half.half if nested else mesh2.half
            rates = lid.rates(part.faces_centers)
            blocks = [
                _with_lid(np.asarray(s), np.asarray(d), rates, factor, own=k == 0)
                for k, (s, d) in enumerate(zip(S.blocks, D.blocks, strict=True))
            ]
            return S, type(D)(np.array(blocks))

    return GapLidEngine()


def _with_lid(
    S: np.ndarray, D: np.ndarray, rates: np.ndarray, factor: float, *, own: bool
) -> np.ndarray:
    """D (n, n) [1] with the columns of the lid's panels: δ S, and 1 for their `own` potentials.

    S (n, n) [m]; `rates` (n,) [1/s] are 0 beside the lid; δ = i `factor` ν, `factor` in s/m.
    """
    result = np.array(D, dtype=complex)
    there = np.flatnonzero(rates)
    result[:, there] = 1j * factor * rates[there] * np.asarray(S)[:, there]
    if own:
        result[there, there] += 1.0
    return result


def _omega(wavenumber: float, depth: float, gravity: float) -> float:
    """Angular frequency [rad/s] of waves of a `wavenumber` [1/m] in water of `depth` [m]."""
    k = float(wavenumber)
    if math.isinf(k):
        return k
    return math.sqrt(gravity * k * (1.0 if math.isinf(depth) else math.tanh(k * depth)))


def scatter_at_lid(problem: DiffractionProblem, rates: np.ndarray, *, omega: float) -> None:
    """Let the incident waves of a diffraction `problem` be scattered by the lid.

    `rates` (nf,) [1/s] are those of all panels, hulls and lids; `omega` [rad/s].
    """
    from capytaine.bem.airy_waves import airy_waves_potential

    assert problem.body is not None
    there = np.flatnonzero(rates)
    points = problem.body.mesh_including_lid.faces_centers[there]
    delta = 1j * omega * rates[there] / problem.g
    problem.boundary_condition[there] = -delta * airy_waves_potential(points, problem)
