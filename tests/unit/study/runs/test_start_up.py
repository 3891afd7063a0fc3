"""The part of runs that statistics leave out, in words."""

import numpy as np

from m4e_fmi.study.runs.start_up import DEFAULT, left_out


def test_nothing_is_left_out_where_no_sea_has_a_ramp() -> None:
    assert left_out(np.zeros(3), DEFAULT).startswith("nothing: no start_up is stated")


def test_times_of_ramps_and_stated_ones_are_told_with_their_source() -> None:
    assert left_out(np.array([3.0, np.nan, 6.0]), DEFAULT) == f"all before t = 3 to 6 s ({DEFAULT})"
    assert left_out(np.zeros(2), "0 s, as stated") == "all before t = 0 s (0 s, as stated)"
