"""Statistics by name, as study files have them: `STATISTICS`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError, Named, Problem, suggestion
from m4e_fmi.shown import short
from m4e_fmi.statistics import (
    cycles,
    extremes,
    moments,
    spectra,
)
from m4e_fmi.statistics.record import LARGEST, Floats, UndefinedError, check_finite, checked_runs
from m4e_fmi.units import SPELLINGS

_PIECE = re.compile(r"([A-Za-zµ°%Ω]+)\^?(-?\d+)?")
_PLAIN = ("", "1")


_same = str
"""The unit of the values."""


def _none(_: str) -> str:
    """That of numbers without dimension."""
    return "1"


def _seconds(_: str) -> str:
    """That of times."""
    return "s"


def _squared(unit: str) -> str:
    """The square of a unit, as ``m2/s2`` of ``m/s``."""
    if unit in _PLAIN:
        return "1"
    return _PIECE.sub(lambda one: f"{one[1]}{2 * int(one[2] or 1)}", unit.translate(SPELLINGS))


def _squared_times_frequency(power: int, unit: str) -> str:
    """The square of a unit times (rad/s) to a power from 1 on: that of spectral moments."""
    top, _, bottom = _squared(unit).partition("/")
    of = "" if power == 1 else str(power)
    upper = [*([] if top in _PLAIN else [top]), f"rad{of}"]
    lower = [*([bottom.strip("()")] if bottom else []), f"s{of}"]
    return f"{'.'.join(upper)}/{lower[0] if len(lower) == 1 else '(' + '.'.join(lower) + ')'}"


Kernel = Callable[..., float]
"""Takes the times (n,) [s], the values (n,) of one run, parameters by name; or UndefinedError."""


@short
@dataclass(frozen=True)
class Limits:
    """Range of a parameter's values: more than `above`, at most `most`."""

    above: float = -math.inf
    most: float = math.inf

    def complaint(self, value: object) -> str:
        """The fault of a value in words; empty if it has none."""
        if isinstance(value, bool | str) or not isinstance(value, int | float | np.number):
            return f"is {value!r}, expected a number"
        if not math.isfinite(value):
            return f"is {value}, expected a finite number"
        if not self.above < value <= self.most:
            texts = [f"more than {self.above:g}"] if math.isfinite(self.above) else []
            texts += [f"at most {self.most:g}"] if math.isfinite(self.most) else []
            return f"is {value:g}, expected {' and '.join(texts)}"
        return ""


POSITIVE = Limits(above=0.0)


@dataclass(frozen=True)
class Explained:
    """`values` (m,) of a statistic of m runs, in its unit; `reasons` of those that are nan."""

    values: Floats = field(repr=False)
    reasons: tuple[str, ...]

    def __repr__(self) -> str:
        bad = sum(map(bool, self.reasons))
        return f"Explained({len(self.values)} values, {bad} of them not defined)"


@short
@dataclass(frozen=True)
class Statistic:
    """A statistic of a record: its `name` and `text`, and its `unit` from that of the values.

    `parameters` are the defaults by name; None is one that must be given. `limits` are their
    ranges. `kernel` computes it for one run.
    """

    name: str
    text: str
    unit: Callable[[str], str]
    kernel: Kernel
    parameters: Mapping[str, float | None] = field(default_factory=dict)
    limits: Mapping[str, Limits] = field(default_factory=dict)

    def compute(self, time: ArrayLike, values: ArrayLike, **parameters: float) -> Floats:
        """The statistic of m runs, (m,) in the unit by `unit`; nan where it is not defined.

        `time` (n,) [s] is that of all runs, `values` (m, n) are in their unit. InputError as
        `checked_runs` and `problems`.
        """
        return self.explained(time, values, **parameters).values

    def explained(self, time: ArrayLike, values: ArrayLike, **parameters: float) -> Explained:
        """The statistic of m runs, with the reason where it is not defined.

        `time` (n,) [s] and `values` (m, n), in their unit, as `compute`.
        """
        if wrong := self.problems(parameters):
            raise InputError(wrong)
        given = {k: v for k, v in {**self.parameters, **parameters}.items() if v is not None}
        t, x = checked_runs(time, values)
        found, reasons = np.full(len(x), np.nan), []
        sound = np.abs(x).max(axis=1) <= LARGEST  # false of nan
        for k, run in enumerate(x):
            reason = ""
            try:
                if not sound[k]:
                    check_finite(t, run)
                found[k] = self.kernel(t, run, **given)
            except UndefinedError as error:
                reason = str(error)
            reasons.append(reason)
        return Explained(found, tuple(reasons))

    def problems(self, parameters: Mapping[str, object]) -> list[Problem]:
        """A problem for each parameter that is unknown, out of range or missing."""
        wrong = [
            Problem(f"{self.name} has no parameter {name!r}", suggestion(name, self.parameters))
            for name in parameters
            if name not in self.parameters
        ]
        for name, default in self.parameters.items():
            if name not in parameters:
                if default is None:
                    wrong.append(Problem(f"{self.name} needs the parameter {name!r}"))
                continue
            fault = self.limits.get(name, Limits()).complaint(parameters[name])
            if fault:
                wrong.append(Problem(f"{self.name}: {name} {fault}"))
        return wrong


