"""Result of a comparison: the `Difference` of each variable, all of them in a `Comparison`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_fmi.analysis.comparison.measures import Phase, Scales, normalised
from m4e_fmi.analysis.points import Floats
from m4e_fmi.shown import listing

Span = tuple[float, float]
"""First and last time [s] of a part."""


@dataclass(frozen=True)
class Difference:
    """A variable beside its reference; values are in `unit`.

    `values` and `reference` (k,) are those at `time` (k,) [s], `difference` the first minus the
    second. `left_out` counts times within the common interval at which one of them has a gap,
    `lacking` those of them at which the reference has a value: the variable has none, or no finite
    one.
    `scale` is what differences are divided by; `nrmse` is Eq. (10) of the paper. `interpolated`
    says how one of them was brought to the times of the other, and `interpolation_error` estimates
    the root mean square of what that adds.
    """

    name: str
    reference_name: str
    unit: str
    time: Floats = field(repr=False)
    values: Floats = field(repr=False)
    reference: Floats = field(repr=False)
    left_out: int
    lacking: int
    interpolated: str
    interpolation_error: float
    rms: float
    largest: float
    largest_at: float
    sizes: Scales
    scale: float
    nrmse: float
    phase: Phase
    notes: tuple[str, ...] = ()

    @property
    def difference(self) -> Floats:
        """Values minus reference, (k,) in the unit of the variable."""
        return self.values - self.reference

    @property
    def offset(self) -> float:
        """Mean difference, in `unit`; nan without common rows."""
        return float(np.mean(self.difference)) if len(self.time) else math.nan

    @property
    def rms_beside_offset(self) -> float:
        """Root of the mean square difference without its mean, in `unit`."""
        return float(np.std(self.difference)) if len(self.time) else math.nan

    def over(self, difference: float, size: str) -> float:
        """A `difference` in `unit` over the reference's range, amplitude or value [1]."""
        return float(normalised(np.array([difference]), getattr(self.sizes, size))[0])

    @property
    def rms_share(self) -> float:
        """Root of the mean square difference over `scale` [1]."""
        return float(normalised(np.array([self.rms]), self.scale)[0])

    @property
    def largest_share(self) -> float:
        """Largest difference over `scale` [1]; nan without common rows."""
        return float(normalised(np.array([self.largest]), self.scale)[0])

    def first_beyond(self, tolerance: float) -> float | None:
        """The time [s] at which |difference| over `scale` first is beyond a `tolerance`."""
        shares = normalised(self.difference, self.scale)
        beyond = np.flatnonzero(np.abs(shares) > tolerance)
        return float(self.time[beyond[0]]) if len(beyond) else None

    def is_within(self, tolerance: float) -> bool:
        """True if no difference over `scale` is beyond a `tolerance`, and no value is lacking.

        False without rows.
        """
        return self.largest_share <= tolerance and not self.lacking

    def __repr__(self) -> str:
        return (
            f"Difference of {self.name} [{self.unit}]: rms {self.rms:.4g}, largest "
            f"{self.largest:.4g} at {self.largest_at:.6g} s, {len(self.time)} rows"
        )


@dataclass(frozen=True)
class Comparison:
    """Differences by variable of one file, `path`, from the `reference`.

    `only_here` and `only_there` are variables without a counterpart. Differences are divided by the
    reference's `relative_to`: range, amplitude or value. `tolerance` is the largest that is
    accepted, None without one. `notes` tell how the files were read and matched. `lacking` are
    parts of the reference, within the interval that was asked for, of which the file has no rows.
    """

    path: Path
    reference: Path
    differences: Mapping[str, Difference]
    relative_to: str
    tolerance: float | None
    only_here: tuple[str, ...]
    only_there: tuple[str, ...]
    notes: tuple[str, ...] = ()
    lacking: tuple[Span, ...] = ()

    @property
    def worst(self) -> tuple[Difference, ...]:
        """Differences by their largest share, the largest first; those without rows before."""
        key = {n: d.largest_share for n, d in self.differences.items()}
        order = sorted(key, key=lambda n: -math.inf if math.isnan(key[n]) else -key[n])
        return tuple(self.differences[name] for name in order)

    @property
    def beyond(self) -> tuple[str, ...]:
        """Variables that are not within the tolerance; none without one."""
        if self.tolerance is None:
            return ()
        limit = self.tolerance
        return tuple(n for n, d in self.differences.items() if not d.is_within(limit))

    @property
    def is_within(self) -> bool:
        """True if all differences are within the tolerance, or there is none.

        False if a part of the reference is lacking.
        """
        return self.tolerance is None or not (self.beyond or self.lacking)

    def __getitem__(self, name: str) -> Difference:
        return self.differences[name]

    def __repr__(self) -> str:
        title = f"Comparison of {self.path.name!r} with {self.reference.name!r}"
        if self.tolerance is not None:
            verdict = "within" if self.is_within else "beyond" if self.beyond else "not all within"
            title += f", {verdict} the tolerance of {self.tolerance:g} of the {self.relative_to}"
        shown = [
            f"{d.name}: {100 * d.rms_share:.2g} % (largest {100 * d.largest_share:.2g} %)"
            for d in self.worst
        ]
        return listing(
            title,
            **{f"root mean square of the {self.relative_to}": shown},
            **{"only here": self.only_here, "only in the reference": self.only_there},
        )
