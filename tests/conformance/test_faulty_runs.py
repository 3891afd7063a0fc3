"""Runs of FMUs with faults: each ends, names the culprit, and is resumed to the undisturbed bits.

A fixed sample of the campaign in tests/verify/test_faulty_runs.py.
"""

from __future__ import annotations

import signal
from functools import partial
from pathlib import Path

import pytest
from support.faults.campaign import Campaign, Case, Setting
from support.faults.masters import dying_in_a_write
from support.faults.table import KINDS, Fault
from support.faults.trial import differences, finished

KIND = {kind.name: kind for kind in KINDS}
OLD, USUAL, NEW = (
    Setting(1, "gauss_seidel"),
    Setting(2, "corrector"),
    Setting(3, "implicit"),
)
SAMPLE = (
    Case(OLD, Fault("arm", "step", KIND["segv"], 0.7)),
    Case(OLD, Fault("buoy", "initialise", KIND["exit"])),
    Case(Setting(1, "corrector"), Fault("arm", "initialise", KIND["fatal"])),
    Case(USUAL, Fault("line", "step", KIND["sigstop"], 1.2)),
    Case(USUAL, Fault("arm", "get", KIND["rounding"], 0.5)),
    Case(USUAL, Fault("arm", "instantiate", KIND["segv"])),
    Case(USUAL, Fault("line", "free", KIND["segv"])),
    Case(USUAL, Fault("arm", "step", KIND["chdir"], 0.6)),
    Case(NEW, Fault("buoy", "set", KIND["pthread_exit"], 0.9, 3)),
    Case(NEW, Fault("line", "terminate", KIND["abort"])),
    Case(NEW, Fault("arm", "step", KIND["fork"], 0.4)),
    Case(USUAL, Fault("arm", "step", KIND["twin"], 0.6)),
    Case(NEW, Fault("line", "get", KIND["negative"], 0.8)),
)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    return Campaign(tmp_path_factory.mktemp("campaign"))


@pytest.mark.parametrize("case", SAMPLE, ids=lambda case: case.fault.plan.strip())
def test_a_faulty_fmu(case: Case, campaign: Campaign, tmp_path: Path) -> None:
    campaign.check(case, tmp_path)


def test_a_master_killed_inside_a_write(campaign: Campaign, tmp_path: Path) -> None:
    """Its workers end, and another process goes on."""
    place = campaign.place(USUAL, tmp_path)
    with place.running(patch=partial(dying_in_a_write, 8, 0.6)) as running:
        done = finished(place, running)
    assert done.code == -signal.SIGKILL, done.err
    assert place.processes_left(done) == []
    assert differences(place.results(), campaign.whole(USUAL), complete=False) == []
    campaign.check_resumed(place, USUAL)
