"""Files of checkpoints: whole or refused, by one clear error."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim.run.checkpoint import (
    MAGIC,
    VERSION,
    read_checkpoint,
    write_checkpoint,
)
from m4e_fmi.errors import InputError, RunError


@dataclass
class Part:
    """A part of a checkpoint."""

    name: str
    values: np.ndarray


PARTS = {"one": Part("first", np.arange(5.0)), "two": Part("second", np.zeros((2, 2)))}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "results.nc.checkpoint"
    write_checkpoint(path, PARTS)
    return path


def test_parts_come_back_by_name(file: Path, tmp_path: Path) -> None:
    """The same content gives the same bytes."""
    parts = read_checkpoint(file)
    for name, given in PARTS.items():
        found = parts.part(name, Part)
        assert (found.name, found.values.tobytes()) == (given.name, given.values.tobytes())
    write_checkpoint(tmp_path / "again", PARTS)
    assert (tmp_path / "again").read_bytes() == file.read_bytes()


def test_a_file_that_is_cut_off_or_altered_anywhere_is_refused(file: Path) -> None:
    content = file.read_bytes()
    for place in range(len(content)):
        altered = bytearray(content)
        altered[place] ^= 1
        for wrong, match in ((content[:place], r"is (cut off|not a|a)"), (altered, None)):
            file.write_bytes(wrong)
            with pytest.raises(InputError, match=match):
                read_checkpoint(file)
    file.write_bytes(content.replace(b"%d\n" % VERSION, b"%d\n" % (VERSION + 1), 1))
    with pytest.raises(InputError, match=f"form {VERSION + 1}; only {VERSION} is read"):
        read_checkpoint(file)


def signed(content: bytes) -> bytes:
    """A file of this content, with the right checksum."""
    digest = hashlib.sha256(content).hexdigest().encode()
    return MAGIC + b"%d\n" % VERSION + digest + b"\n" + content


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no number\n{}",
        b"-1\n{}",
        b"3\n{}",
        b"2\n[]",
        b"2\n{]",
        b"99999999999999999999999999\n{}",
        b"200000\n" + b"[" * 200000,
        b'12\n{"one":[{}]}',
        b"2\n\xff\xff",
        b'11\n{"one":[0]}',
        b'13\n{"one":[0,9]}' + bytes(9),
        b'13\n{"one":[9,9]}' + bytes(9),
    ],
)
def test_a_forged_file_is_refused_without_a_traceback(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "forged.checkpoint"
    path.write_bytes(signed(content))
    with pytest.raises(InputError, match="is damaged"):
        read_checkpoint(path).part("one", Part)


def test_one_that_cannot_be_written_leaves_the_one_before(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = file.read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RunError, match="No space left"):
        write_checkpoint(file, {"one": PARTS["two"]})
    assert file.read_bytes() == before
    assert {one.name for one in file.parent.iterdir()} - {"unpacked"} == {file.name}
