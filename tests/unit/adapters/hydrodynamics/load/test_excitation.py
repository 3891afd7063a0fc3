"""Excitation whose frequency or direction is a parameter, and of several systems at once."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.programs import Evaluated

from m4e_adapters.hydrodynamics import Coefficients, hydrodynamics_program
from m4e_adapters.hydrodynamics.config import ComponentWaves, Jonswap, Loads, Regular, WaveSection
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_fmi.program import Program

OMEGA = np.linspace(0.25, 2.5, 19)


def coefficients(dimensions: int, depth: float) -> Coefficients:
    """A body beside the origin with smooth excitation, in space of five harmonics."""
    n = 3 if dimensions == 2 else 6
    rng = np.random.default_rng(8)
    scale = np.exp(-OMEGA)[:, None]
    phase = np.exp(1j * np.outer(OMEGA, rng.uniform(0.2, 1.5, n)))
    harmonics = np.zeros((0, 0, 0), dtype=complex)
    if dimensions == 3:
        weights = rng.uniform(0.1, 1.0, (1, 5, n)) * np.exp(1j * rng.uniform(0, 6, (1, 5, n)))
        harmonics = 1e5 * weights * (scale * phase)[:, None, :]
    heave = n // 3
    stiffness = np.zeros((n, n))
    stiffness[heave, heave] = 5e5
    added = np.diag(np.full(n, 1e4))
    return Coefficients(
        bodies=("b",),
        centers=np.array([[7.0, -1.0] if dimensions == 2 else [7.0, -3.0, -1.0]]),
        omega=OMEGA,
        added_mass=np.tile(added, (len(OMEGA), 1, 1)),
        radiation_damping=np.zeros((len(OMEGA), n, n)),
        added_mass_inf=added,
        excitation=1e5 * scale * phase,
        hydrostatic_stiffness=stiffness,
        buoyancy=1e6 * np.eye(n)[heave],
        depth=depth,
        harmonics=harmonics,
    )


def forces(program: Program, time: float, **given: float) -> dict[str, float]:
    """Excitation and elevation at a time, with parameters that are `given` (__ for a dot)."""
    values = {key.replace("__", "."): value for key, value in given.items()}
    found = Evaluated(program).outputs(values, t=time)
    return {n: v for n, v in found.items() if "excitation" in n or n == "wave.elevation"}


def sea(each: list[dict[str, float]], direction: float = 0.0) -> WaveSection:
    given = {"spectrum": "components", "components": each, "direction": direction, "ramp_time": 0}
    return ComponentWaves.model_validate(given)


def regular(period: float, **keys: float) -> Regular:
    given = {"spectrum": "regular", "height": 2.0, "phase": 0.4, "period": period, "ramp_time": 0}
    return Regular.model_validate({**given, **keys})


@pytest.mark.verifies(
    "excitation of a regular wave whose period is a parameter",
    analytic="spline of the same table, by SciPy",
    tolerance="1e-10",
)
@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("depth", [15.0, math.inf])
def test_a_period_that_is_a_parameter_gives_the_forces_of_one_that_is_configured(
    dimensions: int, depth: float
) -> None:
    """At knots, between them, at both ends, and for waves longer than those of the table."""
    c = coefficients(dimensions, depth)
    program = hydrodynamics_program(c, waves=regular(9.0))
    periods = [*(2 * math.pi / OMEGA[[0, 3, 18]]), 2.6, 3.7, 8.123, 24.9, 40.0]
    for period in periods:
        for time in (0.0, 31.7):
            found = forces(program, time, wave__period=period)
            one = {"amplitude": 1.0, "period": period, "phase": 0.4}  # its frequency is a number
            expected = forces(hydrodynamics_program(c, waves=sea([one])), time)
            largest = max(abs(value) for value in expected.values())
            assert found.pop("wave.elevation") == pytest.approx(
                expected.pop("wave.elevation"), abs=1e-10
            )
            assert found == pytest.approx(expected, abs=1e-10 * largest), period


@pytest.mark.verifies(
    "excitation of a long-crested sea in space",
    analytic="sum of the table's splines, by SciPy",
    tolerance="1e-12",
)
@pytest.mark.parametrize("depth", [15.0, math.inf])
def test_a_long_crested_sea_pushes_as_the_splines_of_its_components(depth: float) -> None:
    """At a knot, between knots, below and above the table; waves from the side, hulls turned."""
    c = coefficients(3, depth)
    omega = np.array([0.1, OMEGA[4], 0.9, 1.111, OMEGA[-1], 2.8, 4.0])
    amplitude = np.where(omega > OMEGA[-1], 0.1, 1.0)  # few are shorter than those of the table
    pairs = zip(omega.tolist(), amplitude.tolist(), strict=True)
    each = [{"amplitude": a, "omega": w, "phase": 0.3 * w} for w, a in pairs]
    found = forces(hydrodynamics_program(c, waves=sea(each, 50.0), heading=Heading(10.0)), 12.0)
    table = np.einsum(
        "kjn,j->kn", c.harmonics_at(omega), np.exp(1j * np.radians(40) * np.arange(-2, 3))
    )
    number = wavenumber(omega, depth=depth, gravity=c.gravity)
    x, y, _ = c.centers[0]  # about which a single body turns
    beta = np.radians(50)
    way = np.exp(1j * number * (x * np.cos(beta) + y * np.sin(beta)))
    waved = (table * way[:, None]) * (amplitude * np.exp(-1j * omega * 12.3))[:, None]
    expected = waved.sum(axis=0).real
    names = [f"b.excitation_{k}" for k in ("force_z", "moment_z")]
    for name, value in zip(names, expected[[2, 5]], strict=True):
        assert found[name] == pytest.approx(value, abs=1e-12 * np.abs(table).sum())


def test_the_period_has_the_limits_of_the_table() -> None:
    program = hydrodynamics_program(coefficients(2, math.inf), waves=regular(9.0))
    (period,) = (v for v in program.parameters if v.name == "wave.period")
    assert (period.minimum, period.maximum) == pytest.approx((2 * math.pi / 2.5, 8 * math.pi))


def test_the_direction_of_a_short_crested_sea_turns_all_its_components() -> None:
    """A sea configured at 50 deg, and one at 20 deg turned by 30 deg, by the parameter."""
    c = coefficients(3, 15.0)
    text = {
        "spectrum": "jonswap", "significant_height": 2, "peak_period": 7, "components": 20,
        "spreading": {"exponent": 6}, "ramp_time": 0,
    }  # fmt: skip
    there = hydrodynamics_program(c, waves=Jonswap.model_validate({**text, "direction": 50}))
    here = hydrodynamics_program(c, waves=Jonswap.model_validate({**text, "direction": 20}))
    expected, found = forces(there, 12.0), forces(here, 12.0, wave__direction=math.radians(50))
    assert found == pytest.approx(expected, rel=1e-9)
    # beside a long-crested one of the same components
    plain = Jonswap.model_validate({**text, "direction": 50, "spreading": None})
    assert forces(hydrodynamics_program(c, waves=plain), 12.0) != pytest.approx(expected, rel=0.05)


EACH = [
    {"amplitude": 1.0, "period": 9.0, "phase": 0.3, "direction": 12.0},
    {"amplitude": 0.5, "period": 5.0, "phase": 2.0, "direction": -70.0},
]
WIND = Jonswap(spectrum="jonswap", significant_height=1, peak_period=8, components=15, seed=3)


@pytest.mark.parametrize(
    ("dimensions", "all_waves", "apart"),
    [
        (3, sea(EACH, 30.0), [sea([one], one["direction"]) for one in EACH]),
        (2, (regular(12.0), WIND), [regular(12.0), WIND]),
        (3, (regular(12.0), WIND), [regular(12.0), WIND]),
    ],
    ids=["components in their own directions", "systems in the plane", "systems in space"],
)
def test_forces_of_several_waves_add_up(dimensions: int, all_waves: Any, apart: list) -> None:
    c = coefficients(dimensions, 15.0)
    both = forces(hydrodynamics_program(c, waves=all_waves), 7.0)
    parts = [forces(hydrodynamics_program(c, waves=one), 7.0) for one in apart]
    for name, value in both.items():
        assert value == pytest.approx(sum(part[name] for part in parts), rel=1e-10)


@pytest.mark.parametrize("depth", [15.0, math.inf])
def test_excitation_at_the_displaced_place_has_the_phase_of_the_wave_there(depth: float) -> None:
    """A body that is d further along the wave feels it k d later; so it does in space."""
    period, d = 6.0, 11.0
    along, across = d * math.cos(math.radians(35.0)), d * math.sin(math.radians(35.0))
    k = float(wavenumber(np.array(2 * math.pi / period), depth=depth, gravity=9.81))
    displaced = Loads(excitation_at="displaced")
    for dimensions, direction, heading, moved in (
        (2, 180.0, None, {"b__x": 7.0 - d}),
        (3, 35.0, Heading(20.0), {"b__x": 7.0 + along, "b__y": -3.0 + across}),
    ):
        known = coefficients(dimensions, depth)
        if dimensions == 2:
            known = replace(known, wave_direction=180.0)
        waves = {
            phase: regular(period, direction=direction, phase=phase) for phase in (0.3, 0.3 - k * d)
        }
        here, there = (
            hydrodynamics_program(known, waves=wave, heading=heading, loads=loads)
            for wave, loads in zip(waves.values(), (displaced, Loads()), strict=True)
        )
        found, expected = forces(here, 2.7, **moved), forces(there, 2.7)
        del found["wave.elevation"], expected["wave.elevation"]
        assert len(found) >= 3
        assert found == pytest.approx(expected, abs=1e-7 * 1e5), dimensions
        still = hydrodynamics_program(known, waves=waves[0.3], heading=heading)
        assert forces(here, 2.7) == pytest.approx(forces(still, 2.7), abs=1e-6)
