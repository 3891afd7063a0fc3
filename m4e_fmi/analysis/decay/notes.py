"""Notes on a fitted decay: how it was recorded, and what it does not tell."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from m4e_fmi.analysis.decay.fit import Decay

UNEVEN, GAP = 0.02, 3.0
"""Deviation of steps from their median that is told, and step over the median of a gap."""
MOST_GAPS = 3
"""That are told one by one."""
PER_PERIOD = 8.0
"""Rows of a period below which a record is coarse."""
TOGETHER = 0.95
"""Correlation of linear and quadratic damping above which they cannot be separated."""
SURE = 0.01
"""Of the equivalent ratio: standard error of ζ below which they are separated nevertheless."""
DIFFERS = 2.0
"""Standard errors from 0 of a value that is not 0."""
DRIFTS = 0.01
"""Of the release: change of rest that is told."""
UNLIKE = 0.01
"""Of the release: residual above which the motion is not of this kind, or noisy."""


def decay_notes(decay: Decay) -> tuple[str, ...]:
    """Sentences on rows, damping, rest and residual that a reader must know."""
    return (*_rows(decay), *_damping(decay), *_rest(decay), *_residual(decay))


def _rows(decay: Decay) -> Iterator[str]:
    steps = np.diff(decay.time)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    for k in gaps[:MOST_GAPS].tolist():
        yield f"the record has a gap from {decay.time[k]:g} to {decay.time[k + 1]:g} s"
    if len(gaps) > MOST_GAPS:
        yield f"it has {len(gaps) - MOST_GAPS} more gaps"
    if not len(gaps) and np.abs(steps - usual).max() > UNEVEN * usual:
        yield (
            f"rows are unevenly spaced, by {steps.min():.3g} to {steps.max():.3g} s: standard "
            "errors take the residual as evenly spaced"
        )
    rows = decay.period.value / usual
    if rows < PER_PERIOD:
        yield f"a period has {rows:.2g} rows only: peaks between rows are missed"


def _damping(decay: Decay) -> Iterator[str]:
    surest = decay.surest_amplitude
    ratio, quadratic = decay.damping_ratio, decay.quadratic
    known = decay.equivalent_ratio(surest)
    unsure = ratio.error > SURE * abs(known.value)
    if abs(decay.correlation) > TOGETHER and unsure and surest > 0.0:
        yield (
            f"linear and quadratic damping cannot be separated (correlation "
            f"{decay.correlation:.3f}): take from this record the equivalent ratio {known} at an "
            f"amplitude of {surest:.3g}; records with larger and smaller releases separate them"
        )
    for name, value in (("linear", ratio), ("quadratic", quadratic)):
        if value.value < -max(DIFFERS * value.error, 1e-6):
            yield (
                f"the {name} damping is negative: another law than these two, memory of waves, or "
                "a force that drives the motion"
            )


def _rest(decay: Decay) -> Iterator[str]:
    trend = decay.trend
    if abs(trend.value) > max(DIFFERS * trend.error, DRIFTS * decay.release):
        yield (
            f"rest drifts by {trend} during the record, which the fit takes as constant: remove "
            "the drift, or fit a shorter part"
        )


def _residual(decay: Decay) -> Iterator[str]:
    if decay.residual_share > UNLIKE:
        yield (
            f"the residual is {100 * decay.residual_share:.2g} % of the release: noise, memory of "
            "waves, or a second motion; look at the picture"
        )
