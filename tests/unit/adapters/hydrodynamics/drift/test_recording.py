"""Recorded drift forces against sums over pairs of waves."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from support.drifting import G, calm, calm_in_space, series

from m4e_adapters.hydrodynamics.config import AnyWaves, Jonswap, Regular, Spreading, Still
from m4e_adapters.hydrodynamics.drift.recording import LEFT_OUT
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift, MeanDrift, Qtf
from m4e_adapters.hydrodynamics.geometry.motions import HEAVE, PITCH, SURGE, SWAY, YAW
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_fmi.program import Program

KNOTS = np.linspace(0.2, 2.6, 25)
AROUND = np.arange(0.0, 360.0, 30.0)
TIMES = np.linspace(40.0, 47.0, 15)
SEA = Jonswap(
    spectrum="jonswap", significant_height=2.0, peak_period=8.0, components=40, ramp_time=0.0
)
WAVE = Regular(spectrum="regular", height=1.6, period=7.0, phase=0.4, ramp_time=0.0)


def surge(w: np.ndarray) -> np.ndarray:
    """Mean drift that changes its sign between long and short waves."""
    return 3e3 * (w - 0.75) / (0.2 + w)


def along(values: np.ndarray, knots: np.ndarray = KNOTS) -> BodyDrift:
    """Surge at `knots` of waves along the hull."""
    return BodyDrift(MeanDrift("hull.8", knots, np.zeros(1), (SURGE,), values[:, None, None]))


def plane() -> BodyDrift:
    values = surge(KNOTS)[:, None, None] * np.array([1.0, -1.0])[:, None]
    return BodyDrift(MeanDrift("hull.8", KNOTS, np.array([0.0, 180.0]), (SURGE,), values))


def around() -> BodyDrift:
    """Three harmonics, that 30 deg resolve."""
    beta = np.radians(AROUND)
    shape = np.stack([np.cos(beta), np.sin(beta) + 0.2, 4.0 * np.sin(2.0 * beta + 0.3)], axis=1)
    values = surge(KNOTS)[:, None, None] * shape
    return BodyDrift(MeanDrift("hull.8", KNOTS, AROUND, (SURGE, SWAY, YAW), values))


def exact(w: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """`around` at any direction [rad], linear in frequency: (k, 3)."""
    shape = np.stack([np.cos(beta), np.sin(beta) + 0.2, 4.0 * np.sin(2.0 * beta + 0.3)], axis=1)
    return np.interp(w, KNOTS, surge(KNOTS))[:, None] * shape


def qtf(w: np.ndarray, scale: float) -> np.ndarray:
    mean = scale * np.outer(w, w) * np.cos(1.5 * np.add.outer(w, w))
    away = np.subtract.outer(w, w)
    return mean * np.exp(-(away**2)) * np.exp(0.8j * away)


def paired() -> BodyDrift:
    values = np.array([[qtf(KNOTS, 4e4), qtf(KNOTS, -1e4), qtf(KNOTS, 2e5)]])
    return BodyDrift(Qtf("hull.12d", KNOTS, np.zeros(1), (SURGE, HEAVE, PITCH), values))


def load(
    drift: BodyDrift,
    waves: AnyWaves,
    *,
    heading: Heading | None = None,
    tell: Callable[[str], object] = lambda _: None,
) -> Program:
    in_space = SWAY in drift.table.motions
    return hydrodynamics_program(
        calm_in_space() if in_space else calm(("float",)),
        waves=waves,
        heading=heading,
        drift={"float": drift},
        progress=tell,
    )


def systems(waves: AnyWaves) -> tuple[WaveSystem, ...]:
    return wave_systems(waves, depth=math.inf, gravity=G)


def double_sum(
    matrix: np.ndarray, omega: np.ndarray, amplitudes: np.ndarray, phases: np.ndarray
) -> np.ndarray:
    """Re Σ a_i a_j Q_ij e^{−i(θ_i − θ_j)} at `TIMES`."""
    waves = amplitudes * np.exp(-1j * (np.outer(TIMES, omega) + phases))
    return np.einsum("ti,ij,tj->t", waves, matrix, waves.conj()).real


def newman(drift: np.ndarray) -> np.ndarray:
    """Geometric means of one sign; 0 where signs differ."""
    root, sign = np.sqrt(np.abs(drift)), np.sign(drift)
    return np.outer(root, root) * np.where(sign[:, None] == sign, sign, 0)


def test_the_ramp_counts_twice() -> None:
    program = load(plane(), WAVE.model_copy(update={"ramp_time": 10.0}))
    found = series(program, np.array([0.0, 2.5, 5.0, 10.0, 20.0]))["float.drift_force_x"]
    assert found / found[-1] == pytest.approx([0.0, 0.1464466**2, 0.25, 1.0, 1.0], abs=1e-6)


@pytest.mark.parametrize(("place", "ahead"), [(30.0, 0.0), (0.0, 30.0)])
def test_a_sea_with_drift_of_both_signs(place: float, ahead: float) -> None:
    """Newman's sum over pairs; the body, or the origin of its file, is 30 m on."""
    drift = {"float": BodyDrift(plane().table, (ahead, 0.0))}
    program = hydrodynamics_program(calm(("float",), places=(place,)), waves=SEA, drift=drift)
    (sea,) = systems(SEA)
    omega, amplitudes = sea.configured()
    phases = sea.phases - 30.0 * wavenumber(omega, depth=math.inf, gravity=G)
    mean = np.interp(omega, KNOTS, surge(KNOTS))
    assert mean.min() < 0 < mean.max()
    expected = double_sum(newman(mean), omega, amplitudes, phases)
    found = series(program, TIMES)["float.drift_force_x"]
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize(("direction", "period"), [(0.0, 7.0), (77.0, 5.0), (211.0, 12.0)])
def test_any_direction_heading_and_period(direction: float, period: float) -> None:
    """Waves and hull turned by 25 deg: the force turns too."""
    program = load(around(), WAVE)
    start = {"wave.direction": math.radians(direction), "wave.period": period}
    found = series(program, TIMES, start)
    beta = np.array([math.radians(direction)])
    (x, y, yaw) = 0.8**2 * exact(np.array([2.0 * math.pi / period]), beta)[0]
    assert found["float.drift_force_x"] == pytest.approx(x, rel=1e-6, abs=1e-6)
    assert found["float.drift_force_y"] == pytest.approx(y, rel=1e-6, abs=1e-6)
    assert found["float.drift_moment_z"] == pytest.approx(yaw, rel=1e-6, abs=1e-6)
    assert "float.drift_force_z" not in found
    turn = math.radians(25.0)
    start["wave.direction"] += turn
    turned = series(program, TIMES, {**start, "heading": turn})
    c, s = math.cos(turn), math.sin(turn)
    assert turned["float.drift_force_x"] == pytest.approx(c * x - s * y, rel=1e-6, abs=1e-6)
    assert turned["float.drift_force_y"] == pytest.approx(s * x + c * y, rel=1e-6, abs=1e-6)


