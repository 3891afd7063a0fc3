"""Input files with random damage, a sample: a message or a result, in time, nothing outside.

`tests/verify/test_fuzz_campaign.py` tries a hundred times as many.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.fuzz.cases import codes, run_case
from support.fuzz.families import Family, families

SHARE = 0.01
SEED = 2024


@pytest.mark.verifies(
    "commands on input files with random damage: exit codes 0, 1 and 2, in time, no file elsewhere",
    analytic="rules for exit codes and files",
    tolerance="identical",
)
@pytest.mark.parametrize("family", families().values(), ids=families())
def test_damaged_files_are_dealt_with(family: Family, tmp_path: Path) -> None:
    cases = round(SHARE * family.cases)
    found = [run_case(family, k, SEED, tmp_path / str(k)) for k in range(cases)]
    assert [one.wrong for one in found if one.wrong] == []
    assert sum(one.past for one in found) >= cases / 3


SOUND = ("tables", "fmus", "fmi 2", "fmi 3", "flap", "lists", "parameters", "ssv")


@pytest.mark.parametrize("family", families().values(), ids=families())
def test_files_without_damage_are_read(family: Family, tmp_path: Path) -> None:
    for seed in family.seeds:
        if family.name not in ("yaml", "fmu") or seed.name.endswith(SOUND):
            (tmp_path / seed.name).mkdir()
            assert not any(codes(seed, tmp_path / seed.name)), seed.name
