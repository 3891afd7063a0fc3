"""Responses to waves beside simulations of the system's own waves, and beside exact solutions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from support.floating_buoy import held_buoy
from support.published_coefficients import sphere
from support.response_in_time import compared_in_time

from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_fmi.analysis import OperatingPoint, equilibrium, frequency_response, linearize
from m4e_fmi.analysis.points import Floats
from m4e_fmi.analysis.response import (
    InWaves,
    Sea,
    sea_response,
    wave_response,
)
from m4e_fmi.analysis.response.waves import Complex
from m4e_fmi.cosim import load_system, system_in_waves, system_program
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.simulate import simulate

HEAVE, PITCH, SURGE = "buoy.body.float.z", "buoy.body.float.theta", "buoy.body.float.x"
PERIODS = np.linspace(4.0, 13.0, 10)
HIGHEST = 2.0 * np.pi / 4.0
MEASURED, RUN = 20, 60


@pytest.fixture(scope="module")
def buoy(tmp_path_factory: pytest.TempPathFactory) -> tuple[InWaves, OperatingPoint]:
    path = held_buoy(tmp_path_factory.mktemp("buoy"))
    waves = system_in_waves(load_system(path), highest=HIGHEST)
    return waves, equilibrium(waves.program)


def harmonics(
    folder: Path, period: float, height: float, start: dict[str, float], names: list[str]
) -> tuple[dict[str, complex], dict[str, float]]:
    """First harmonics per amplitude and means of the system in its own regular waves."""
    waves = f"{{spectrum: regular, height: {height!r}, period: {period!r}, ramp_time: 0}}"
    program = system_program(load_system(held_buoy(folder, waves)))
    start = {v.name: start[v.name] for v in program.states if v.name in start}
    run = simulate(
        program.with_start(start),
        stop_time=RUN * period,
        output_interval=period / 64,
        tolerance=min(1e-8, 1e-6 * height),
    )
    last = slice(-MEASURED * 64, None)
    turn = np.exp(2j * np.pi / period * np.asarray(run.time)[last])
    values = {name: np.asarray(run[name])[last] for name in names}
    first = {name: complex(4.0 / height * np.mean(y * turn)) for name, y in values.items()}
    return first, {name: float(y.mean()) for name, y in values.items()}


def started(point: OperatingPoint, states: np.ndarray, amplitude: float) -> dict[str, float]:
    """States of a steady motion at t = 0; those of the memory of a program have its names."""
    names = [v.name for v in point.program.states]
    return dict(zip(names, (point.states + amplitude * np.real(states)).tolist(), strict=True))


def ordered(waves: InWaves, point: OperatingPoint, states: np.ndarray) -> np.ndarray:
    """`states` in the order of the program, from that of its linear equations."""
    order = [v.name for v in linearize(waves.program, at=point).states]
    found = dict(zip(order, states, strict=True))
    return np.array([found.get(v.name, 0.0) for v in waves.program.states])


@pytest.mark.verifies(
    "RAOs of a buoy with a take-off, ten periods: heave and take-off 0.1 %, pitch 0.2 %, 0.2°",
    independent="simulation of the system in its own regular waves, DOP853",
    tolerance="0.1 %, 0.2 %, 0.2°",
)
def test_small_waves(buoy: tuple[InWaves, OperatingPoint], tmp_path: Path) -> None:
    waves, point = buoy
    height = 2e-4
    names = [HEAVE, PITCH, SURGE, "generator.pto.force_z"]
    response = wave_response(waves, point, periods=PERIODS, outputs=names)
    for k, period in enumerate(PERIODS.tolist()):
        start = started(point, ordered(waves, point, response.states[0, k]), height / 2)
        found, _ = harmonics(tmp_path, period, height, start, names)
        for name in names:
            ratio = response.of(name)[k] / found[name]
            limit = 2e-3 if name == PITCH else 1e-3
            assert abs(ratio) == pytest.approx(1.0, abs=limit), (name, period)
            assert abs(np.degrees(np.angle(ratio))) < 0.2, (name, period)


@pytest.mark.verifies(
    "first harmonics with drag in waves of 2 m: 3 % where the third is below 5 %, mean power 1 %",
    independent="simulation of the system in its own regular waves, DOP853",
    tolerance="3 %, 1 %",
)
def test_waves_of_two_metres(buoy: tuple[InWaves, OperatingPoint], tmp_path: Path) -> None:
    waves, point = buoy
    names = [HEAVE, PITCH, SURGE, "generator.power"]
    periods = [4.0, 5.0, 6.0, 8.0, 11.0]
    small = wave_response(waves, point, periods=periods, outputs=names[:3])
    response = wave_response(waves, point, periods=periods, outputs=names, height=2.0)
    assert max(abs(abs(small.of(PITCH)) / abs(response.of(PITCH)) - 1)) > 0.2
    for k, period in enumerate(periods):
        start = started(point, ordered(waves, point, response.states[0, k]), 1.0)
        found, means = harmonics(tmp_path, period, 2.0, start, names)
        for j, name in enumerate(names[:3]):
            if response.third[0, k, j] < 0.05:
                ratio = response.of(name)[k] / found[name]
                assert abs(ratio - 1.0) < 0.03, (name, period)
        power = response.mean("generator.power")[k]
        assert power == pytest.approx(means["generator.power"], rel=0.01)


@pytest.mark.verifies(
    "mean power of a take-off in an irregular sea, by statistical linearisation: 3 %",
    independent="simulation of an hour of the same waves, DOP853",
    tolerance="3 %; 2 % between linear and simulated deviations of heave",
)
def test_an_irregular_sea(buoy: tuple[InWaves, OperatingPoint]) -> None:
    waves, point = buoy
    sea = waves.jonswap(2.0, 7.5, 3.3, 0.0)
    assert sea.significant_height == pytest.approx(2.0, rel=1e-12)
    response = sea_response(waves, point, sea, outputs=[HEAVE, "generator.power"])
    for found in compared_in_time(waves, response):
        if (found.output, found.what) == ("generator.power", "mean"):
            assert abs(found.difference) < 0.03
            assert response.mean("generator.power") == pytest.approx(found.linearised, rel=0.1)
        if (found.output, found.what) == (HEAVE, "standard deviation"):
            assert abs(found.difference) < 0.02


class _Push:
    """Waves that push with 1 N/m, and have the elevation as an input."""

    inputs = ("elevation", "push")
    notes = ()
    highest = 100.0

    def per_amplitude(
        self, omega: Floats, directions: Floats, values: Mapping[str, float]
    ) -> Complex:
        del directions, values
        return np.ones((len(omega), 2), dtype=complex)

    def breaking_heights(self, omega: Floats) -> Floats:
        return np.full(len(omega), np.inf)

    def own_sea(self, values: Mapping[str, float]) -> Sea | None:
        del values
        return None

    def own_direction(self, values: Mapping[str, float]) -> float | None:
        del values
        return 0.0

    def jonswap(
        self, significant_height: float, peak_period: float, enhancement: float, direction: float
    ) -> Sea:
        del significant_height, peak_period, enhancement, direction
        raise AssertionError


def oscillator(*, drag: float = 0.0, cubic: float = 0.0) -> Program:
    """ẍ = −x − 0.02 ẋ − drag |ẋ| ẋ − cubic x³ + push."""
    r = Recorder("oscillator", "")
    r.input(Variable("elevation", "m", ""))
    push = r.input(Variable("push", "N", ""))
    x = r.state(Variable("x", "m", ""))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", push - x - 0.02 * v - drag * abs(v) * v - cubic * x**3)
    r.output(Variable("power", "W", ""), 0.02 * v * v)
    return r.program()


def test_drag_has_the_damping_of_lorentz() -> None:
    """At resonance 0.02 v + 8/(3π) c v² = F for the velocity's amplitude v (ω = 1)."""
    program, c = oscillator(drag=0.5), 0.5
    waves = InWaves(program, {"": _Push()})
    response = wave_response(
        waves, equilibrium(program), periods=[2 * np.pi], outputs=["x", "power"], height=2.0
    )
    lorentz = 8.0 / (3.0 * np.pi) * c
    exact = (-0.02 + np.sqrt(0.02**2 + 4 * lorentz)) / (2 * lorentz)
    # his force has one harmonic; the third, of 1/5, changes the motion by less than 1 %
    assert abs(response.of("x")[0]) == pytest.approx(exact, rel=0.01)
    assert np.degrees(np.angle(response.of("x")[0])) == pytest.approx(90.0, abs=2.0)
    assert response.mean("power")[0] == pytest.approx(0.01 * exact**2, rel=0.02)
    for found in compared_in_time(waves, response):
        if found.output == "x" and found.what == "amplitude":
            assert abs(found.difference) < 1e-3


