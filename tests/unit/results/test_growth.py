"""Growth without bound, told from all other ways to become large."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.results.growth import growth

T = np.linspace(0.0, 10.0, 1001)
DOUBLING = np.array([2.0**k - 1 for k in range(1, 20)])
NOISE = 1e-12 * np.random.default_rng(1).normal(size=T.size)


def logistic(rate: float) -> np.ndarray:
    """From 1e-9 along an exponential to 1, then an oscillation between -1 and 1."""
    size = 1 / (1 + 1e9 * np.exp(-rate * T))
    return size * np.cos(40 * T)


BOUNDED = {
    "ramp": T,
    "free fall": -9.81 / 2 * T**2,
    "launch after rest": np.where(T > 5, 50 * np.clip(T - 5, 0, None) ** 2, 0.0) + NOISE,
    "powers": 1e3 * T**6,
    "ramp at doubled times": None,
    "jump": np.where(T > 7, 1e6, 1e-3) + NOISE,
    "contact": 1e9 * np.clip(T - 9.9, 0, None) ** 1.5 + NOISE,
    "start-up and limit cycle": logistic(5.0),
    "fast start-up and limit cycle": logistic(50.0),
    "decay": 1e6 * np.exp(-3 * T),
    "oscillation": 1e8 * np.sin(3 * T),
    "beat": np.sin(0.15 * T) * np.sin(30 * T),
    "noise": NOISE,
    "zero": 0 * T,
    "pulse": 1e6 * np.exp(-(((T - 5) / 0.3) ** 2)),
}


@pytest.mark.parametrize("name", BOUNDED)
def test_what_is_no_growth_without_bound(name: str) -> None:
    values = BOUNDED[name]
    if values is None:
        assert growth(name, DOUBLING, DOUBLING**2, decades=4) is None
    else:
        for end in (len(T), 960, 800):  # also where the record ends earlier
            assert growth(name, T[:end], values[:end], decades=4) is None


@pytest.mark.parametrize("rate", [2.0, 5.0, 50.0])
@pytest.mark.parametrize("shape", ["plain", "oscillating", "after rest"])
def test_exponential_growth(rate: float, shape: str) -> None:
    since = 8.0 if shape == "after rest" else 0.0
    if since and rate < 10:
        rate *= 10
    values = np.exp(rate * np.clip(T - since, 0, None))
    values *= np.cos(25 * T) if shape == "oscillating" else 1.0
    found = growth("x", T, values, decades=6)
    assert found is not None
    assert found.tenfold == pytest.approx(np.log(10) / rate, rel=0.1)
    # half a decade is the resolution, and a swing of the oscillation
    assert found.since == pytest.approx(since, abs=0.5 * np.log(10) / rate + np.pi / 25)
    assert found.until == pytest.approx(10.0)


def test_growth_from_sample_to_sample() -> None:
    exact = 10.0 ** DOUBLING[:6]
    found = growth("x", DOUBLING[:6], exact, decades=6)
    assert found is not None
    assert found.tenfold == pytest.approx(1.0)
    # each step takes the third power of the one before, up to the last finite number
    cubes = np.array([1.0, 1.1, *(10.0 ** (3.0**k) for k in range(6)), np.inf, np.nan])
    found = growth("x", np.arange(10.0), cubes, decades=6)
    assert found is not None
    assert (found.low, found.high) == (1.1, 1e243)
