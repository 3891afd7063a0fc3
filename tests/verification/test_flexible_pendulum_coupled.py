"""The flexible pendulum as two FMUs through the master: examples/flexible_pendulum.

Sabet and Diaz-Flores Caminero, "Multibody for Everybody", section 4.4. Truth is the exact nonlinear
equation, solved to 1e-12; its periods are 20.1367 s (sway), 10.0683 s and 0.62988 s (heave).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.periods import FAST_HEAVE, SLOW_HEAVE, SWAY, pendulum_periods

from m4e_fmi.cosim import load_system, run

EXAMPLE = Path(__file__).parents[2] / "examples" / "flexible_pendulum" / "system.yaml"
MASS, STIFFNESS, LENGTH, GRAVITY = 1e5, 1e9 / 100.5, 100.5, 9.80665
START = (10.0, -100.00216312373226)
# static stretch M g / k, which is the amplitude of the vertical oscillation at the start
VERTICAL_POTENTIAL = 0.5 * STIFFNESS * (MASS * GRAVITY / STIFFNESS) ** 2  # J


def coupled(folder: Path, **settings: Any) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and x, z, vx, vz (4, n) of the mass; `settings` are those of the run."""
    system = load_system(EXAMPLE).changed(**settings)
    outcome = run(system, results=folder / "run.nc", build_directory=folder, certify=False)
    results = outcome.results()
    motion = [results[f"body.body.mass.{name}"].values for name in ("x", "z", "vx", "vz")]
    return results.time, np.array(motion)


def exact(times: np.ndarray) -> np.ndarray:
    def rates(_, state):
        x, z, u, w = state
        length = np.hypot(x, z)
        pull = STIFFNESS * (length - LENGTH) / length / MASS
        return u, w, -pull * x, -pull * z - GRAVITY

    solution = solve_ivp(
        rates,
        (0, times[-1]),
        (*START, 0, 0),
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
        t_eval=times,
    )
    return solution.y


def energy(motion: np.ndarray) -> np.ndarray:
    """Mechanical energy [J] of mass and line."""
    x, z, u, w = motion
    stretch = np.hypot(x, z) - LENGTH
    return MASS * (GRAVITY * z + (u**2 + w**2) / 2) + STIFFNESS * stretch**2 / 2


@pytest.mark.verifies(
    "flexible pendulum as two FMUs, 80 s in steps of 20 ms: periods, energy",
    published="Sabet and Diaz-Flores Caminero, tables 11 and 12; exact nonlinear equation",
    tolerance="1e-3",
)
def test_periods_and_energy_over_eighty_seconds(tmp_path):
    times, motion = coupled(tmp_path)
    found = pendulum_periods(times, motion[0], motion[1])
    assert found == pytest.approx((SWAY, SLOW_HEAVE, FAST_HEAVE), rel=1e-3)
    # the bound: 0.1 % of the initial vertical oscillation's potential
    change = np.abs(energy(motion) - energy(motion)[0])
    assert change.max() < 1e-3 * VERTICAL_POTENTIAL


@pytest.mark.verifies(
    "order of its coupling by `gauss_seidel`",
    analytic="exact nonlinear equation",
    tolerance="order 2 ± 0.1",
)
def test_second_order_against_the_exact_equation(tmp_path):
    errors = []
    for step in (0.01, 0.005, 0.0025):
        settings = {"algorithm": "gauss_seidel", "output_interval": 0.01}
        times, motion = coupled(tmp_path, step_size=step, stop_time=10.0, **settings)
        errors.append(np.abs(motion[:2] - exact(times)[:2]).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    # the next term of the error is (ωH)² ≤ 1 % of the first
    assert orders == pytest.approx([2.0, 2.0], abs=0.1)


@pytest.mark.verifies(
    "its motion over 10 s by default, in steps of 20 ms",
    analytic="exact nonlinear equation",
    tolerance="1.5e-4 m",
)
def test_course_in_steps_of_a_thirtieth_of_the_fast_period(tmp_path):
    times, motion = coupled(tmp_path, stop_time=10.0)
    # fourth order: 16 fast periods of the stretch (0.1 m), each of 2π(ωH)⁴/120 of it
    assert np.abs(motion[:2] - exact(times)[:2]).max() < 1.5e-4
