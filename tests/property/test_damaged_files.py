"""Input files with random damage, a sample: a message or a result, in time, nothing outside.

`tests/verify/test_damaged_files_campaign.py` tries thousands.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from support.odd_files import Seed, codes, outcome, seeds

CASES = 3
SEED = 2024


@pytest.mark.verifies(
    "commands on input files with random damage: exit codes 0, 1 and 2, in time, no file elsewhere",
    analytic="rules for exit codes and files",
    tolerance="identical",
)
@pytest.mark.parametrize("seed", seeds(), ids=lambda seed: seed.name)
def test_damaged_files_are_dealt_with(seed: Seed, tmp_path: Path) -> None:
    if seed.name.endswith(("tables", "fmus", "fmi 2", "fmi 3", "ssp", "flap", "lists")):
        (tmp_path / "sound").mkdir()
        assert not any(codes(seed, tmp_path / "sound"))
    for k in range(CASES):
        assert not outcome(seed, random.Random(f"{seed.name} {SEED + k}"), tmp_path / str(k))
