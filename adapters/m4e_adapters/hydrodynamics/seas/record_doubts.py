"""Doubts about a measured record of waves: its origin, mean, ends, spikes, gaps and steps."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from m4e_adapters.hydrodynamics.seas.spectra import TAPERED, record_components
from m4e_adapters.hydrodynamics.seas.wave_files import Samples

LARGEST_MEAN = 0.05
"""Mean over standard deviation that is no doubt."""
NEAR, LARGEST_SHARE = 0.8, 1e-3
"""Part of the highest frequency of a record; share of the energy above it that is no doubt."""
SPIKE = 6.0
"""Standard deviations from the mean beyond which a row is doubted: a crest of 1.5 Hs."""


def record_doubts(name: str, record: Samples) -> Iterator[str]:
    """Lines on the record in the file `name`: what a run does with it, and what may be wrong."""
    values = record.elevation
    mean, deviation = float(values.mean()), float(values.std())
    if abs(mean) > LARGEST_MEAN * deviation:
        yield (
            f"the mean of {name}, {mean:.3g} m, is left out (its standard deviation is "
            f"{deviation:.3g} m): z = 0 is the still-water level"
        )
    yield from _of_rows(name, record)
    omega, amplitudes, _ = record_components(record)
    energy = 0.5 * float(amplitudes @ amplitudes)
    yield from _of_time(name, record, lost=1.0 - energy / deviation**2)
    near = omega > NEAR * math.pi / record.interval
    share = 0.5 * float(amplitudes[near] @ amplitudes[near]) / energy
    if share > LARGEST_SHARE:
        yield (
            f"{name} has {100 * share:.2g} % of its energy in waves of less than 2.5 rows: away "
            f"from its place about {100 * math.sqrt(share):.2g} % of the elevation is wrong: give "
            "shorter steps, or filter it"
        )


def _of_rows(name: str, record: Samples) -> Iterator[str]:
    """Lines on spikes, and on values that do not change for longer than a wave."""
    values = record.elevation - record.elevation.mean()
    deviations = np.abs(values) / values.std()
    far = int(np.sum(deviations > SPIKE))
    if far:
        row = int(deviations.argmax())
        rows = "a row" if far == 1 else f"{far} rows"
        yield (
            f"{name} has {rows} beyond {SPIKE:g} standard deviations, the farthest "
            f"{record.elevation[row]:.4g} m at t = {_time(record, row):g} s: correct spikes, and "
            "marks of missing values"
        )
    waves = int(np.sum((values[:-1] < 0.0) & (values[1:] >= 0.0)))
    ends = np.flatnonzero(np.diff(values)) + 1  # first rows of other values
    if waves and len(ends) > 1:
        longest = int(np.diff(ends).argmax())
        first, last = int(ends[longest]), int(ends[longest + 1]) - 1
        if (last - first) * waves > len(values):
            yield (
                f"the elevation of {name} is {record.elevation[first]:.4g} m from t = "
                f"{_time(record, first):g} to {_time(record, last):g} s, longer than a wave: if "
                "values are missing there, give the part before or after them"
            )


def _of_time(name: str, record: Samples, *, lost: float) -> Iterator[str]:
    """Lines on the record's origin of time, and on its ends; `lost` is the share of its energy."""
    length = len(record.elevation) * record.interval
    start, tapered = record.start, TAPERED * length
    if abs(start) > 0.5 * record.interval:
        yield (
            f"{name} begins at t = {start:g} s and repeats itself: at t = 0 s the sea is that of "
            f"{-start % length:g} s after its first row: for runs from 0 s on, subtract {start:g} "
            "from its times"
        )
    yield (
        f"{name} is {length:g} s long, repeats itself, and is tapered to 0 for {tapered:g} s at "
        f"each end: that takes {100 * lost:.2g} % of its energy: for statistics of the measured "
        f"sea, take t = {start + tapered:g} to {start + length - tapered:g} s"
    )


def _time(record: Samples, row: int) -> float:
    return record.start + row * record.interval
