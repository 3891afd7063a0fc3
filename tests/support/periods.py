"""Periods of motions in samples, and those of the paper's flexible pendulum."""

from __future__ import annotations

import numpy as np
from scipy.signal import find_peaks

SWAY, SLOW_HEAVE, FAST_HEAVE = 20.1367, 10.0683, 0.62988  # s, tables 11 and 12 in truth


def crossing_period(times: np.ndarray, values: np.ndarray) -> float:
    """Mean time between upward crossings of zero, each found on the line between two samples."""
    k = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    found = times[k] - values[k] * (times[k + 1] - times[k]) / (values[k + 1] - values[k])
    return (found[-1] - found[0]) / (len(found) - 1)


def vertex(times: np.ndarray, values: np.ndarray, k: int) -> float:
    """Time of the vertex of the parabola through three samples."""
    before, here, after = values[k - 1 : k + 2]
    return times[k] + (times[1] - times[0]) * (before - after) / (before - 2 * here + after) / 2


def pendulum_periods(times: np.ndarray, x: np.ndarray, z: np.ndarray) -> tuple[float, float, float]:
    """Those of sway, slow heave and fast heave [s] of a mass on an elastic line."""
    step, length = times[1] - times[0], np.hypot(x, z)
    # the fast oscillation is the stretch of the line about its slow mean
    samples = round(FAST_HEAVE / step)
    fast = length - np.convolve(length, np.ones(samples) / samples, mode="same")
    inner = slice(samples, -samples)
    # the slow heave follows the swing: z without the stretch, highest where |x| is largest
    swing = z / length
    peaks, _ = find_peaks(swing, distance=round(SLOW_HEAVE / 2 / step))
    top = [vertex(times, swing, k) for k in peaks if 0 < k < len(times) - 1]
    slow = (top[-1] - top[0]) / (len(top) - 1)
    return crossing_period(times, x), slow, crossing_period(times[inner], fast[inner])
