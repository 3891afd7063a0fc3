"""A measured record of waves: its ends, and doubts about its origin, mean, spikes and steps."""

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
    """Lines on what may be wrong with the record in the file `name`."""
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
    yield from _of_origin(name, record)
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


def _of_origin(name: str, record: Samples) -> Iterator[str]:
    """A line on the record's origin of time."""
    start, length = record.start, len(record.elevation) * record.interval
    if abs(start) > 0.5 * record.interval:
        yield (
            f"{name} begins at t = {start:g} s and repeats itself: at t = 0 s the sea is that of "
            f"{-start % length:g} s after its first row: for runs from 0 s on, subtract {start:g} "
            "from its times"
        )


def record_ends(name: str, record: Samples, *, lost: float) -> str:
    """A line on the ends of the record, which take the share `lost` [1] of its energy."""
    length = len(record.elevation) * record.interval
    start, tapered = record.start, TAPERED * length
    return (
        f"{name} is {length:g} s long, repeats itself, and is tapered to 0 for {tapered:g} s at "
        f"each end: that takes {100 * lost:.2g} % of its energy: for statistics of the measured "
        f"sea, take t = {start + tapered:g} to {start + length - tapered:g} s"
    )


def _time(record: Samples, row: int) -> float:
    return record.start + row * record.interval
