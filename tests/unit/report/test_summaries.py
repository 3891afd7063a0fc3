"""Figures in summaries of runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_fmi.report.text import summaries
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Series


def test_a_mean_weighs_rows_by_the_time_between_them() -> None:
    """0 W to 2 W within the first second of ten, 2 W from there on."""
    power = Series("pto.power", "W", "power", np.array([0.0, 2.0, 2.0]))
    results = Results(Path("r.nc"), np.array([0.0, 1.0, 10.0]), {"a": {"pto.power": power}}, {})
    (line, *_) = summaries._extremes(results, "")
    assert line == "mean power 1.900 W over 10 s (a.pto.power)"
