"""The command line in tests: copies of examples, and commands that are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"


PENDULUM = EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml"


FLEXIBLE = EXAMPLES / "flexible_pendulum"


def copied(folder: Path, source: Path, *changes: tuple[str, str]) -> Path:
    """A copy of an example's file with texts replaced."""
    text = source.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / source.name
    path.write_text(text, encoding="utf-8")
    return path


def refused(capsys: pytest.CaptureFixture, *arguments: object) -> str:
    """Standard error of a command that must end with exit code 2 and no traceback."""
    assert main([str(a) for a in arguments]) == 2
    text = capsys.readouterr().err
    assert "Traceback" not in text
    return text
