"""Mean drift of one body from the waves that it sends out: momentum in the far field.

With H the Kochin function of the scattered and radiated waves (`flow_solver.FlowSolver.far_field`),
times i, waves of unit amplitude to β make the mean forces

    F_x = −b cos β Im H(β) − c ∫ |H|² cos θ dθ        F_y with sin in place of cos
    M_z = b/k Re H'(β) − c/k ∫ Im(H* H') dθ           b = 2π ρ g k/ω,  c = π ρ g k³/(n ω²)

where n is group velocity over phase velocity, so that b = 2π ρ ω, c = 2π ρ k² in deep water (Maruo
1960; Newman 1967, "The drift force and moment on ships in waves", J. Ship Research 11; in water of
any depth Mei 1989, "The applied dynamics of ocean surface waves", section 7.10).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift, of_motions, wrapped
from m4e_adapters.hydrodynamics.flow.flow_solver import DEEP, FlowSolver
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, SURGE, SWAY, YAW, point_in_space
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_fmi.files.writing import written

DRIFTS = (SURGE, SWAY, YAW)


def far_field_drift(
    hull: Hull,
    *,
    water: Water,
    omega: ArrayLike,
    directions: ArrayLike,
    motions: np.ndarray | None = None,
    progress: Callable[[str], object] = print,
) -> MeanDrift:
    """Mean drift of a hull that is alone in the water, about its centre of gravity.

    Parameters
    ----------
    omega : (nω,) angular frequencies [rad/s], increasing.
    directions : (nβ,) [deg] that waves travel to, increasing from 0 to below 360.
    motions : (nω, nβ, n) complex motions of the hull per wave amplitude [m/m, rad/m], about its
        centre of gravity, e^{−iωt} for a crest at x = y = 0, t = 0; n = 3 or 6 as of its
        `Coefficients`. None: the hull is held.
    progress : is told how far the computation is.

    Returns
    -------
    MeanDrift
        (nω, nβ, m) [N/m2, N.m/m2]: surge, in space also sway and yaw.
    """
    own, frequencies = MOTIONS[len(hull.center)], np.atleast_1d(np.asarray(omega, dtype=float))
    turned = np.array([wrapped(beta) for beta in np.atleast_1d(directions).tolist()])
    shape = (len(frequencies), len(turned), len(own))
    given = np.zeros(shape, dtype=complex) if motions is None else np.asarray(motions)
    if given.shape != shape:
        raise ValueError(f"motions has shape {given.shape}, expected {shape}")
    if np.any(np.diff(turned) <= 0) or np.any(np.diff(frequencies, prepend=0.0) <= 0):
        raise ValueError("omega and directions must be increasing, omega positive")
    solver, values = FlowSolver([hull], water), np.zeros((*shape[:2], len(DRIFTS)))
    for i, w in enumerate(frequencies.tolist()):
        progress(f"mean drift: frequency {i + 1} of {len(frequencies)}")
        k = float(wavenumber(np.array(w), depth=water.depth, gravity=water.gravity))
        order = _order(hull, k)
        angles = 2.0 * math.pi / (4 * order) * np.arange(4 * order)
        radiated, scattered = solver.far_field(w, turned.tolist(), angles)
        kochin = 1j * (scattered + given[i] @ radiated)
        values[i] = [
            _drift(h, math.radians(beta), order, w, k, water)
            for h, beta in zip(kochin, turned, strict=True)
        ]
    x, y, _ = point_in_space(hull.center)
    values[:, :, 2] += y * values[:, :, 0] - x * values[:, :, 1]
    table = MeanDrift(hull.name, frequencies, turned, DRIFTS, values)
    kept = of_motions(table, own)
    assert isinstance(kept, MeanDrift)
    return kept


def _order(hull: Hull, k: float) -> int:
    """Harmonics of a Kochin function about x = y = 0: as of the excitation, and a few more."""
    reach = k * float(np.linalg.norm(hull.panels.vertices[:, :2], axis=1).max())
    return math.ceil(reach + 5.0 * math.cbrt(reach) + 4.0)


def _drift(
    kochin: np.ndarray, beta: float, order: int, omega: float, k: float, water: Water
) -> tuple[float, float, float]:
    """F_x, F_y, M_z per squared amplitude, M_z about x = y = 0.

    `kochin` (nθ,) [m2/s] at nθ equal steps from 0 on, nθ above twice its `order`.
    """
    count = len(kochin)
    steps = np.rint(np.fft.fftfreq(count, 1.0 / count))
    parts = np.where(np.abs(steps) <= order, np.fft.fft(kochin) / count, 0.0)
    slopes = 1j * steps * parts
    turn = np.exp(1j * steps * beta)
    here, slope_here = complex(parts @ turn), complex(slopes @ turn)
    slope = np.fft.ifft(slopes) * count
    theta, step = 2.0 * math.pi / count * np.arange(count), 2.0 * math.pi / count
    b = 2.0 * math.pi * water.density * water.gravity * k / omega
    group = 0.5
    if (kh := k * water.depth) < DEEP:
        group += kh / math.sinh(2.0 * kh)
    c = math.pi * water.density * water.gravity * k**3 / (group * omega**2)
    square = np.abs(kochin) ** 2
    return (
        -b * math.cos(beta) * here.imag - c * step * float(square @ np.cos(theta)),
        -b * math.sin(beta) * here.imag - c * step * float(square @ np.sin(theta)),
        b / k * slope_here.real - c / k * step * float(np.sum(kochin.conj() * slope).imag),
    )


def write_csv(table: MeanDrift, path: Path) -> None:
    """Write a table as the CSV file that `drift: {file: …}` reads."""
    names = ["omega", "direction", *(motion.name for motion in table.motions)]
    lines = [",".join(names)]
    for w, rows in zip(table.omega.tolist(), table.values, strict=True):
        for beta, row in zip(table.directions.tolist(), rows.tolist(), strict=True):
            lines.append(",".join(f"{value:.9g}" for value in (w, beta, *row)))
    with written(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
