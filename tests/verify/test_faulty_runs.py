"""The campaign of faults: each run ends in time, names the culprit, and is resumed to the same bits.

The kinds of faults and the calls are in `support.faults.table`; one case is checked as
`support.faults.campaign` says. ``SEED=… make verify VERIFY="-k faulty_runs"`` takes other cases.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.faults.campaign import PAIRS, Campaign, case

pytestmark = pytest.mark.verify
SEED = int(os.environ.get("SEED", "20261123"))
COUNT = int(os.environ.get("COUNT", 2 * len(PAIRS)))


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    print("seed", SEED)
    return Campaign(tmp_path_factory.mktemp("campaign"))


@pytest.mark.parametrize("number", range(COUNT))
def test_a_faulty_fmu(number: int, campaign: Campaign, tmp_path: Path) -> None:
    print(campaign.check(case(SEED, number), tmp_path))
