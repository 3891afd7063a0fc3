"""The campaign of faults: each run ends, names the culprit, and is resumed to the same bits.

The kinds of faults and the calls are in `support.faults.table`; one case is checked as
`support.faults.campaign` says. ``SEED=… make verify VERIFY="-k faulty_runs"`` takes other cases.
"""

from __future__ import annotations

import os
import random
import re
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from support.disturbed import until
from support.faults.campaign import ALGORITHMS, PAIRS, Campaign, Setting, case
from support.faults.masters import dying_in_a_write, enlarge, small_disk
from support.faults.table import Fault, Kind
from support.faults.trial import Place, differences, finished

SEED = int(os.environ.get("SEED", "20261123"))
COUNT = int(os.environ.get("COUNT", len(PAIRS)))


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    print("seed", SEED)
    return Campaign(tmp_path_factory.mktemp("campaign"))


@pytest.mark.parametrize("number", range(COUNT))
def test_a_faulty_fmu(number: int, campaign: Campaign, tmp_path: Path) -> None:
    print(campaign.check(case(SEED, number), tmp_path))


def chance_of(number: int) -> tuple[random.Random, Setting]:
    """Random numbers of a case, and its setting."""
    chance = random.Random(f"{SEED} {number}")
    version = chance.choice([1, 2, 3])
    algorithms = [name for name in ALGORITHMS if version > 1 or name != "implicit"]
    return chance, Setting(version, chance.choice(algorithms), chance.random() < 0.7)


@pytest.fixture
def slow(campaign: Campaign, tmp_path: Path) -> Callable[[Setting], Place]:
    """`slow(setting)` has a system in which a step of one FMU takes 5 ms: the run 2 s or more."""

    def made(setting: Setting) -> Place:
        place = campaign.place(setting, tmp_path)
        place.arm(Fault("arm", "step", Kind("slow", "ends")))
        return place

    return made


def check_left(campaign: Campaign, setting: Setting, place: Place) -> None:
    """Rows that a run has left, and those of its continuation, are the undisturbed ones."""
    if (place.folder / "r.nc").exists():
        assert differences(place.results(), campaign.whole(setting), complete=False) == []
    campaign.check_resumed(place, setting)


@pytest.mark.parametrize("number", range(20))
def test_a_master_killed(number: int, campaign: Campaign, slow: Callable[[Setting], Place]) -> None:
    """By kill -9, at any time: its workers end, and another process goes on."""
    chance, setting = chance_of(number)
    place = slow(setting)
    with place.running() as running:
        time.sleep(chance.uniform(0.3, 3.0))
        running.send(signal.SIGKILL)
        done = finished(place, running)
    assert done.code in (0, -signal.SIGKILL)
    assert place.processes_left(done) == []
    check_left(campaign, setting, place)


@pytest.mark.parametrize("number", range(20))
def test_a_master_killed_inside_a_write(number: int, campaign: Campaign, tmp_path: Path) -> None:
    """A part of the rows, or of a checkpoint, is on the disk."""
    chance, setting = chance_of(number)
    place = campaign.place(setting, tmp_path)
    patch = partial(dying_in_a_write, chance.randrange(20), chance.random())
    with place.running(patch=patch) as running:
        done = finished(place, running)
    assert done.code in (0, -signal.SIGKILL), done.err
    assert place.processes_left(done) == []
    check_left(campaign, setting, place)


