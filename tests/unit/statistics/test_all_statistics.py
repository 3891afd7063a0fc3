"""Properties of all statistics: honest answers for odd records, units, many runs at once."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from m4e_fmi.statistics import STATISTICS, Statistic, peaks
from m4e_fmi.units import parse_unit

EVERY = list(STATISTICS.values())
GIVEN = {"percent": 90.0, "level": 0.5, "duration": 3600.0, "probability": 0.9, "exponent": 3.0}
TIME = np.linspace(0.0, 600.0, 2401)
WAVE = np.sin(0.8 * TIME) + 0.7 * np.sin(0.93 * TIME + 1.0) + 0.5 * np.sin(1.21 * TIME)
UNEVEN = np.cumsum(np.random.default_rng(3).uniform(0.05, 0.6, 900))
ODD = {
    "one row": (TIME[:1], WAVE[:1]),
    "two rows": (TIME[:2], WAVE[:2]),
    "five rows": (TIME[:5], WAVE[:5]),
    "all at one time": (np.zeros(4), WAVE[:4]),
    "constant": (TIME, np.full(len(TIME), 1e6)),
    "constant but rounding": (TIME, 1e6 * (1.0 + 2e-16 * np.sign(WAVE))),
    "zero": (TIME, np.zeros(len(TIME))),
    "nan": (TIME, np.where(TIME == 300.0, np.nan, WAVE)),
    "infinite": (TIME, np.where(TIME == 300.0, np.inf, WAVE)),
    "ramp": (TIME, TIME),
    "uneven": (UNEVEN, np.sin(UNEVEN)),
    "a jump": (np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 0.0, 1.0, 1.0])),
    "crests at the mean": (
        np.arange(202.0),
        np.r_[np.tile([-1.0, 0.0], 50), 100, 0, np.tile([-1.0, 0.0], 50)],
    ),
    "bits": (TIME, np.sign(np.sin(7.0 * TIME**1.5))),
    "one step": (TIME, (TIME > 300.0).astype(float)),
    "a spike": (TIME, np.where(TIME == 300.0, 1.0, 0.0)),
    "tiny": (TIME, 1e-55 * WAVE),
    "large": (TIME, 1e55 * WAVE),
    "nothing": (TIME, 1e-200 * WAVE),
    "huge": (TIME, 1e200 * WAVE),
}


def given(statistic: Statistic) -> dict[str, float]:
    return {name: value for name, value in GIVEN.items() if name in statistic.parameters}


@pytest.mark.parametrize("statistic", EVERY, ids=lambda s: s.name)
def test_odd_records_give_a_number_or_a_reason(statistic: Statistic) -> None:
    for name, (time, values) in ODD.items():
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = statistic.explained(time, values, **given(statistic))
        assert np.isfinite(found.values[0]) != bool(found.reasons[0]), (name, found.values)
        assert name not in ("nan", "infinite") or found.reasons[0], name


@pytest.mark.parametrize("statistic", EVERY, ids=lambda s: s.name)
def test_each_run_is_by_itself_and_in_its_unit(statistic: Statistic) -> None:
    """Of thrice the values, a statistic in their unit is thrice as large, in its square 9 times."""
    options = given(statistic)
    options |= {"level": 0.0} if "level" in options else {}
    single = statistic.compute(TIME, WAVE, **options)
    both = statistic.compute(TIME, np.stack([WAVE, 3.0 * WAVE]), **options)
    assert both[0] == single[0]
    unit = parse_unit(statistic.unit("m"))
    metres = unit.exponents[1]
    assert both[1] == pytest.approx(3.0**metres * both[0], rel=1e-6)
    assert statistic.unit("1") == statistic.unit("") or statistic.unit("m") == "m"


@pytest.mark.parametrize("unit", ["m", "N.m", "m/s2", "kg/(m.s)", "deg", "%", "1"])
def test_units_can_be_read(unit: str) -> None:
    given = parse_unit(unit)
    for order in (0, 1, 2):
        found = parse_unit(STATISTICS[f"spectral_moment_{order}"].unit(unit))
        wanted = [2 * e for e in given.exponents]
        wanted[2] -= order
        wanted[7] += order
        assert list(found.exponents) == wanted
        assert found.factor == pytest.approx(given.factor**2)


def test_a_level_that_is_touched_is_risen_above_from_there() -> None:
    """A row at the level itself: not yet above it, and counted once."""
    time = np.arange(5.0)
    (found,) = STATISTICS["number_above"].compute(time, [0.0, 1.0, 2.0, 1.0, 2.0], level=1.0)
    assert found == 2.0


def test_a_row_at_the_level_begins_a_cycle() -> None:
    """And does not end the one before it: a record that only touches its level goes on."""
    record = [-1.0, 1.0, 0.0, 1.0, -1.0, 0.0, 1.0, -1.0]
    found = peaks(np.arange(8.0), record, level=0.0)
    assert found.crossings.tolist() == [0.5, 5.0]
    assert found.crests.tolist() == [1.0]
