"""What windows tell of a whole run."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.cosim.error_estimate.kinks import events, first_events
from m4e_fmi.cosim.error_estimate.windows import Told, pieces, throughout


def told(errors: list[float], begin: int, span: int, *, speaks: bool = True) -> Told:
    return Told(np.array(errors, dtype=float)[:, None], begin, span, speaks)


def test_what_grows_with_the_time_goes_on_growing() -> None:
    window = told([1, 2, 3, 4, 5, 6, 7, 8], 0, 10)
    assert throughout([window], 0, 100)[0] == pytest.approx(80)


def test_what_has_its_size_keeps_it() -> None:
    window = told([3, 8, 8, 8, 8, 8, 8, 8], 0, 10)
    assert throughout([window], 0, 100)[0] == pytest.approx(8 * 10**0.05)


def test_the_largest_counts_of_what_dies_out() -> None:
    window = told([0.1, 0.2, 4, 0.02, 0.01, 8, 3, 0.4], 0, 10)
    error = throughout([window], 0, 100)[0]
    assert 8 < error < 8 * 1.1


def test_one_piece_in_which_an_oscillation_turns_is_no_end() -> None:
    window = told([1, 2, 3, 0.1, 5, 6, 0.1, 8], 0, 10)
    assert throughout([window], 0, 100)[0] == pytest.approx(80)


def test_octaves_add_up_and_others_count_for_themselves() -> None:
    growing = [1.0, 2, 3, 4, 5, 6, 7, 8]
    windows = [told(growing, 0, 10), told([2.0], 30, 5), told([2.0], 50, 5, speaks=False)]
    # 30 of the first, 65 of the second, and one that stands for itself alone
    assert throughout(windows, 0, 100)[0] == pytest.approx(8 * 3 + 2 * 13 + 2)


def test_windows_without_errors_tell_nothing_of_growth() -> None:
    windows = [told([0.0] * 8, 0, 100), told([1.0, 2, 3, 4, 5, 6, 7, 8], 100, 10)]
    assert throughout(windows, 0, 200)[0] == pytest.approx(80)


def test_half_the_step_leaves_a_share() -> None:
    window = Told(np.array([[2.0], [4.0]]), 0, 10, speaks=True, left=0.25)
    assert window.halved.errors.tolist() == [[0.5], [1.0]]


@pytest.mark.parametrize("steps", [1, 2, 7, 8, 9, 100])
def test_pieces_cover_all_steps(steps: int) -> None:
    errors = np.arange(steps, dtype=float)[:, None]
    found = pieces(errors)
    assert len(found) == min(8, steps)
    assert found[-1, 0] == steps - 1
    assert (np.diff(found[:, 0]) > 0).all()


def test_kinks_that_act_on_each_others_steps_are_of_one_event() -> None:
    kinks = np.array([3, 4, 8, 13, 30])
    assert events(kinks) == 3
    assert first_events(kinks, 2).tolist() == [3, 4, 8, 13]
    assert first_events(kinks[:0], 2).tolist() == []
    assert events(kinks[:0]) == 0
