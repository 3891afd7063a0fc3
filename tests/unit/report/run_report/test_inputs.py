"""Input files in records: short ones with their texts, all with their SHA-256."""

from __future__ import annotations

import hashlib
from pathlib import Path

from m4e_fmi.report.run_report.inputs import input_file
from m4e_fmi.report.run_report.record import LONGEST


def test_a_long_file_is_told_by_its_sum(tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    for count, text in ((LONGEST, LONGEST * "x"), (LONGEST + 1, None)):
        path.write_bytes(count * b"x")
        found = input_file(path, "a name")
        assert found is not None
        assert (found.name, found.text) == ("a name", text)
        assert found.sha256 == hashlib.sha256(count * b"x").hexdigest()
    found = input_file(path, "a name", kept=False)
    assert found is not None
    assert found.text is None


def test_what_is_no_text_and_what_is_no_file(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(b"a\xff\r\n\0")
    found = input_file(path, "x")
    assert found is not None
    assert found.text == "a\ufffd\n\0"
    assert input_file(tmp_path, "folder") is None
    assert input_file(tmp_path / "gone", "gone") is None
    assert input_file(Path("a\0b"), "no name") is None
