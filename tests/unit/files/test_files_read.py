"""Files that are read: no more than a limit, and a record of their contents."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.files.files_read import TooLongError, are_unchanged, files_read, read_bytes


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
