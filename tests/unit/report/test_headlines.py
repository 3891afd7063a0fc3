"""Headline figures of results, beside what follows from them by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.reports import results_of

from m4e_fmi.report.animation.scene import Scene, Train, Water
from m4e_fmi.report.animation.scene_text import carried
from m4e_fmi.report.headlines import headlines

TIME = np.linspace(0.0, 100.0, 2001)
UNITS = {
    "pto.power": "W", "pto.extension": "m", "hydro.hull.surge": "m", "hydro.hull.sway": "m",
    "moor.line_1.fairlead_tension": "N", "moor.line_2.fairlead_tension": "N",
    "hydro.hull.pitch": "rad", "moor.line_1.safety_factor": "1", "moor.line_2.safety_factor": "1",
}  # fmt: skip


def train(height: float, period: float, depth: float, ramp: float = 0.0) -> Train:
    """A regular wave; its number by fixed-point iteration of the dispersion relation."""
    omega, number = 2.0 * np.pi / period, 0.1
    for _ in range(500):
        number = 0.5 * (number + omega**2 / (9.81 * np.tanh(number * depth)))
    columns = (np.array([x]) for x in (omega, number, height / 2.0, 0.0, 0.3))
    return Train(*columns, ramp=ramp)


@pytest.mark.parametrize(
    ("period", "depth"), [(6.0, np.inf), (6.0, 500.0), (9.0, 20.0), (14.0, 8.0)]
)
def test_the_energy_flux_of_a_regular_wave(period: float, depth: float) -> None:
    """ρ g H²/8 times dω/dk, by differences of the dispersion relation ω² = g k tanh kh."""
    wave = train(2.0, period, depth)
    water = Water(depth, (wave,), density=1000.0)
    near = wave.number[0] * np.array([1.0 - 1e-5, 1.0 + 1e-5])
    speed = np.diff(np.sqrt(9.81 * near * np.tanh(near * depth))) / np.diff(near)
    expected = 1000.0 * 9.81 * 2.0**2 / 8.0 * speed[0]
    assert water.energy_flux(TIME) == pytest.approx(expected, rel=1e-8)


def test_a_ramp_counts_in_the_energy_flux() -> None:
    """The mean square of ½(1 − cos π t/T) is 3/8."""
    water = Water(50.0, (train(2.0, 6.0, 50.0),), density=1000.0)
    grown = replace(water, trains=(train(2.0, 6.0, 50.0, ramp=40.0),))
    share = (0.375 * 40.0 + 60.0) / 100.0
    assert grown.energy_flux(TIME) == pytest.approx(share * water.energy_flux(TIME), rel=1e-5)


def test_a_moored_absorber() -> None:
    """Of two lines that with the larger tension, and the one that is nearer to its strength.

    The offset is that of surge and sway together.
    """
    omega = 2.0 * np.pi / 10.0
    values = {
        "pto.power": 2e3 * np.sin(omega * TIME) ** 2,
        "pto.extension": 0.5 * np.sin(omega * TIME),
        "hydro.hull.surge": 3.0 * np.sin(omega * TIME),
        "hydro.hull.sway": 4.0 * np.sin(omega * TIME),
        "hydro.hull.pitch": np.radians(6.0) * np.sin(omega * TIME),
        "moor.line_1.fairlead_tension": 5e4 + 1e4 * np.cos(omega * TIME),
        "moor.line_2.fairlead_tension": 5e4 - 2e4 * np.sin(omega * TIME),
        "moor.line_1.safety_factor": 3.0 - 1.5 * np.cos(omega * TIME),
        "moor.line_2.safety_factor": 3.0 + 0.5 * np.sin(omega * TIME),
    }
    water = Water(np.inf, (train(2.0, 10.0, np.inf),), density=1025.0)
    scene = Scene("s", "", planar=True, bodies=(), water=water)
    found = results_of(TIME, values, units=UNITS, attributes=carried(scene))
    assert list(map(str, headlines(found))) == [
        "mean power 1.000 kW (pto, 100.0 kJ in 100 s)",
        f"capture width {1e3 / (1025.0 * 9.81**2 * 2.0**2 * 10.0 / (32.0 * np.pi)):.3g} m "
        "(of 39.25 kW/m)",
        "largest line tension 70.00 kN (moor.line_2, at 7.5 s)",
        "smallest safety factor 1.5 (moor.line_1, at 0 s)",
        "largest offset 5.000 m (hydro.hull)",
        "largest tilt 6.000 deg (hydro.hull)",
        "stroke 1.000 m (pto)",
    ]


def test_a_mechanism() -> None:
    """A single component has no name; an angle is in degrees."""
    swing = np.radians(30.0) * np.sin(2.0 * np.pi / 4.0 * TIME)
    values = {"arm.joint.hinge.q": swing, "arm.energy.total": 2.0 - TIME / 100.0}
    units = {"arm.joint.hinge.q": "rad", "arm.energy.total": "J"}
    assert list(map(str, headlines(results_of(TIME, values, units=units)))) == [
        "energy 1.000 J (at the end; 2.000 J at the start)",
        "joint.hinge.q -30.00 to 30.00 deg",
        "mean period 4 s (joint.hinge.q)",
    ]


def test_anything_else_has_the_ranges_of_what_moves() -> None:
    values = {"a.level": TIME, "a.fixed": 0.0 * TIME, "b.force": 1e3 * TIME}
    units = {"a.level": "m", "a.fixed": "m", "b.force": "N"}
    assert list(map(str, headlines(results_of(TIME, values, units=units)))) == [
        "a.level 0.0 to 100.0 m",
        "b.force 0.0 to 100.0 kN",
    ]


def test_units_of_others_are_converted_and_a_sign_kept() -> None:
    """Powers outside of waves are no sum: nothing says that they are absorbed."""
    tilt = 12.0 * np.sin(TIME)
    values = {"a.power": 0.5 + 0.0 * TIME, "b.power": -3.0 + 0.0 * TIME, "hull.x.pitch": tilt}
    units = {"a.power": "kW", "b.power": "W", "hull.x.pitch": "deg"}
    assert list(map(str, headlines(results_of(TIME, values, units=units)))) == [
        "mean power 500.0 W (a, 50.00 kJ in 100 s)",
        "mean power -3.000 W (b, -300.0 J in 100 s)",
        "largest tilt 12.00 deg (hull.x)",
    ]


def test_what_is_not_finite_is_named() -> None:
    values = {"a.level": TIME, "a.lost": np.where(TIME > 50.0, np.nan, TIME)}
    assert list(map(str, headlines(results_of(TIME, values, units={"a.level": "m"})))) == [
        "level 0.0 to 100.0 m",
        "not finite lost",
    ]