def test_the_third_harmonic_of_a_cubic_spring_is_told() -> None:
    """Duffing's oscillator below resonance: x₃ = −b x₁³/4/(1 − 9ω²) to first order of b."""
    b, omega = 1e-4, 0.5
    program = oscillator(cubic=b)
    waves = InWaves(program, {"": _Push()})
    response = wave_response(
        waves, equilibrium(program), periods=[2 * np.pi / omega], outputs=["x"], height=2.0
    )
    x = abs(response.of("x")[0])
    exact = b * x**2 / 4.0 / abs(1.0 - 9.0 * omega**2)
    assert response.third[0, 0, 0] == pytest.approx(exact, rel=0.01)


def test_drag_in_a_sea_has_the_damping_of_gauss() -> None:
    """A narrow sea at resonance: √(8/π) c σ_v in place of drag, whose response gives σ_v."""
    program, c = oscillator(drag=0.5), 0.5
    waves = InWaves(program, {"": _Push()})
    omega = np.linspace(0.5, 1.5, 401)
    sea = Sea(omega, np.full(401, 0.05), np.zeros(401))
    response = sea_response(waves, equilibrium(program), sea, outputs=["v", "x", "power"])

    def deviation(damping: float) -> float:
        transfer = omega / np.abs(1.0 - omega**2 - 1j * omega * damping)
        return float(np.sqrt(0.5 * np.sum((0.05 * transfer) ** 2)))

    sigma = 1.0
    for _ in range(200):
        sigma = deviation(0.02 + np.sqrt(8.0 / np.pi) * c * sigma)
    assert response.deviation("v") == pytest.approx(sigma, rel=1e-3)
    assert response.mean("power") == pytest.approx(0.02 * response.deviation("v") ** 2, rel=1e-9)
    # of a Gaussian v the deviation of c v² is √2 c σ²
    exact = np.sqrt(2.0) * 0.02 * response.deviation("v") ** 2
    assert response.deviation("power") == pytest.approx(exact, rel=0.02)
    density = (
        1.0 / np.abs(1.0 - omega**2 - 1j * omega * (0.02 + np.sqrt(8 / np.pi) * c * sigma)) ** 2
    )
    period = 2 * np.pi * np.sqrt(density.sum() / (density @ omega**2))
    assert response.zero_crossing_period("x") == pytest.approx(period, rel=1e-3)


