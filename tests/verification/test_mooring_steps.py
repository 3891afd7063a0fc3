"""Random moorings in a sea hold in steps of 0.95 of what the loop over MoorDyn takes for stable.

Short of the campaign in tests/verify: of few seconds, lines that are quickly computed.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.sea_motion import holds, random_mooring, tensions

SEED = 46
QUICK = 1e-3  # [s] longest internal step of lines that are taken


@pytest.mark.verifies(
    "tensions of 20 random moorings in a sea with 0.95 of the longest internal step",
    independent="steps of half the length",
    tolerance="1 % of range, rms; at 1.6 a third fails",
)
def test_steps_hold_below_the_longest_and_fail_above() -> None:
    rng = np.random.default_rng(SEED)
    below, above = [], []
    while len(below) < 20:
        moored = random_mooring(rng)
        if moored.made.time_step < QUICK or moored.line.segments > 40:
            continue
        short = tensions(moored, share=0.45, duration=20.0)
        below.append(holds(moored, share=0.95, short=short))
        above.append(holds(moored, share=1.6, short=short))
    assert all(below)
    assert sum(above) <= 2 / 3 * 20
