"""Samples as a page has them, exactly or rounded to Float32."""

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


def test_few_samples_are_exact() -> None:
    """Whole numbers, truth values, numbers that are not finite; a constant is one number."""
    curves = [
        np.sin(TIME) * np.pi,
        np.arange(11) + 2**24,
        np.arange(11) % 3 == 0,
        np.array([1.0, np.nan, np.inf, -np.inf, *range(7)]),
        np.full(11, np.nan),  # JSON has no number for it
        np.full(11, 0.1),
    ]
    samples = packed_samples(TIME, [curve(one, steps=True) for one in curves])
    variables: Any = samples.data["variables"]
    assert samples.exact
    assert np.array_equal(numbers(samples, samples.data["time"], 11), TIME)  # pyrefly: ignore[bad-argument-type]
    for one, expected in zip(variables, curves, strict=True):
        assert np.array_equal(numbers(samples, one, 11), expected.astype(float), equal_nan=True)
    assert ["constant" in one for one in variables] == [False] * 5 + [True]
    assert (variables[3]["low"], variables[3]["high"]) == (0.0, 6.0)


@pytest.mark.parametrize("odd", [None, 1e39, 1e-40])
def test_many_are_rounded_to_seven_digits_but_times_are_not(odd: float | None) -> None:
    """And no curve with a number that Float32 does not have."""
    count = MOST_EXACT // 8 + 1
    time = np.linspace(0.0, 9.9, count)
    values = np.random.default_rng(1).normal(size=count)
    values[7] = values[7] if odd is None else odd
    samples = packed_samples(time, [curve(values)])
    (variable,) = samples.data["variables"]  # pyrefly: ignore[not-iterable]
    assert not samples.exact
    found = numbers(samples, variable, count)
    assert (found.dtype == np.float32) == (odd is None)
    assert np.abs(found / values - 1).max() <= (2.0**-24 if odd is None else 0.0)
    assert np.array_equal(numbers(samples, samples.data["time"], count), time)  # pyrefly: ignore[bad-argument-type]