@pytest.mark.verifies(
    "undamped heave resonance of the sphere of IEA OES Task 10, K = ω²(m + A(ω))",
    analytic="exact linear potential flow, 1.43946 rad/s",
    tolerance="0.05 %",
)
def test_resonance_of_the_sphere() -> None:
    """A(ω) by WAMIT, as the fitted memory and A∞ give it back."""
    table = sphere()
    linear = linearize(hydrodynamics_program(table), inputs=["ball.vz"], outputs=["ball.force_z"])
    stiffness, mass = table.hydrostatic_stiffness[1, 1], 261.8e3

    def rest(omega: float) -> float:
        response = frequency_response(linear, omega).of("ball.force_z", "ball.vz")[0]
        added = table.added_mass_inf[1, 1] - response.imag / omega
        return float(stiffness - omega**2 * (mass + added))

    assert brentq(rest, 1.2, 1.7) == pytest.approx(1.43946, rel=5e-4)


@pytest.mark.parametrize(
    "omega", [np.linspace(0.98, 1.02, 41), np.linspace(0.9, 1.1, 41), np.array([1.0])]
)
def test_drag_that_limits_a_resonance_settles(omega: np.ndarray) -> None:
    """Of seas so narrow that more motion makes less in the next step of the iteration."""
    program = oscillator(drag=0.5)
    amplitude = np.full(len(omega), 1.0 / np.sqrt(len(omega)))
    sea = Sea(omega, amplitude, np.zeros(len(omega)))
    waves = InWaves(program, {"": _Push()})
    found = sea_response(waves, equilibrium(program), sea, outputs=["v"]).deviation("v")
    damping = 0.02 + np.sqrt(8.0 / np.pi) * 0.5 * found
    transfer = omega / np.abs(1.0 - omega**2 - 1j * omega * damping)
    exact = np.sqrt(0.5 * np.sum((amplitude * transfer) ** 2))
    assert found == pytest.approx(exact, rel=2e-3)