def test_several_systems_and_spreading() -> None:
    """All pairs, those of different systems and directions too."""
    swell = Regular(spectrum="regular", height=1.0, period=11.0, direction=70.0, ramp_time=0.0)
    wind = SEA.model_copy(update={"direction": 20.0, "spreading": Spreading(exponent=6.0)})
    program = load(around(), [wind, swell])
    both = systems([wind, swell])
    omega = np.concatenate([own.configured()[0] for own in both])
    amplitudes = np.concatenate([own.configured()[1] for own in both])
    phases = np.concatenate([own.phases for own in both])
    beta = np.concatenate([math.radians(own.direction) + own.offsets for own in both])
    drift = exact(omega, beta)
    found = series(program, TIMES)
    for name, column in zip(("force_x", "force_y", "moment_z"), drift.T, strict=True):
        expected = double_sum(newman(column), omega, amplitudes, phases)
        assert found[f"float.drift_{name}"] == pytest.approx(expected, rel=1e-6, abs=1e-3)


def test_full_qtfs() -> None:
    """Within what the factors leave out of the standard deviation."""
    lines = list[str]()
    program = load(paired(), SEA, tell=lines.append)
    (sea,) = systems(SEA)
    omega, amplitudes = sea.configured()
    hats = np.array([np.interp(omega, KNOTS, row) for row in np.eye(len(KNOTS))]).T
    found = series(program, TIMES)
    higher = series(program, TIMES, {"wave.significant_height": 4.0})["float.drift_force_x"]
    assert higher == pytest.approx(4.0 * found["float.drift_force_x"])
    assert sum("factors of 25" in line for line in lines) == 3
    for k, name in enumerate(("force_x", "force_z", "moment_y")):
        matrix = hats @ paired().table.values[0, k] @ hats.T
        expected = double_sum(matrix, omega, amplitudes, sea.phases)
        spread = np.linalg.norm(matrix * np.outer(amplitudes, amplitudes))
        error = found[f"float.drift_{name}"] - expected
        assert np.abs(error).max() < 4.0 * LEFT_OUT * spread
        assert np.abs(expected).max() > 0.5 * spread


