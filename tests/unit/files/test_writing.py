"""Files that appear whole or not at all: leftovers of killed processes, builds at one time."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from m4e_fmi.errors import RunError
from m4e_fmi.files import writing
from m4e_fmi.files.writing import part_prefix, remove_leftovers, written
from m4e_fmi.fmu.export.archive import write_archive
from m4e_fmi.fmu.export.build_record import BuildRecord, read_record, write_record
from m4e_fmi.runtime.compiler import cached_shared

KILLED = """
import os, sys, tempfile
from pathlib import Path
from m4e_fmi.files.writing import part_prefix, written
tempfile.mkdtemp(prefix=part_prefix(), dir=sys.argv[1])
with written(Path(sys.argv[1], "a.fmu")) as part:
    part.write_bytes(b"half")
    print(flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def writer(tmp_path: Path):
    """A process that is within writing a.fmu to the folder `tmp_path`."""
    command = [sys.executable, "-c", KILLED, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield process
        process.kill()


def test_what_a_killed_process_leaves_is_removed(writer: subprocess.Popen, tmp_path: Path) -> None:
    """And nothing while it lives; no part of a file ever has the file's name."""
    (tmp_path / ".part-mine").write_text("of somebody else")
    before = {path.name for path in tmp_path.iterdir()}
    assert len(before) == 3
    assert "a.fmu" not in before
    remove_leftovers(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == before
    writer.kill()
    writer.wait()
    remove_leftovers(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".part-mine"]


def test_what_other_machines_left_is_removed_after_a_day(tmp_path: Path) -> None:
    parts = [tmp_path / f".part-00000000-{k}-x.fmu" for k in (1, 99999999)]
    for part in parts:
        part.write_text("")
    remove_leftovers(tmp_path)
    assert all(part.exists() for part in parts)
    for part in parts:
        os.utime(part, times=(time.time() - 90_000, time.time() - 90_000))
    remove_leftovers(tmp_path)
    assert not list(tmp_path.iterdir())
    remove_leftovers(tmp_path / "none")


def test_builds_at_one_time_leave_a_record_that_fits_or_none(tmp_path: Path) -> None:
    """However the files of two builds come one after the other."""
    fmu = tmp_path / "a.fmu"
    for last in (1, 2):
        contents = {k: write_archive({"x": bytes([k])}, fmu) for k in (3 - last, last)}
        for order in ((1, 2), (2, 1)):
            for k in order:
                write_record(fmu, BuildRecord(fmu=contents[k], made_from=str(k)))
            record = read_record(fmu)
            assert (record and record.made_from) == (str(last) if order[-1] == last else None)


def test_a_file_that_is_open_elsewhere_gets_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On Windows, which does not replace it."""
    tried = []
    replace = Path.replace

    def locked(self: Path, target: Path) -> Path:
        tried.append(target)
        if len(tried) < 3:
            raise PermissionError(13, "it is open")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", locked)
    with pytest.raises(RunError, match="it is open"), written(tmp_path / "a") as part:
        part.write_text("x")
    assert len(tried) == 1
    monkeypatch.setattr(writing, "sys", SimpleNamespace(platform="win32"))
    tried.clear()
    with written(tmp_path / "a") as part:
        part.write_text("x")
    assert len(tried) == 3
    monkeypatch.setattr(writing, "_PATIENCE", 0.0)
    tried.clear()
    with pytest.raises(RunError, match="it is open"), written(tmp_path / "a") as part:
        part.write_text("y")
    assert (tmp_path / "a").read_text() == "x"
    assert len(list(tmp_path.iterdir())) == 1


def test_another_version_of_the_compiler_compiles_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path / "cache"))
    compiler = tmp_path / "our-cc"
    compiler.write_text('#!/bin/sh\nexec cc "$@"\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    source = "double m4e_one(void);\ndouble m4e_one(void) { return 1.; }"
    first = cached_shared("one", [], source)
    assert cached_shared("one", [], source) == first
    compiler.write_text('#!/bin/sh\n# newer\nexec cc "$@"\n')
    assert cached_shared("one", [], source) != first


@pytest.mark.skipif(sys.platform != "linux", reason="containers of Linux")
def test_files_of_another_container_are_left_alone(tmp_path: Path) -> None:
    """Its processes have other numbers, even where it has the name of the machine."""
    part = tmp_path / f"{part_prefix()}0.nc"
    part.touch()
    code = (
        "import sys; from pathlib import Path; from m4e_fmi.files.writing import remove_leftovers;"
        "remove_leftovers(Path(sys.argv[1]))"
    )
    contained = ["unshare", "--fork", "--pid", "--mount-proc"]
    try:
        subprocess.run([*contained, "true"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no containers can be made here")
    subprocess.run([*contained, sys.executable, "-c", code, str(tmp_path)], check=True)
    assert part.exists()
