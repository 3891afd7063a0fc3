"""Builds that are killed at any time, and many at one time: a whole FMU or none, results right."""

from __future__ import annotations

import json
import os
import random
import signal
import time
import traceback
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.flow import cache
from m4e_fmi.cosim import fmu_files, load_system, prepare, run
from m4e_fmi.errors import M4eError, RunError
from m4e_fmi.fmu.export.build_record import read_record
from m4e_fmi.runtime.compiler import cached_shared

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are made by fork")
KILLS, PROCESSES, ROUNDS = 400, 8, 25
SYSTEM = {
    "name": "s",
    "components": {
        "level": {"kind": "table", "file": "level.csv", "signals": {"y": "m"}, "between": "held"},
        "mass": {"model": "mass.model.yaml"},
    },
    "simulation": {"stop_time": 1, "step_size": 0.5},
}
MODEL = {
    "name": "mass",
    "gravity": 0,
    "bodies": {"m": {"mass": 1, "inertia": 1}},
    "joints": {"slide": {"type": "prismatic", "child": "m", "direction": [1, 0]}},
    "tables": {"pull": {"file": "pull.csv", "unit": "N"}},
    "loads": {"pull": {"type": "joint_effort", "joint": "slide", "effort": "pull"}},
}


def project(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "system.yaml").write_text(json.dumps(SYSTEM))
    (folder / "mass.model.yaml").write_text(json.dumps(MODEL))
    change(folder, 1.0)
    return folder


def change(folder: Path, level: float) -> None:
    """Tables of this value; each file is replaced as a whole, as editors do."""
    for name in ("level", "pull"):
        new = folder / f"{name}.new"
        header = "time,y" if name == "level" else "time,force"
        new.write_text(f"{header}\n0,{level}\n10,{level}\n")
        new.replace(folder / f"{name}.csv")


def results(folder: Path, build: Path, name: str) -> tuple[float, float]:
    """Level and position at 1 s: the position is half the force."""
    system = prepare(load_system(folder / "system.yaml"), build_directory=build)
    found = run(system, results=build / f"{name}.nc", certify=False).results()
    return float(found["level.y"].values[-1]), float(found["mass.body.m.x"].values[-1])


def child(work: Callable[[], None]) -> int:
    """The process that does `work` and ends with 0, or with 1 and its traceback."""
    process = os.fork()
    if process == 0:
        try:
            work()
            os._exit(0)
        except (AssertionError, M4eError, OSError):
            traceback.print_exc()
        finally:
            os._exit(1)
    return process


def killed(work: Callable[[], None], after: float) -> None:
    process = child(work)
    time.sleep(after)
    os.kill(process, signal.SIGKILL)
    status = os.waitpid(process, 0)[1]
    assert os.WIFSIGNALED(status), status


def check_whole(folder: Path) -> int:
    """How many FMUs there are; all can be read to the last byte."""
    fmus = list(folder.glob("*.fmu"))
    for fmu in fmus:
        if not fmu.name.startswith("."):
            with zipfile.ZipFile(fmu) as archive:
                assert archive.testzip() is None
    return len(fmus)


def test_builds_that_are_killed(tmp_path: Path) -> None:
    chance = random.Random(seed := 1)
    folder, build = project(tmp_path / "p"), tmp_path / "b"
    fmu_files(load_system(folder / "system.yaml"), build)
    system = load_system(folder / "system.yaml")

    def work() -> None:
        level = 0.0
        while True:
            level += 1.0
            change(folder, level)
            fmu_files(system, build)

    found: Counter[str] = Counter()
    for k in range(KILLS):
        killed(work, chance.uniform(0.0, 0.3))
        check_whole(build / "s")
        parts = list((build / "s").glob(".part-*"))
        fits = [read_record(build / "s" / f"{name}.fmu") for name in ("level", "mass")]
        found["left parts"] += bool(parts)
        found["without record"] += None in fits
        level = 1000.0 + k
        change(folder, level)
        fmu_files(system, build)
        assert not list((build / "s").glob(".part-*"))
        assert all(read_record(build / "s" / f"{name}.fmu") for name in ("level", "mass"))
        if k % 20 == 0:
            assert results(folder, build, "r") == pytest.approx((level, level / 2), rel=1e-6)
    print(f"seed {seed}: {KILLS} kills, {dict(found)}")
    assert found["left parts"] > 0
    assert found["without record"] > 0