def test_newman_of_a_qtf_is_that_of_its_mean_drift() -> None:
    """A QTF of geometric means has one factor; below its frequencies it falls as its diagonal."""
    knots = KNOTS[4:]
    drift = np.full(len(knots), 1e3)
    values = np.sqrt(np.outer(drift, drift))[None, None].astype(complex)
    full = Qtf("hull.12d", knots, np.zeros(1), (SURGE,), values)
    one, other = (
        series(load(BodyDrift(own), SEA), TIMES)["float.drift_force_x"] for own in (full, full.mean)
    )
    assert one == pytest.approx(other, rel=1e-9)


def test_directions_that_are_not_all_around_are_fixed() -> None:
    values = np.array([[[w * 1e3, w * 2e3, w * 3e3]] for w in KNOTS])
    drift = BodyDrift(MeanDrift("hull.8", KNOTS, np.array([45.0]), (SURGE, SWAY, YAW), values))
    lines = list[str]()
    wave = WAVE.model_copy(update={"direction": 60.0})
    program = load(drift, wave, heading=Heading(15.0), tell=lines.append)
    assert any("those of the waves are fixed" in line for line in lines)
    limits = {v.name: (v.minimum, v.start, v.maximum) for v in program.parameters}
    assert len(set(limits["heading"])) == len(set(limits["wave.direction"])) == 1
    yaw = series(program, TIMES)["float.drift_moment_z"]
    assert yaw == pytest.approx(0.64 * 3e3 * 2.0 * math.pi / 7.0, rel=1e-6)


def test_long_waves_below_the_table() -> None:
    lines = list[str]()
    program = load(along(np.full(9, 1e3), KNOTS[4:13]), SEA, tell=lines.append)
    assert any("falls as the fourth power of the frequency" in line for line in lines)
    (sea,) = systems(SEA)
    omega, amplitudes = sea.configured()
    drift = 1e3 * np.minimum(omega / KNOTS[4], 1.0) ** 4
    expected = double_sum(newman(drift), omega, amplitudes, sea.phases)
    assert series(program, TIMES)["float.drift_force_x"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("drift", [plane(), paired()])
def test_still_water_does_not_drift(drift: BodyDrift) -> None:
    found = series(load(drift, Still(spectrum="still")), TIMES[:1])
    assert found["float.drift_force_x"] == [0.0]


def test_responses_of_first_order_leave_it_out() -> None:
    coefficients = calm(("float",))
    forces = HullWaves(coefficients=coefficients, water=coefficients)
    program = hydrodynamics_program(
        coefficients, waves=SEA, drift={"float": plane()}, sea=forces.record
    )
    assert series(program, TIMES[:1])["float.drift_force_x"] == [0.0]
