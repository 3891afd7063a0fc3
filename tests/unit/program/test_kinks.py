"""Times of kinks and jumps that a program has for time and parameters alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_fmi.program import Recorder, Scalar, Variable, kinks, maximum, minimum, sign, sin
from m4e_fmi.program.kinks import BESIDE_JUMP
from m4e_fmi.simulate import simulate


def rate(value: Scalar, r: Recorder) -> list[float]:
    """Kinks up to 10 s of a program with this rate."""
    r.state(Variable("x", "m", "what moves"))
    r.rate("x", value)
    return kinks(r.program(), 10.0)


def test_jumps_are_two_times() -> None:
    r = Recorder("switch", "")
    found = rate(sign(r.time - 4.0) + abs(r.time - 6.0), r)
    assert found == pytest.approx([4.0 - BESIDE_JUMP, 4.0 + BESIDE_JUMP, 6.0], abs=1e-14)


def test_corners_of_corners_and_of_curves() -> None:
    r = Recorder("nested", "")
    # | |t − 5| − 2 | has corners at 3, 5 and 7; max(sin t, 1/2) in 0 to π only at π/6 and 5π/6
    inner = abs(abs(r.time - 5.0) - 2.0)
    assert rate(inner, r) == pytest.approx([3.0, 5.0, 7.0], abs=1e-14)
    r = Recorder("curve", "")
    half = minimum(r.time, math.pi / 2)
    assert rate(maximum(sin(half), 0.5), r) == pytest.approx([math.pi / 6, math.pi / 2], abs=1e-12)


def test_corners_of_what_moves_or_comes_in_are_none() -> None:
    r = Recorder("events", "")
    u = r.input(Variable("u", "m", ""))
    x = r.state(Variable("x", "m", ""))
    r.rate("x", abs(u - r.time) + maximum(x, r.time))
    assert kinks(r.program(), 10.0) == []


def test_a_thousand_jumps_are_met() -> None:
    """The integral of a square wave that is held between 1,000 times, to the tolerance."""
    r = Recorder("square wave", "")
    times = [0.01 * k for k in range(1, 1000)]
    level: Scalar | float = 0.0
    for k, time in enumerate(times):
        level = level + (-1) ** k * 0.5 * (sign(r.time - time) + 1.0)
    x = r.state(Variable("x", "m", ""))
    r.rate("x", level - 0.1 * x)
    result = simulate(r.program(), stop_time=10.0, output_interval=10.0, tolerance=1e-10)
    starts, ends = np.array(times[0::2]), np.array([*times[1::2], 10.0])
    exact = float(np.sum(np.exp(-0.1 * (10.0 - ends)) - np.exp(-0.1 * (10.0 - starts)))) / 0.1
    assert result["x"][-1] == pytest.approx(exact, abs=1e-9)
