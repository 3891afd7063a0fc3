"""Statistics of the rows behind the start-up."""

from __future__ import annotations

import numpy as np

from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.runs.statistics_of import computed


def test_the_row_at_the_end_of_the_start_up_counts() -> None:
    """The maximum of a falling record is its first row that counts."""
    time = np.arange(5.0)
    wanted = [Wanted("top", "x", "maximum")]
    found, _ = computed(wanted, time, {"x": np.array([-time])}, 2.0)
    assert found["top"].tolist() == [-2.0]
