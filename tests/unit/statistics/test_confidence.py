"""Confidence intervals over seeds."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.statistics import confidence_interval


def test_one_seed_and_missing_values_have_no_interval() -> None:
    found = confidence_interval([[2.0], [3.0]])
    assert found.mean.tolist() == [2.0, 3.0]
    assert np.isnan([found.low, found.high, found.error]).all()
    assert np.isnan(confidence_interval([1.0, np.nan, 2.0]).mean)
    for values, level in (([], 0.95), (1.0, 0.95), ([1.0, 2.0], 95.0), ([1.0], np.nan)):
        with pytest.raises(InputError):
            confidence_interval(values, level)
