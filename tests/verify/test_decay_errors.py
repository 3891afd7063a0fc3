"""Standard errors of fitted decays: true values lie within two of them in about 95 % of records.

Each kind of noise has 200 records of eight periods, with 40 rows in a period and a standard
deviation of 2 % of the release. Of a normal distribution 95.4 % are expected, with a standard
deviation of 1.5 % in 200 records. Limits are four of these below.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import t as student_t

from m4e_fmi.analysis.decay import fit_decay
from m4e_fmi.analysis.decay.oscillation import Shape, oscillation

RECORDS, LEVEL, PERIOD = 200, 0.02, 4.0
RATIO, B, REST = 0.03, 0.1, 0.05
TIME = PERIOD / 40 * np.arange(340, dtype=float)
WITHIN, SPREAD = 0.954, 0.015


def coloured(correlation: float, random: np.random.Generator) -> np.ndarray:
    """Noise (n,) [1] of variance 1 at TIME; `correlation` is its time [s], 0 of white noise."""
    factor = math.exp(-(TIME[1] - TIME[0]) / correlation) if correlation else 0.0
    white = random.normal(size=len(TIME) + 2000)
    noise = np.asarray(lfilter([math.sqrt(1 - factor**2)], [1.0, -factor], white))
    return noise[-len(TIME) :]


@pytest.mark.parametrize("correlation", [0.0, 0.1 * PERIOD, 0.3 * PERIOD, PERIOD])
def test_standard_errors(correlation: float) -> None:
    random = np.random.default_rng(11)
    shape = Shape(2 * math.pi / PERIOD, RATIO, B, 1.0, 0.0, REST)
    motion, _ = oscillation(shape, TIME)
    found = []
    for _ in range(RECORDS):
        fit = fit_decay(TIME, motion + LEVEL * coloured(correlation, random))
        pairs = (
            (fit.period, PERIOD), (fit.damping_ratio, RATIO), (fit.quadratic, B), (fit.rest, REST)
        )  # fmt: skip
        found.append([(one.value - true) / one.error for one, true in pairs])
    within = (np.abs(found) < 2.0).mean(axis=0)
    print(f"correlated over {correlation:g} s: {within} within two standard errors")
    assert (within[:3] > WITHIN - 4 * SPREAD).all()
    # of rest there are as many independent values as twice the correlation is in the record
    values = len(TIME) if not correlation else TIME[-1] / (2.0 * correlation)
    expected = 1.0 - 2.0 * student_t.sf(2.0, values - 1)
    assert within[3] > expected - 4 * math.sqrt(expected * (1 - expected) / RECORDS)
    # neither much too large: a standard deviation of 1, to 0.05 for 200 records
    assert (np.std(found, axis=0) > 0.7).all()
