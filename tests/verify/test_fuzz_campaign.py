"""Thousands of damaged input files of all kinds: a message or a result, in time, nothing outside.

And a million native FMUs with damaged programs, under sanitizers: none crashes, leaks or runs away.

FUZZ_SHARE is the share of the cases that are tried (1), FUZZ_SEED the random seed (1). A campaign
that is broken off goes on when it is started again; inputs that fail are kept in build/fuzz/failed.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from support.fuzz.campaign import Tally, campaign
from support.fuzz.families import Family, families
from support.fuzz.shell import shell_fuzzer

SHARE = float(os.environ.get("FUZZ_SHARE", "1"))
SEED = int(os.environ.get("FUZZ_SEED", "1"))
PROGRAMS, BATCH = round(SHARE * 1_000_000), 10_000
FOLDER = Path(__file__).parents[2] / "build" / "fuzz"


@pytest.mark.parametrize("family", families().values(), ids=families())
def test_damaged_files_are_dealt_with(family: Family) -> None:
    cases = max(len(family.seeds), round(SHARE * family.cases))
    tally = campaign(family.name, cases, SEED, FOLDER)
    print(f"{family.name}: {cases} cases of seed {SEED}, {tally.past} past the first check")
    assert not tally.wrong, "\n".join(tally.wrong)
    assert tally.past >= cases / 3


def test_damaged_programs_in_native_fmus(tmp_path: Path) -> None:
    fuzzer = shell_fuzzer(tmp_path)
    FOLDER.mkdir(parents=True, exist_ok=True)
    file = FOLDER / f"shell-{SEED}.json"
    while (tally := Tally.load(file)).next < PROGRAMS:
        last = min(PROGRAMS, tally.next + BATCH)
        ran = fuzzer.run(tally.next, last, SEED)
        if ran.returncode:
            number = fuzzer.first_failure(tally.next, last, SEED)
            tally.wrong.append(f"case {number} of seed {SEED}: {ran.stderr[-2000:]}")
        else:
            tally.past += int(ran.stdout.split()[2])
        tally.next = last
        tally.save(file)
    file.unlink()
    print(f"{PROGRAMS} cases of seed {SEED}, {tally.past} instances")
    assert not tally.wrong, "\n".join(tally.wrong)
    assert tally.past >= PROGRAMS / 3
