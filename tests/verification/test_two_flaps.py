"""examples/two_flaps: beside Capytaine used by itself, and time beside frequency domain.

The table of Capytaine is of its own meshes (sides of 0.7 m) and of two motions only, the turns
about the hinges; `tests/verify` makes it anew, and the example's own coefficients.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, run, system_program
from m4e_fmi.simulate import simulate

EXAMPLE = Path(__file__).parents[2] / "examples" / "two_flaps"
TABLE = Path(__file__).parents[1] / "data" / "hydrodynamics" / "two_flaps_capytaine.csv"
MASS, ARM, DAMPING, DENSITY, GRAVITY = 60e3, 5.5, 1.2e7, 1025.0, 9.81
INERTIA = 0.65e6 + MASS * ARM**2  # about the hinge
LENGTH, WIDTH, DRAFT = 1.8, 10.0, 8.0
VOLUME, BUOYANCY_ARM = LENGTH * WIDTH * DRAFT, 9.5 - DRAFT / 2
STIFFNESS = GRAVITY * (
    DENSITY * VOLUME * BUOYANCY_ARM + DENSITY * WIDTH * LENGTH**3 / 12 - MASS * ARM
)


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    monkeypatch.delitem(sys.modules, "two_flaps", raising=False)
    return importlib.import_module("two_flaps")


def table() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Periods (n,) [s], A and B (n, 2, 2), X (n, 2) of the turns about the hinges."""
    rows = np.loadtxt(TABLE, delimiter=",")
    n = len(rows)
    a, b = rows[:, 1:5].reshape(n, 2, 2), rows[:, 5:9].reshape(n, 2, 2)
    return rows[:, 0], a, b, rows[:, 9::2] + 1j * rows[:, 10::2]


@pytest.mark.verifies(
    "angles of two flaps above a base in waves of 4 to 14 s, with take-offs",
    independent="Capytaine by itself, frequency domain, turns about the hinges",
    tolerance="0.01, 1.5°",
)
def test_responses(example: ModuleType) -> None:
    periods, a, b, x = table()
    omega = (2 * np.pi / periods)[:, None, None]
    matrix = STIFFNESS * np.eye(2) - omega**2 * (INERTIA * np.eye(2) + a)
    matrix = matrix - 1j * omega * (b + DAMPING * np.eye(2))
    expected = np.linalg.solve(matrix, x[:, :, None])[:, :, 0]
    found = np.stack([*example.responses(periods=periods).values()], axis=1)
    ratio = found / expected
    assert np.abs(np.abs(ratio) - 1).max() < 0.01
    # at 4 s, where the water between the flaps resonates, 0.9 deg; else below 0.3 deg
    assert np.abs(np.degrees(np.angle(ratio))).max() < 1.5


@pytest.mark.verifies(
    "natural periods of both motions of two flaps without take-offs",
    independent="Capytaine by itself, added mass at 14 s",
    tolerance="0.01",
)
def test_natural_periods(example: ModuleType) -> None:
    """Both in one direction, and against each other: symmetric flaps have these modes."""
    _, a, _, _ = table()
    together, against = a[-1, 0, 0] + a[-1, 0, 1], a[-1, 0, 0] - a[-1, 0, 1]
    expected = [2 * np.pi * np.sqrt((INERTIA + m) / STIFFNESS) for m in (together, against)]
    found = sorted(example.natural_periods())
    np.testing.assert_allclose([length for length, _ in found], expected, rtol=0.01)
    assert found[1][1] < found[0][1] < 0.05  # waves of flaps that go against each other cancel


@pytest.mark.verifies(
    "the same flaps, response in the frequency domain beside simulated small waves of 4 to 14 s",
    independent="DOP853",
    tolerance="3e-3",
)
def test_time_and_frequency_domain(example: ModuleType, tmp_path: Path) -> None:
    for path in (EXAMPLE / "flaps.model.yaml", EXAMPLE / "flaps.nc"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (EXAMPLE / "system.yaml").read_text("utf-8")
    (own,) = (line for line in text.splitlines() if line.startswith("    waves:"))
    regular = "    waves: {spectrum: regular, height: 0.002, period: 8, ramp_time: 8}"
    (tmp_path / "system.yaml").write_text(text.replace(own, regular), "utf-8")
    program = system_program(load_system(tmp_path / "system.yaml"))
    periods = np.array([4.0, 5.0, 6.5, 8.0, 10.0, 12.0, 14.0])
    expected = example.responses(periods=periods)
    for k, period in enumerate(periods.tolist()):
        waves = program.with_start({"sea.wave.period": period})
        stop, every = 16 * period, period / 32
        found = simulate(waves, stop_time=stop, output_interval=every, tolerance=1e-10)
        last = slice(-4 * 32, None)
        turn = np.exp(2j * np.pi / period * np.asarray(found.time)[last])
        for flap, angle in zip(example.FLAPS, example.ANGLES, strict=True):
            first = 2 * np.mean(np.asarray(found[angle])[last] * turn) / 0.001
            assert abs(first - expected[flap][k]) < 3e-3 * abs(expected[flap][k])


def test_a_decay_couples_the_flaps_and_loses_energy(example: ModuleType) -> None:
    times, angles = example.decay(0.0)
    fore, aft = (np.abs(angles[flap]) for flap in example.FLAPS)
    late = times > 30.0
    assert aft[0] == 0.0
    assert aft[late].max() > 0.2 * fore[0]
    assert fore[late].max() < fore[0]
    _, damped = example.decay(DAMPING)
    assert np.abs(damped["fore"][late]).max() < 1e-3 * fore[0]


@pytest.mark.verifies(
    "energy of two flaps that meet their stops in a high sea: lost or made, of what was exchanged",
    analytic="what one gives the other receives",
    tolerance="1e-3",
)
def test_stops_hold_in_a_high_sea(tmp_path: Path) -> None:
    start = {"sea.wave.significant_height": 5.0}
    system = load_system(EXAMPLE / "system.yaml").changed(start=start, stop_time=80.0)
    outcome = run(system, results=tmp_path / "r.nc", build_directory=tmp_path)
    results = outcome.results()
    angles = [np.degrees(results[f"device.body.{f}.theta"].values) for f in ("fore", "aft")]
    speeds = [np.degrees(results[f"device.body.{f}.omega"].values) for f in ("fore", "aft")]
    # as deep as the fastest flap, water included, would swing on the spring of a stop alone
    _, a, _, _ = table()
    deepest = np.abs(speeds).max() * np.sqrt((INERTIA + a[:, 0, 0].max()) / 1e9)
    assert 25.0 < np.abs(angles).max() < 25.0 + deepest
    assert results["device.load.fore_stop.gap"].values.min() < 0.0
    for bond in outcome.energy:
        assert abs(bond.received - bond.given) < 1e-3 * bond.exchanged
