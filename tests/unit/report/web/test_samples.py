"""Samples as a page has them: every one, exactly or rounded to Float32."""

from __future__ import annotations

import base64
import gzip
from typing import Any

import numpy as np
import pytest

from m4e_fmi.report.web.samples import MOST_EXACT, Curve, Samples, packed_samples

TIME = np.linspace(0.0, 1.0, 11)


def curve(values: np.ndarray, name: str = "a.x", **more: Any) -> Curve:
    return Curve(name, "a", "x", "m", "made", values, **more)


def numbers(samples: Samples, variable: dict[str, Any], count: int) -> np.ndarray:
    """What samples.js makes of a variable, written a second time."""
    if "constant" in variable:
        return np.full(count, variable["constant"])
    data = gzip.decompress(base64.b64decode(samples.blocks[variable["block"]]))
    kind = np.dtype(f"<{variable['kind']}")
    apart = np.frombuffer(data, np.uint8).reshape(kind.itemsize, -1)
    return np.frombuffer(apart.T.tobytes(), kind)


def first(samples: Samples) -> Any:
    variables = samples.data["variables"]
    assert isinstance(variables, list)
    return variables[0]


def test_few_samples_are_exact() -> None:
    values = np.sin(TIME) * np.pi
    samples = packed_samples(TIME, [curve(values)])
    assert samples.exact
    assert np.array_equal(numbers(samples, first(samples), 11), values)
    assert np.array_equal(numbers(samples, samples.data["time"], 11), TIME)  # type: ignore[arg-type]


def test_many_are_rounded_to_seven_digits_but_times_are_not() -> None:
    count = MOST_EXACT // 8 + 1
    time = np.linspace(0.0, 9.9, count)
    values = np.random.default_rng(1).normal(size=count)
    samples = packed_samples(time, [curve(values)])
    assert not samples.exact
    found = numbers(samples, first(samples), count)
    assert found.dtype == np.float32
    assert np.abs(found / values - 1).max() <= 2.0**-24
    assert np.array_equal(numbers(samples, samples.data["time"], count), time)  # type: ignore[arg-type]


@pytest.mark.parametrize("odd", [1e39, 1e-40])
def test_numbers_that_float32_does_not_have_stay(odd: float) -> None:
    count = MOST_EXACT // 8 + 1
    values = np.linspace(1.0, 2.0, count)
    values[7] = odd
    samples = packed_samples(np.arange(count, dtype=float), [curve(values)])
    assert np.array_equal(numbers(samples, first(samples), count), values)


def test_whole_numbers_truth_values_and_numbers_that_are_not_finite() -> None:
    whole = np.arange(11) + 2**24
    truth = np.arange(11) % 3 == 0
    broken = np.array([1.0, np.nan, np.inf, -np.inf, *range(7)])
    samples = packed_samples(TIME, [curve(one, steps=True) for one in (whole, truth, broken)])
    variables = samples.data["variables"]
    assert isinstance(variables, list)
    for one, expected in zip(variables, (whole, truth, broken), strict=True):
        assert np.array_equal(numbers(samples, one, 11), expected.astype(float), equal_nan=True)
    assert (variables[2]["low"], variables[2]["high"]) == (0.0, 6.0)


def test_a_constant_is_one_number() -> None:
    samples = packed_samples(TIME, [curve(np.full(11, 0.1)), curve(np.full(11, np.nan))])
    assert first(samples)["constant"] == 0.1
    variables = samples.data["variables"]
    assert isinstance(variables, list)
    assert "block" in variables[1]  # JSON has no number for it
