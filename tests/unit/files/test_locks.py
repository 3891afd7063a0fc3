"""Claims of files, and what dead processes leave; a living one's is never touched."""

from __future__ import annotations

import errno
import re
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from m4e_fmi.errors import RunError
from m4e_fmi.files.locks import TemporaryFolder, claimed
from m4e_fmi.signals import handled

HOLDER = """\
import sys
from pathlib import Path
from m4e_fmi.files.locks import claimed
from m4e_fmi.files.locks import TemporaryFolder
with claimed(sys.argv[1]) as place, TemporaryFolder(place.parent) as folder:
    (folder / "file").touch()
    place.with_name(f".{place.name}.m4e-rows").touch()
    print(flush=True)
    sys.stdin.read()
"""


@contextmanager
def holder(path: Path) -> Iterator[subprocess.Popen]:
    """A process that claims `path` and has a temporary folder beside it."""
    command = [sys.executable, "-c", HOLDER, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield process


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_what_a_living_process_has_is_left_and_a_dead_ones_removed(tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    with holder(path) as process:
        before = names(tmp_path)
        assert len(before) == 4
        with pytest.raises(RunError, match=rf"another run writes it \(process {process.pid} on"):
            claimed(path).__enter__()
        with claimed(tmp_path / "other.nc"), TemporaryFolder(tmp_path):
            assert before < names(tmp_path)
        assert names(tmp_path) == before
        process.kill()
    assert names(tmp_path) == before
    with holder(tmp_path / "other.nc") as process:
        now = names(tmp_path)
        assert len(now) == 4  # a lock for each, the folder, and the rows
        assert not before & now
        process.communicate()
    assert names(tmp_path) == set()


@pytest.mark.skipif(sys.platform == "win32", reason="locks of POSIX")
def test_without_locks_nothing_of_others_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*_: object) -> None:
        raise OSError(errno.ENOLCK, "no locks available")

    monkeypatch.setattr("fcntl.flock", none)
    with holder(tmp_path / "r.nc"):
        before = names(tmp_path)
        with claimed(tmp_path / "other.nc"), TemporaryFolder(tmp_path):
            assert before < names(tmp_path)
        assert names(tmp_path) == before


def test_one_thread_at_a_time(tmp_path: Path) -> None:
    told: list[str] = []

    def claim() -> None:
        try:
            with claimed(tmp_path / "sub" / ".." / "r.nc"):
                told.append("claimed")
        except RunError as error:
            told.append(error.message)

    with claimed(tmp_path / "r.nc"), claimed(tmp_path / "r.nc"):  # again, in the same thread
        thread = threading.Thread(target=claim)
        thread.start()
        thread.join()
    claim()
    assert re.search(r"r\.nc: another run writes it", told[0])
    assert told[1] == "claimed"


def test_temporary_folders_are_removed_with_the_last_reference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    one, other = TemporaryFolder(), TemporaryFolder()
    assert len(names(tmp_path)) == 4
    (one.path / "file").touch()
    one.remove()
    one.remove()
    assert names(tmp_path) == {other.path.name, f"{other.path.name}.lock"}
    del other
    assert names(tmp_path) == set()


def test_many_processes_take_locks_while_others_sweep(tmp_path: Path) -> None:
    code = (
        "import sys\nfrom pathlib import Path\nfrom m4e_fmi.files.locks import claimed\n"
        "from m4e_fmi.files.locks import TemporaryFolder\n"
        "here, name = Path(sys.argv[1]), sys.argv[2]\n"
        "for _ in range(200):\n"
        "    with TemporaryFolder(here) as folder, claimed(here / name):\n"
        "        assert folder.is_dir()\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    running = [subprocess.Popen([*command, f"r{k}.nc"]) for k in range(3)]
    assert [process.wait(60) for process in running] == [0, 0, 0]
    assert not list(tmp_path.iterdir())


def test_ctrl_c_while_a_folder_is_made_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = Path.mkdir

    def struck(self: Path, *arguments: Any, **options: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        usual(self, *arguments, **options)

    monkeypatch.setattr(Path, "mkdir", struck)
    with handled([signal.SIGINT], signal.default_int_handler), pytest.raises(KeyboardInterrupt):
        TemporaryFolder(tmp_path)  # also where Ctrl-C is ignored, as in the background of a shell
    assert names(tmp_path) == set()
