"""Free decay: exact solutions are found again, and records that are none are told."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from m4e_fmi.analysis.decay import decay_notes, fit_decay
from m4e_fmi.errors import M4eError

DATA = Path(__file__).parents[2] / "data" / "hydrodynamics"
PERIOD, OMEGA = 4.0, 2.0 * math.pi / 4.0
TIME = np.arange(0.0, 40.0, 0.05)


def linear(ratio: float, *, rest: float = 0.0, release: float = 1.0) -> np.ndarray:
    """Exact motion (n,) [m] at TIME, released from rest."""
    damped = OMEGA * math.sqrt(1.0 - ratio**2)
    turned = np.cos(damped * TIME) + ratio * OMEGA / damped * np.sin(damped * TIME)
    return rest + release * np.exp(-ratio * OMEGA * TIME) * turned


def quadratic(ratio: float, b: float, *, release: float = 1.0) -> np.ndarray:
    """Motion (n,) [m] at TIME with quadratic damping, by an integrator other than the fit's."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        x, v = y
        return [v, -2 * ratio * OMEGA * v - b * abs(v) * v - OMEGA**2 * x]

    found = solve_ivp(
        rates, (0, TIME[-1]), [release, 0.0], "DOP853", t_eval=TIME, rtol=1e-12, atol=1e-13
    )
    return found.y[0]


@pytest.mark.parametrize(("ratio", "release"), [(0.05, 1.2), (0.002, -0.03), (0.2, 50.0)])
def test_an_exact_linear_motion(ratio: float, release: float) -> None:
    found = fit_decay(TIME, linear(ratio, rest=0.3 * release, release=release))
    assert found.period.value == pytest.approx(PERIOD, rel=1e-6)
    assert found.damping_ratio.value == pytest.approx(ratio, abs=1e-6)
    assert found.quadratic.value * abs(release) == pytest.approx(0.0, abs=1e-6)
    assert found.rest.value == pytest.approx(0.3 * release, rel=1e-6)
    assert found.damped_period.value == pytest.approx(PERIOD / math.sqrt(1 - ratio**2), rel=1e-6)
    assert found.window.reason == "from the first peak after the release"
    assert found.window.start == pytest.approx(found.damped_period.value / 2, abs=0.05)
    assert found.residual_share < 1e-8


@pytest.mark.parametrize(("ratio", "b"), [(0.0, 0.5), (0.02, 0.2), (0.03, 2.0)])
def test_a_motion_with_quadratic_damping(ratio: float, b: float) -> None:
    found = fit_decay(TIME, quadratic(ratio, b))
    assert found.period.value == pytest.approx(PERIOD, rel=1e-6)
    assert found.damping_ratio.value == pytest.approx(ratio, abs=1e-6)
    assert found.quadratic.value == pytest.approx(b, rel=1e-5)
    assert found.quadratic_coefficient(mass=3e5).value == pytest.approx(3e5 * b, rel=1e-5)
    spring = found.quadratic_coefficient(stiffness=3e5 * OMEGA**2)
    assert spring.value == pytest.approx(3e5 * b, rel=1e-5)
    linear_part = found.linear_coefficient(mass=3e5).value
    assert linear_part == pytest.approx(2 * ratio * OMEGA * 3e5, abs=1e-5 * 3e5)


def test_odd_rows_do_no_harm_and_are_told() -> None:
    """Uneven rows, a gap, a rest that drifts; what is before the release is left out."""
    random = np.random.default_rng(3)
    kept = np.sort(random.choice(len(TIME), 500, replace=False))
    held = np.concatenate([np.full(200, 1.0), linear(0.05)])
    pushed = np.concatenate([linear(0.03)[::-1], linear(0.05)[1:]])
    shaken = TIME + random.uniform(-0.01, 0.01, len(TIME))
    turned = np.exp(-0.05 * OMEGA * shaken) * np.cos(OMEGA * shaken)
    for time, motion, error, note in (
        (TIME[kept], linear(0.05)[kept], 1e-6, "gap from"),
        (0.05 * np.arange(len(held)), held, 1e-6, ""),
        (0.05 * np.arange(len(pushed)), pushed, 1e-6, ""),
        (shaken, turned, 1e-4, "unevenly spaced"),  # it has another phase
        (TIME, linear(0.05) + 0.004 * TIME, 3e-3, "rest drifts by"),  # which the model has not
    ):
        found = fit_decay(time, motion)
        assert found.damping_ratio.value == pytest.approx(0.05, abs=error)
        assert note in "".join(decay_notes(found))
    assert found.trend.value == pytest.approx(0.004 * np.ptp(found.time), rel=0.05)
    assert not any("rest drifts" in note for note in decay_notes(fit_decay(TIME, linear(0.05))))


def test_a_short_noisy_record_does_not_separate_linear_and_quadratic_damping() -> None:
    noise = 0.02 * np.random.default_rng(2).normal(size=len(TIME))
    few = TIME < 12.0
    found = fit_decay(TIME[few], (quadratic(0.02, 0.1) + noise)[few])
    assert found.correlation < -0.95
    assert any("cannot be separated" in note for note in decay_notes(found))
    surest = found.equivalent_ratio(found.surest_amplitude)
    assert surest.error < 0.3 * found.damping_ratio.error
    truth = 0.02 + 4 / (3 * math.pi) * 0.1 * found.surest_amplitude
    assert abs(surest.value - truth) < 3 * surest.error


def test_the_sphere_of_the_comparison() -> None:
    """Heave of a sphere with radiation memory: nearly such a motion, which the residual tells.

    Half a decrement per period is about 0.295 throughout, a linear ratio of 0.0935.
    """
    time, heave = np.loadtxt(DATA / "oes10_sphere_decay_1m.csv", delimiter=",").T
    found = fit_decay(time, heave)
    assert 0.0005 < found.residual_share < 0.005
    surest = found.equivalent_ratio(found.surest_amplitude)
    assert surest.value == pytest.approx(0.0935, abs=0.002)
    decrement = float(found.peaks.decrements[:8].mean())
    assert surest.value == pytest.approx(decrement / math.hypot(math.pi, decrement), rel=0.02)
    assert abs(found.quadratic.value) < 2 * found.quadratic.error


NOISE = np.random.default_rng(4).normal(size=len(TIME))
OVERDAMPED = np.exp(-TIME) * (1 + TIME)


@pytest.mark.parametrize(
    ("time", "motion", "start", "said"),
    [
        (TIME, OVERDAMPED, None, "comes to rest without an oscillation"),
        (TIME, linear(0.01)[::-1], None, "grows"),
        (TIME, linear(0.01)[::-1], 5.0, "grows from 5"),
        (TIME, linear(0.05), 50.0, "0 rows from 50 s|0 rows from 50 to"),
        (TIME[:60], linear(0.05)[:60], None, "the record ends at 2.95 s, too early"),
        (TIME[:5], TIME[:5], None, "5 rows, at least 12"),
        (TIME, np.ones(len(TIME)), None, "nothing moves"),
        (TIME, np.where(TIME[7] == TIME, np.nan, linear(0.1)), None, "row 7 of .* is not finite"),
        (np.where(TIME[7] == TIME, 0.1, TIME), linear(0.1), None, "does not increase in row 7"),
        (TIME, TIME[:-1], None, "not of one length"),
        (TIME, NOISE, None, "."),
        (TIME, OVERDAMPED + 0.2 * NOISE, None, "."),
    ],
)
def test_records_that_are_no_decay(
    time: np.ndarray, motion: np.ndarray, start: float | None, said: str
) -> None:
    with pytest.raises(M4eError, match=said):
        fit_decay(time, motion, start=start)
