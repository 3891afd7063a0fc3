"""Windows of a run that are repeated: what they tell of the whole, and what is none of a run."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim.error_estimate.kinks import NOISE, events, first_events, rougher
from m4e_fmi.cosim.error_estimate.repeated_steps import Recorded
from m4e_fmi.cosim.error_estimate.stretch import Stretch
from m4e_fmi.cosim.error_estimate.windows import Told, pieces, throughout
from m4e_fmi.cosim.exchange.layout import NetworkSnapshot
from m4e_fmi.cosim.scenario.scenario import ScenarioSnapshot

GROWING = [1.0, 2, 3, 4, 5, 6, 7, 8]
NS = 10**7


def told(errors: list[float], begin: int, span: int, *, speaks: bool = True) -> Told:
    return Told(np.array(errors, dtype=float)[:, None], begin, span, speaks)


@pytest.mark.parametrize(
    ("windows", "end", "error"),
    [
        ([told(GROWING, 0, 10)], 100, 80),  # what grows with the time goes on growing
        ([told([1, 2, 3, 0.1, 5, 6, 0.1, 8], 0, 10)], 100, 80),  # an oscillation turns
        ([told([3, 8, 8, 8, 8, 8, 8, 8], 0, 10)], 100, 8 * 10**0.05),  # what has its size keeps it
        ([told([0.0] * 8, 0, 100), told(GROWING, 100, 10)], 200, 80),
        # octaves add up: 30 of the first, 65 of the second, and one that stands for itself alone
        (
            [told(GROWING, 0, 10), told([2.0], 30, 5), told([2.0], 50, 5, speaks=False)],
            100,
            8 * 3 + 2 * 13 + 2,
        ),
    ],
)
def test_the_error_throughout(windows: list[Told], end: int, error: float) -> None:
    assert throughout(windows, 0, end)[0] == pytest.approx(error)


def test_the_largest_counts_of_what_dies_out() -> None:
    window = told([0.1, 0.2, 4, 0.02, 0.01, 8, 3, 0.4], 0, 10)
    assert 8 < throughout([window], 0, 100)[0] < 8 * 1.1


@pytest.mark.parametrize("steps", [1, 2, 7, 8, 9, 100])
def test_pieces_cover_all_steps(steps: int) -> None:
    found = pieces(np.arange(steps, dtype=float)[:, None])
    assert len(found) == min(8, steps)
    assert found[-1, 0] == steps - 1
    assert (np.diff(found[:, 0]) > 0).all()


def test_kinks_that_act_on_each_others_steps_are_of_one_event() -> None:
    kinks = np.array([3, 4, 8, 13, 30])
    assert events(kinks) == 3
    assert first_events(kinks, 2).tolist() == [3, 4, 8, 13]
    assert events(kinks[:0]) == len(first_events(kinks[:0], 2)) == 0


@pytest.mark.parametrize("step", range(5))
def test_a_kink_in_the_first_steps_of_a_stretch_counts(step: int) -> None:
    values = np.sin(0.05 * np.arange(40)) + np.where(np.arange(40) > step, 0.3, 0.0)
    run = Recorded(np.arange(40), values[:, None])
    assert len(rougher(np.array([step]), run, NOISE * run.largest))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"values": [np.zeros((1, 2)), np.zeros((3, 3))]}, "the same outputs"),
        ({"values": [np.zeros(4)]}, "the same outputs"),
        ({"values": [np.zeros((3, 2))]}, "those of its steps"),
        ({"steps": 4}, "those of its runs"),
        ({"runs": [(NS, 4), (NS, -1)]}, "those of its runs"),
        ({"kinks": [np.array([1, 4])]}, "within it"),
    ],
)
def test_a_stretch_of_a_checkpoint_that_does_not_fit_together(
    change: dict[str, Any], why: str
) -> None:
    """Three steps of two outputs."""
    none, whole = np.zeros(0), np.zeros(0, np.int64)
    scenario = ScenarioSnapshot(0, (), (), (), (), ())
    start = NetworkSnapshot(0, 0.0, 0.0, none, none, (whole, whole, ()), (), 0.0, scenario)
    stretch = Stretch(start, window=True, recorded=True, end=9, values=[np.zeros((4, 2))], last=0)
    stretch.go_on(3, NS)
    stretch.check()
    with pytest.raises(ValueError, match=why):
        replace(stretch, **change).check()
