"""Files that are read: no more than a limit, and a record of their contents."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cosim.run.checkpoint import read_checkpoint
from m4e_fmi.cosim.ssp import read_parameter_set
from m4e_fmi.cosim.ssp.package import Package
from m4e_fmi.errors import InputError
from m4e_fmi.files.csv_columns import read_columns
from m4e_fmi.files.document import Document
from m4e_fmi.files.files_read import (
    UNREADABLE,
    TooLongError,
    are_unchanged,
    file_hash,
    files_read,
    read_bytes,
)
from m4e_fmi.fmu.importer.opening import check_archive
from m4e_fmi.results.results_file import load, rows_of


def test_a_file_is_read_up_to_the_limit_and_not_a_byte_beyond(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"1234")
    assert read_bytes(path, largest=4) == b"1234"
    with pytest.raises(TooLongError, match="is longer than 3e-06 MB"):
        read_bytes(path, largest=3)


def test_a_file_that_changes_between_two_readings_is_never_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"first")
    with files_read() as files:
        read_bytes(path)
        path.write_bytes(b"second")
        read_bytes(path)
    assert not are_unchanged(files)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes in folders")
def test_a_pipe_in_a_folder_is_refused_and_one_of_the_shell_read(tmp_path: Path) -> None:
    """Opening the first would wait until somebody writes to it."""
    pipe = tmp_path / "model.yaml"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="a pipe, not a file"):
        read_bytes(pipe)
    (tmp_path / "link.yaml").symlink_to(pipe)
    with pytest.raises(OSError, match="a pipe, not a file"):
        read_bytes(tmp_path / "link.yaml")
    assert file_hash(pipe) == UNREADABLE
    ours, theirs = os.pipe()
    os.write(theirs, b"name: a")
    os.close(theirs)
    assert read_bytes(f"/dev/fd/{ours}") == b"name: a"
    os.close(ours)


READERS: dict[str, Callable[[Path], object]] = {
    "m.yaml": Document.load,
    "t.csv": lambda path: read_columns(path, [(0, "s")]),
    "f.fmu": check_archive,
    "s.ssp": Package,
    "p.ssv": read_parameter_set,
    "r.nc": load,
    "again.nc": lambda path: list(rows_of(path, (), 1, int)),
    "r.nc.checkpoint": read_checkpoint,
}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes in folders")
@pytest.mark.parametrize("name", READERS)
def test_a_pipe_in_place_of_a_file_is_named(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=rf"{name}: .*is a pipe"):
        READERS[name](tmp_path / name)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="a device without end")
@pytest.mark.parametrize(("name", "limit"), [("m.yaml", 10), ("p.ssv", 50)])
def test_a_file_without_end_is_read_up_to_a_limit(name: str, limit: int, tmp_path: Path) -> None:
    (tmp_path / name).symlink_to("/dev/zero")
    with pytest.raises(InputError, match=rf"{name}.* is longer than {limit} MB"):
        READERS[name](tmp_path / name)
