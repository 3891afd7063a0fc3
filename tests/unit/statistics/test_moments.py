"""Moments over time of records in equal and unequal steps, with gaps and without duration."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.statistics import STATISTICS

TIME = np.linspace(0.0, 20.0 * np.pi, 2001)
SINE = 1.0 + 2.0 * np.sin(TIME)
EXACT = {
    "mean": 1.0,
    "standard_deviation": np.sqrt(2.0),
    "rms": np.sqrt(3.0),
    "minimum": -1.0,
    "maximum": 3.0,
    "range": 4.0,
    "largest_magnitude": 3.0,
}


@pytest.mark.parametrize("name", EXACT)
def test_those_of_a_sine_over_whole_periods_are_exact(name: str) -> None:
    found = STATISTICS[name].compute(TIME, np.stack([SINE, 3.0 * SINE]))
    assert found == pytest.approx([EXACT[name], 3.0 * EXACT[name]], abs=1e-12)


def test_rows_count_as_long_as_they_last() -> None:
    """A value of 1 for 9 s, 3 for 1 s; ten times the rows in the short part."""
    time = np.array([0.0, 9.0, 9.0, *np.linspace(9.0, 10.0, 11)])
    values = np.array([1.0, 1.0, 3.0, *np.full(11, 3.0)])
    assert STATISTICS["mean"].compute(time, values) == pytest.approx([1.2])
    assert STATISTICS["standard_deviation"].compute(time, values) == pytest.approx([0.6])
    assert STATISTICS["time_above"].compute(time, values, level=2.0) == pytest.approx([0.1])
    assert STATISTICS["percentile"].compute(time, values, percent=50) == pytest.approx([1.0])


def test_impacts_are_counted_by_their_rises_above_a_level() -> None:
    """Contact at the beginning has not risen; one that stays is one; the level is not above it."""
    time = np.arange(9.0)
    force = np.array([5.0, 0.0, 2.0, 3.0, 0.0, 1.0, 0.0, 4.0, 4.0])
    assert STATISTICS["number_above"].compute(time, force, level=1.0) == pytest.approx([2.0])
    assert STATISTICS["number_above"].compute(time, -force, level=1.0) == pytest.approx([0.0])


def test_wrong_arrays_and_parameters_are_refused() -> None:
    for time, values in (([0, 1], [1, 2, 3]), ([], []), ([0, np.nan], [1, 2]), ([1, 0], [1, 2])):
        with pytest.raises(InputError):
            STATISTICS["mean"].compute(time, values)
    with pytest.raises(InputError, match="did you mean 'percent'"):
        STATISTICS["percentile"].compute(TIME, SINE, percnt=3)
    with pytest.raises(InputError, match="needs the parameter 'percent'"):
        STATISTICS["percentile"].compute(TIME, SINE)
    with pytest.raises(InputError, match="is 101, expected more than 0 and at most 100"):
        STATISTICS["percentile"].compute(TIME, SINE, percent=101)
    with pytest.raises(InputError, match="there is no statistic"):
        STATISTICS["maen"]
