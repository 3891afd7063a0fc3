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


def test_the_power_of_all_inputs_is_no_mean_power_beside_others() -> None:
    series = {
        name: Series(name, "W", name, np.array([value, value]))
        for name, value in (("inputs.power", -3.0), ("pto.power", 5.0))
    }
    results = Results(Path("r.nc"), np.array([0.0, 1.0]), {"a": series}, {})
    text = "\n".join(summaries._extremes(results, ""))
    assert "mean power 5.000 W over 1 s (a.pto.power)" in text
    assert text.count("mean power") == 1