def test_large_numbers_beside_it_change_nothing() -> None:
    """Of a filtered force of 1e9 N beside a motion of metres."""
    found = []
    for size in (1.0, 1e9):
        r = Recorder("filtered", "")
        r.input(Variable("elevation", "m", ""))
        push = r.input(Variable("push", "N", ""))
        x = r.state(Variable("x", "m", ""))
        v = r.state(Variable("v", "m/s", "", derivative_of="x"))
        f = r.state(Variable("f", "N", ""))
        r.rate("x", v)
        r.rate("v", push - x - 0.02 * v - 0.5 * abs(v) * v)
        r.rate("f", size * push - f)
        program = r.program()
        sea = Sea(np.linspace(0.5, 1.5, 101), np.full(101, 0.1), np.zeros(101))
        waves = InWaves(program, {"": _Push()})
        response = sea_response(waves, equilibrium(program), sea, outputs=["x", "f"])
        found.append(response.deviation("x"))
    assert found[1] == pytest.approx(found[0], rel=1e-5)


def test_a_steady_force_counts_in_all_waves(buoy: tuple[InWaves, OperatingPoint]) -> None:
    waves, rest = buoy
    force = "hydro.float.wave_force_x"
    point = equilibrium(waves.program, at={force: 5e3})
    small = wave_response(waves, point, periods=[8.0], outputs=[SURGE]).mean(SURGE)[0]
    low = wave_response(waves, point, periods=[8.0], outputs=[SURGE], height=1e-3)
    assert small > rest[SURGE] + 0.1
    assert low.mean(SURGE)[0] == pytest.approx(small, rel=1e-3)
    sea = waves.jonswap(1e-3, 8.0, 3.3, 0.0)
    assert sea_response(waves, point, sea, outputs=[SURGE]).mean(SURGE) == pytest.approx(
        small, rel=1e-3
    )


def test_a_motion_that_drag_alone_damps() -> None:
    """At the undamped natural period: drag is all that holds it."""
    r = Recorder("undamped", "")
    r.input(Variable("elevation", "m", ""))
    push = r.input(Variable("push", "N", ""))
    x = r.state(Variable("x", "m", ""))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", push - x - 0.5 * abs(v) * v)
    program = r.program()
    waves = InWaves(program, {"": _Push()})
    response = wave_response(
        waves, equilibrium(program), periods=[2 * np.pi], outputs=["x"], height=2.0
    )
    lorentz = np.sqrt(1.0 / (8.0 / (3.0 * np.pi) * 0.5))
    assert abs(response.of("x")[0]) == pytest.approx(lorentz, rel=0.01)
    assert not wave_response(waves, equilibrium(program), periods=[5.0], outputs=["x"]).third.any()


def test_motions_beyond_their_limits_are_told(buoy: tuple[InWaves, OperatingPoint]) -> None:
    waves, point = buoy
    low, high = (
        wave_response(waves, point, periods=[5.5], outputs=[HEAVE], height=h).notes
        for h in (0.2, 6.0)
    )
    assert not any("limits" in note for note in low)
    assert any("hydro.float.pitch: an amplitude of" in note for note in high)
    sea = waves.jonswap(6.0, 6.0, 3.3, 0.0)
    notes = sea_response(waves, point, sea, outputs=[HEAVE]).notes
    assert any("hydro.float.pitch: a significant amplitude of" in note for note in notes)
