"""Kinds of FMU that are installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim.system.component import KIND_GROUP, kinds


def test_kinds_are_known_as_soon_as_they_are_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a folder that was looked into before, too."""
    monkeypatch.syspath_prepend(str(tmp_path))
    assert {"table", "sea"} <= set(kinds())
    assert "late" not in kinds()
    info = tmp_path / "late-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: late\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{KIND_GROUP}]\nlate = late.kind\n")
    assert kinds()["late"].value == "late.kind"
    monkeypatch.undo()
    assert "late" not in kinds()
