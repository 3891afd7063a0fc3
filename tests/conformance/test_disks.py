"""Commands on full and read-only disks, and in folders of any name: a message, no debris."""

from __future__ import annotations

import contextlib
import os
import re
import resource
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.errors import RunError
from m4e_fmi.results.results_file import load

PENDULUM = Path(__file__).parents[2] / "examples/double_pendulum/double_pendulum.model.yaml"
SYSTEM = """\
name: alone
components: {pendulum: {model: double_pendulum.model.yaml}}
simulation: {stop_time: 30, step_size: 0.1}
"""
MODEL = PENDULUM.name
TO_DISK = {  # DISK: the folder that cannot be written, WELL: one that can
    "build": ("build", MODEL, "--build-folder", "DISK"),
    "build native": ("build", MODEL, "--native", "--build-folder", "DISK"),
    "build system": ("build", "system.yaml", "--build-folder", "DISK"),
    "simulate": ("simulate", MODEL, "--output-file", "DISK/r.nc"),
    "animate": ("simulate", MODEL, "--output-file", "WELL/r.nc", "--animate", "DISK/a.html"),
    "draw": ("draw", MODEL, "--output-file", "DISK/p.png"),
    "run": ("run", "system.yaml", "--output-file", "DISK/r.nc", "--build-folder", "WELL"),
    "run, built": ("run", "system.yaml", "--output-file", "WELL/r.nc", "--build-folder", "DISK"),
}
SMALL = 2**21
"""Bytes of a disk that takes a part of the results."""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a model and a system, where we are."""
    folder = tmp_path / "project"
    folder.mkdir()
    shutil.copy(PENDULUM, folder)
    (folder / "system.yaml").write_text(SYSTEM)
    monkeypatch.chdir(folder)
    return folder


@contextlib.contextmanager
def mounted(folder: Path, options: str) -> Iterator[None]:
    """A file system of its own; skips where this process may not mount one."""
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    if os.geteuid() or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("no right to mount a file system")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


@contextlib.contextmanager
def full(folder: Path) -> Iterator[str]:
    with mounted(folder, "size=64k"):
        with contextlib.suppress(OSError), (folder / "filler").open("wb") as file:
            for _ in range(100):
                file.write(bytes(1000))
                file.flush()
        yield "free disk space"


@contextlib.contextmanager
def short(folder: Path, size: int = SMALL) -> Iterator[None]:
    """No file may be longer: as a small disk, without the right to mount one."""
    del folder
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextlib.contextmanager
def limited(folder: Path) -> Iterator[str]:
    with short(folder, 1000):
        yield "free disk space"


@contextlib.contextmanager
def read_only(folder: Path) -> Iterator[str]:
    if os.geteuid():
        folder.chmod(0o555)
        yield "a folder that you may write to"
        folder.chmod(0o755)
    else:  # to whom permissions mean nothing
        with mounted(folder, "ro"):
            yield "a folder that you may write to"


@pytest.mark.parametrize("disk", [full, limited, read_only])
@pytest.mark.parametrize("command", TO_DISK.values(), ids=TO_DISK)
def test_a_disk_that_takes_nothing(
    disk, command: tuple[str, ...], project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad, well = project / "bad", project / "well"
    bad.mkdir()
    words = [word.replace("DISK", str(bad)).replace("WELL", str(well)) for word in command]
    with disk(bad) as remedy:
        code = main(words)
        left = {p.name for p in bad.rglob("*") if p.is_file()} - {"filler"}
    error = capsys.readouterr().err
    assert code == 1
    assert re.search("cannot be (written|unpacked): ", error)  # the limit is everywhere
    assert remedy in error
    assert left == set()


@pytest.mark.parametrize("disk", [full, limited, read_only])
def test_that_is_found_before_the_first_step(disk, project: Path) -> None:
    bad, seen = project / "bad", []
    bad.mkdir()
    ready = prepare(load_system("system.yaml"))
    with disk(bad) as remedy, pytest.raises(RunError, match=remedy):
        run(ready, results=bad / "r.nc", observers=[lambda time, _: seen.append(time)])
    assert seen == []


def small(folder: Path) -> contextlib.AbstractContextManager[None]:
    return mounted(folder, f"size={SMALL}")


@pytest.mark.parametrize("disk", [small, short])
def test_a_disk_that_fills_up_during_a_run(
    disk, project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The rows that it took are complete, and the message tells how far they go."""
    place = project / "disk"
    place.mkdir()
    words = ["run", "system.yaml", "--output-file", "disk/r.nc", "--stop-time", "4000"]
    ready = prepare(load_system("system.yaml").changed(stop_time=4000))
    whole = run(ready, results="whole.nc").results()
    with disk(place):
        assert main(words) == 1
        results = load(place / "r.nc")
    count = len(results.time)
    row = 8 * (1 + len(whole.series))
    assert 0.95 * SMALL < row * count < SMALL
    assert results.time.tolist() == whole.time[:count].tolist()
    for name, series in whole.series.items():
        assert results[name].values.tobytes() == series.values[:count].tobytes()
    assert re.match(r"failed: \S+r\.nc: cannot be written: ", results.attributes["ended"])
    error = capsys.readouterr().err
    assert f"results until t = {results.time[-1]:.9g} s are in disk/r.nc" in error


def test_a_csv_that_is_not_taken_at_the_end(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The run is done: its summary is there, and it is said where the results are."""
    words = ["run", "system.yaml", "--output-file", "r.csv", "--stop-time", "300"]
    assert main([*words[:-1], "1"]) == 0  # builds the FMU
    assert (project / "r.csv").is_file()
    capsys.readouterr()
    with short(project):
        assert main(words) == 1
    told = capsys.readouterr()
    assert not (project / "r.csv").exists()  # of an earlier run, beside results of this one
    assert len(load("r.nc").time) == 3001
    assert load("r.nc").attributes["ended"] == "at the stop time"
    assert "wrote r.nc" in told.out
    assert told.out.endswith("wrote r.nc\n")
    assert "r.csv: cannot be written: " in told.err
    assert "the results are complete in r.nc (3,001 rows); r.csv is not written" in told.err
