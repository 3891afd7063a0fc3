"""Thousands of damaged input files of all kinds: a message or a result, in time, nothing outside.

FUZZ_SHARE is the share of the cases that are tried (1), FUZZ_SEED the random seed (1). A campaign
that is broken off goes on when it is started again; inputs that fail are kept in build/fuzz/failed.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.fuzz.campaign import campaign
from support.fuzz.families import Family, families

SHARE = float(os.environ.get("FUZZ_SHARE", "1"))
SEED = int(os.environ.get("FUZZ_SEED", "1"))
FOLDER = Path(__file__).parents[2] / "build" / "fuzz"

pytestmark = pytest.mark.verify


@pytest.mark.parametrize("family", families().values(), ids=families())
def test_damaged_files_are_dealt_with(family: Family) -> None:
    cases = max(len(family.seeds), round(SHARE * family.cases))
    tally = campaign(family.name, cases, SEED, FOLDER)
    print(f"{family.name}: {cases} cases of seed {SEED}, {tally.past} past the first check")
    assert not tally.wrong, "\n".join(tally.wrong)
    assert tally.past >= cases / 3
