"""Random mooring lines: where they start, and internal steps around the longest stable one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from support.sea_motion import holds, random_mooring, tensions
from support.static_lines import random_line, start_error

SEED = 20_261_122
SEGMENTS = (20, 40, 50, 75, 100, 150, 200, 300, 400, 500, 700, 1000)
SHORT = 0.45  # of the longest step: those of the reference


def test_random_lines_start_at_rest_or_tell():
    """The reference has as many segments: their number is not what is judged."""
    rng = np.random.default_rng(SEED)
    found = [start_error(random_line(rng)) for _ in range(200)]
    errors = np.array([abs(error) for error, _ in found])
    warned = np.array([told for _, told in found])
    print(f"seed {SEED}: largest error {errors.max():.2g}, {warned.sum()} of 200 warned")
    assert (errors[~warned] < 0.02).all()
    assert warned.mean() <= 0.05
    assert (errors[warned] > 0.01).all()


def test_random_lines_of_many_segments_start_at_rest():
    rng = np.random.default_rng(SEED)
    lines = [replace(random_line(rng), segments=int(rng.choice(SEGMENTS))) for _ in range(60)]
    found = [start_error(line) for line in lines]
    errors = np.array([abs(error) for error, _ in found])
    print(f"seed {SEED}: largest error {errors.max():.2g}")
    # the reference has a rigid seabed, and all of its line in the water
    assert (errors < 2e-3).all()
    assert not any(told for _, told in found)


def test_random_moorings_hold_below_the_longest_step_and_fail_above() -> None:
    rng = np.random.default_rng(SEED)
    below, above = [], []
    for _ in range(200):
        moored = random_mooring(rng)
        short = tensions(moored, share=SHORT, duration=120.0)
        below.append(holds(moored, share=0.95, short=short))
        above.append(holds(moored, share=1.6, short=short))
        print(f"{moored.made.time_step:.3g} s: {below[-1]}, at 1.6 {above[-1]}", moored.line)
    print(f"seed {SEED}: {sum(below)} of 200 hold at 0.95, {sum(above)} at 1.6")
    assert all(below)
    assert sum(above) <= 2 / 3 * 200