def test_cached_coefficients_whose_writer_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(cache.ENVIRONMENT, str(tmp_path))
    chance = random.Random(seed := 2)
    arrays = {"a": np.random.default_rng(3).normal(size=300_000)}

    def work() -> None:
        while True:
            cache.keep("k", arrays, print)

    begun = time.perf_counter()
    cache.keep("k", arrays, print)
    longest = 3 * (time.perf_counter() - begun)  # kills fall into the writing on any machine
    found: Counter[str] = Counter()
    for _ in range(KILLS):
        killed(work, chance.uniform(0.0, longest))
        loaded = cache.found("k", print)
        found["parts"] += len(list((tmp_path / "hydrodynamics").glob(".part-*")))
        found["nothing"] += loaded is None
        if loaded is not None:
            assert (loaded["a"] == arrays["a"]).all()
            next((tmp_path / "hydrodynamics").glob("k.*")).unlink()
    cache.keep("k", arrays, print)
    assert len(list((tmp_path / "hydrodynamics").iterdir())) == 1
    print(f"seed {seed}: {KILLS} kills, {dict(found)}")
    assert found["parts"] > 0


def test_compilations_that_are_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Entries of the cache can be loaded; leftovers of the dead are gone after the next one."""
    monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path))
    chance = random.Random(seed := 4)

    def source(k: int) -> str:
        return f"double m4e_one(void);\ndouble m4e_one(void) {{ return {k}.0; }}"

    def work() -> None:
        k = 0
        while True:
            k += 1
            cached_shared("one", [], source(k))

    for _ in range(KILLS // 10):
        killed(work, chance.uniform(0.0, 0.5))
    import ctypes

    libraries = [path for path in tmp_path.iterdir() if path.is_file()]
    for library in libraries:
        ctypes.CDLL(str(library))
    cached_shared("one", [], source(-1))
    assert not list(tmp_path.glob(".part-*"))
    print(f"seed {seed}: {KILLS // 10} kills, {len(libraries)} libraries")


def all_end(works: list[Callable[[], None]]) -> None:
    processes = [child(work) for work in works]
    assert [os.waitpid(process, 0)[1] for process in processes] == [0] * len(works)


def test_many_builds_of_one_system_at_one_time(tmp_path: Path) -> None:
    folder = project(tmp_path / "p")
    for k in range(ROUNDS):
        change(folder, float(k))

        def work(k: int = k) -> None:
            found = results(folder, tmp_path / "b", f"r{os.getpid()}")
            assert found == pytest.approx((k, k / 2), rel=1e-6), found

        all_end([work] * PROCESSES)
        assert check_whole(tmp_path / "b" / "s") == 2
        assert not list((tmp_path / "b" / "s").glob(".part-*"))


def test_many_systems_of_one_name_in_one_build_folder(tmp_path: Path) -> None:
    """Each result is right, or the run says that another took the place of its FMU."""
    folders = [project(tmp_path / f"p{k}") for k in range(PROCESSES)]
    for k, folder in enumerate(folders):
        change(folder, float(k + 1))
    journal = tmp_path / "journal"

    def work(k: int) -> None:
        for _ in range(ROUNDS):
            try:
                found = results(folders[k], tmp_path / "b", f"r{k}")
            except RunError as error:
                word = "replaced" if "was replaced by another FMU" in error.message else str(error)
            else:
                assert found == pytest.approx((k + 1, (k + 1) / 2), rel=1e-6), found
                word = "right"
            with journal.open("a") as file:
                file.write(f"{word}\n")

    all_end([lambda k=k: work(k) for k in range(PROCESSES)])
    found = Counter(journal.read_text().splitlines())
    print(dict(found))
    assert set(found) <= {"right", "replaced"}
    assert check_whole(tmp_path / "b" / "s") == 2


def test_many_processes_share_cached_coefficients(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(cache.ENVIRONMENT, str(tmp_path))
    arrays = {"a": np.random.default_rng(5).normal(size=50_000)}

    def work() -> None:
        for k in range(ROUNDS):
            cache.keep(f"k{k % 3}", arrays, print)
            loaded = cache.found(f"k{(k + 1) % 3}", print)
            assert loaded is None or (loaded["a"] == arrays["a"]).all()

    all_end([work] * PROCESSES)
    assert len(list((tmp_path / "hydrodynamics").iterdir())) == 3
