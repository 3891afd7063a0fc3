"""Files of checkpoints: whole or refused, by one clear error."""

from __future__ import annotations

import hashlib
import os
import pickle
from pathlib import Path

import pytest
from support.small_systems import Fmus, oscillator

from m4e_fmi.cosim import Simulation, run
from m4e_fmi.cosim.run.checkpoint import (
    MAGIC,
    VERSION,
    checkpoint_of,
    read_checkpoint,
    write_checkpoint,
)
from m4e_fmi.errors import InputError, RunError


@pytest.fixture
def file(c_fmu: Fmus, tmp_path: Path) -> Path:
    results = tmp_path / "results.nc"
    settings = Simulation(0.1, 0.05, "jacobi", checkpoint_interval=1.0)
    run(oscillator(c_fmu, settings, "+state+bytes"), results=results, certify=False)
    return checkpoint_of(results)


def test_the_same_content_gives_the_same_bytes(file: Path, tmp_path: Path) -> None:
    saved = read_checkpoint(file).saved
    for name in ("one", "other"):
        write_checkpoint(tmp_path / name, saved)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()


def test_a_file_that_is_cut_off_or_altered_anywhere_is_refused(file: Path) -> None:
    content = file.read_bytes()
    for place in (*range(200), *range(200, len(content), 97)):
        altered = bytearray(content)
        altered[place] ^= 1
        for wrong, match in ((content[:place], r"is (cut off|not a|a)"), (altered, None)):
            file.write_bytes(wrong)
            with pytest.raises(InputError, match=match):
                read_checkpoint(file)
    file.write_bytes(content.replace(b"%d\n" % VERSION, b"%d\n" % (VERSION + 1), 1))
    with pytest.raises(InputError, match=f"form {VERSION + 1}; only {VERSION} is read"):
        read_checkpoint(file)


def test_no_code_of_a_forged_file_is_run(file: Path) -> None:
    content = pickle.dumps(print)
    digest = hashlib.sha256(content).hexdigest().encode()
    file.write_bytes(MAGIC + b"%d\n" % VERSION + digest + b"\n" + content)
    with pytest.raises(InputError, match=r"is damaged: builtins\.print is no dataclass"):
        read_checkpoint(file)


def test_one_that_cannot_be_written_leaves_the_one_before(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, saved = file.read_bytes(), read_checkpoint(file).saved
    names = set(file.parent.iterdir())

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RunError, match="No space left"):
        write_checkpoint(file, saved)
    assert file.read_bytes() == before
    assert set(file.parent.iterdir()) == names