def _of_values(function: Callable[[Floats], float], _: Floats, run: Floats) -> float:
    """A `function` of `run` (n,), in its unit, whatever its times (n,) [s]."""
    return float(function(run))


_EVERY = (
    Statistic("mean", "mean over time", _same, moments.mean),
    Statistic(
        "standard_deviation", "standard deviation over time", _same,
        moments.standard_deviation,
    ),
    Statistic("rms", "root of the mean square over time", _same, moments.rms),
    Statistic("minimum", "smallest recorded value", _same, partial(_of_values, np.min)),
    Statistic("maximum", "largest recorded value", _same, partial(_of_values, np.max)),
    Statistic("range", "maximum minus minimum", _same, partial(_of_values, np.ptp)),
    Statistic(
        "largest_magnitude", "largest recorded magnitude", _same,
        lambda _, run: float(np.max(np.abs(run))),
    ),
    Statistic(
        "percentile", "value below which the record is for `percent` of the time",
        _same, moments.percentile,
        {"percent": None}, {"percent": Limits(above=0.0, most=100.0)},
    ),
    Statistic(
        "time_above", "share of the time above `level`", _none, moments.time_above,
        {"level": None},
    ),
    Statistic(
        "number_above", "number of times that the record rises above `level`, as of impacts",
        _none, moments.number_above, {"level": None},
    ),
    Statistic(
        "significant_height",
        "mean of the highest third of heights, crest minus trough, of cycles about the mean",
        _same, cycles.significant_height,
    ),
    Statistic(
        "significant_amplitude",
        "mean of the highest third of crests above the mean, one of each cycle",
        _same, cycles.significant_amplitude,
    ),
    Statistic(
        "zero_crossing_period", "mean time between up-crossings of the mean", _seconds,
        cycles.zero_crossing_period,
    ),
    Statistic(
        "number_of_cycles", "complete cycles between up-crossings of the mean", _none,
        cycles.number_of_cycles,
    ),
    *(
        Statistic(
            f"spectral_moment_{order}", f"∫ ω^{order} S dω of the spectrum", unit,
            partial(spectra.spectral_moment, order),
        )
        for order, unit in (
            (0, _squared),
            *((k, partial(_squared_times_frequency, k)) for k in (1, 2)),
        )
    ),
    *(
        Statistic(f"spectral_{name}", text, unit, partial(spectra.spectral, name))
        for name, text, unit in (
            ("significant_height", "4 √m₀", _same),
            ("mean_period", "T₀₁ = 2π m₀/m₁", _seconds),
            ("zero_crossing_period", "T₀₂ = 2π √(m₀/m₂)", _seconds),
            ("peak_period", "period of the highest spectral density", _seconds),
        )
    ),
    Statistic(
        "most_probable_maximum",
        "mode of the maximum over `duration` [s] of a Gaussian process: mean + σ √(2 ln N)",
        _same, extremes.most_probable_maximum, {"duration": None},
        {"duration": POSITIVE},
    ),
    Statistic(
        "expected_maximum",
        "mean of the maximum over `duration` [s] of a Gaussian process: "
        "mean + σ (√(2 ln N) + γ/√(2 ln N))",
        _same, extremes.expected_maximum, {"duration": None}, {"duration": POSITIVE},
    ),
    Statistic(
        "maximum_quantile",
        "value that the maximum over `duration` [s] of a Gaussian process does not exceed with "
        "`probability`",
        _same, extremes.maximum_quantile, {"duration": None, "probability": None},
        {"duration": POSITIVE, "probability": Limits(above=0.0, most=math.nextafter(1.0, 0.0))},
    ),
    Statistic(
        "damage_equivalent_load",
        "constant range that, at `reference_frequency` [Hz], does the damage of the rainflow "
        "cycles, for an S-N curve of `exponent`",
        _same, cycles.damage_equivalent_load,
        {"exponent": None, "reference_frequency": 1.0},
        {"exponent": POSITIVE, "reference_frequency": POSITIVE},
    ),
)  # fmt: skip
STATISTICS: Mapping[str, Statistic] = Named("there is no statistic", {s.name: s for s in _EVERY})
"""All statistics by name."""