@pytest.mark.parametrize("number", range(12))
def test_signals(number: int, campaign: Campaign, slow: Callable[[Setting], Place]) -> None:
    """SIGTERM, SIGHUP and Ctrl-C end a run at once, in a call that does not return too."""
    chance, setting = chance_of(number)
    which = chance.choice([signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
    place = slow(setting)
    if chance.random() < 0.5:
        place.arm(Fault("line", "step", Kind("sleep", "fails"), chance.uniform(0.0, 1.0)))
    with place.running() as running:
        time.sleep(chance.uniform(0.5, 2.0))
        running.send(which)
        done = finished(place, running)
    if done.code == -which:  # the interpreter was ending: all was told, and all rows are there
        assert done.out.endswith("wrote r.nc\n"), done.err
        assert differences(place.results(), campaign.whole(setting), complete=True) == []
    else:
        assert done.code in (0, 1, 128 + which), done.err
    assert place.left_behind(done) == []
    check_left(campaign, setting, place)


@pytest.mark.parametrize("number", range(12))
def test_a_worker_that_is_attacked(
    number: int, campaign: Campaign, slow: Callable[[Setting], Place]
) -> None:
    """Somebody kills or stops a worker: as if the FMU had done it."""
    chance, setting = chance_of(number)
    place = slow(setting)
    which = chance.choice([signal.SIGKILL, signal.SIGSTOP, signal.SIGSEGV])
    with place.running() as running:
        time.sleep(chance.uniform(0.5, 2.0))
        workers = place.workers(running.pid)
        for process in chance.sample(workers, min(1, len(workers))):
            with suppress(ProcessLookupError):  # the run has come to its end
                os.kill(process, which)
        done = finished(place, running)
    assert done.code == 0 or (done.code == 1 and re.search(r"\b(buoy|arm|line)\b", done.err))
    assert place.left_behind(done) == []
    check_left(campaign, setting, place)


@pytest.mark.parametrize("number", range(10))
def test_a_full_disk(number: int, campaign: Campaign, tmp_path: Path) -> None:
    """The run goes on without checkpoints, or ends and says why; with more room it is resumed."""
    chance, setting = chance_of(number)
    with small_disk(tmp_path, 4096 * chance.randint(8, 40)) as is_there:
        if not is_there:
            pytest.skip("no disk can be mounted")
        place = campaign.place(setting, tmp_path)
        done = place.run()
        assert done.code in (0, 1), done.err
        assert done.code == 0 or "disk" in done.err or "space" in done.err
        assert "Traceback" not in done.err
        assert place.left_behind(done) == []
        enlarge(tmp_path, 2**24)
        check_left(campaign, setting, place)


@pytest.mark.parametrize("number", range(4))
def test_a_damaged_checkpoint(number: int, campaign: Campaign, tmp_path: Path) -> None:
    """It is refused, whatever byte is lost or altered; the rows stay."""
    chance, setting = chance_of(number)
    setting = replace(setting, version=max(setting.version, 2), serial=True)
    place = campaign.place(setting, tmp_path)
    place.arm(Fault("arm", "step", Kind("error", "fails"), 1.5))
    assert place.run().code == 1
    place.arm(None)
    checkpoint, results = tmp_path / "r.nc.checkpoint", tmp_path / "r.nc"
    whole, rows = checkpoint.read_bytes(), results.read_bytes()
    for _ in range(8):
        at = chance.randrange(len(whole))
        altered = bytes([whole[at] ^ (1 << chance.randrange(8))])
        damaged = chance.choice([whole[:at], whole[:at] + altered + whole[at + 1 :]])
        checkpoint.write_bytes(damaged)
        done = place.run("--resume")
        assert done.code == 2, done.err
        assert "r.nc.checkpoint" in done.err
        assert "Traceback" not in done.err
        assert results.read_bytes() == rows
        assert checkpoint.read_bytes() == damaged
        assert place.left_behind(done) == []
    checkpoint.write_bytes(whole)
    check_left(campaign, setting, place)


@pytest.mark.parametrize("number", range(6))
def test_locked_results(number: int, campaign: Campaign, slow: Callable[[Setting], Place]) -> None:
    """A second run of the same files is refused, resumed or not; the first comes to its end."""
    chance, setting = chance_of(number)
    place = slow(setting)
    with place.running() as first:
        until(lambda: (place.folder / ".r.nc.m4e-lock").exists())
        second = place.run(*chance.choice([(), ("--resume",)]), words="second")
        done = finished(place, first)
    assert second.code in (1, 2), second.err
    assert "another run" in second.err or "no such file" in second.err
    assert done.code == 0, done.err
    assert place.left_behind(done) == []
    whole = campaign.whole(setting)
    assert differences(place.results(), whole, complete=True) == []
