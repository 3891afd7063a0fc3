"""Pictures of studies."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from m4e_fmi.report.drawing.pictures import save
from m4e_fmi.study.shown.figure import _bins


@pytest.mark.parametrize("most", [0, 3, 44, 1000, 12345])
def test_bars_of_counts_have_as_many_whole_numbers_each(most: int) -> None:
    """Else some bars stand for two numbers and others for one: peaks that are none."""
    counts = np.arange(3.0, most + 4.0)
    edges = _bins(counts)
    assert isinstance(edges, list)
    assert len(edges) <= 41
    heights, _ = np.histogram(counts, edges)
    assert set(heights[:-1]) <= {heights[0]}
    assert heights.sum() == len(counts)


def test_other_values_have_even_bars() -> None:
    assert _bins(np.array([0.5, 1.0, 2.0])) == 5
    assert _bins(np.array([])) == 5
    assert _bins(np.array([1.0, 1e300])) == 5


def test_dollars_in_names_are_no_formulas(tmp_path: Path) -> None:
    figure = Figure()
    figure.suptitle("cost $x_{ and $y")
    figure.subplots().set_xticks([0, 1], ["$a_{$", "b"])
    assert save(figure, tmp_path / "a.png").stat().st_size > 0
