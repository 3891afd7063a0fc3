"""Thousands of damaged input files: a message or a result, in time, and nothing outside.

ODD_FILES is the number of cases of each seed, ODD_FILES_SEED the first random seed.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from pathlib import Path

import pytest
from support.odd_files import Seed, outcome, seeds

CASES = int(os.environ.get("ODD_FILES", "400"))
FIRST = int(os.environ.get("ODD_FILES_SEED", "1"))

pytestmark = pytest.mark.verify


@pytest.mark.parametrize("seed", seeds(), ids=lambda seed: seed.name)
def test_damaged_files_are_dealt_with(seed: Seed, tmp_path: Path) -> None:
    wrong: Counter[str] = Counter()
    for k in range(FIRST, FIRST + CASES):
        found = outcome(seed, random.Random(f"{seed.name} {k}"), tmp_path / str(k))
        if found:
            print(f"case {k}: {found}")
            wrong[found[:120]] += 1
    print(f"{seed.name}: {CASES} cases from {FIRST}, {sum(wrong.values())} wrong")
    assert not wrong
