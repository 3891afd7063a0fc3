"""docs/validation.md says what the tests say; a marker says what its test asserts."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.validation_table import PAGE, MarkerError, page, read_module

MARKER = """\
@pytest.mark.verifies("a period", {source}, tolerance="{tolerance}")
"""
TEST = """\
def test_period():
    assert period() == pytest.approx(2.0, rel=1e-6)
"""


def test_the_page_is_up_to_date(request: pytest.FixtureRequest) -> None:
    """`pytest --update tests/unit/test_validation_table.py` writes it."""
    text = page()
    if request.config.getoption("--update"):
        PAGE.write_text(text, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == text


def module(folder: Path, source: str, tolerance: str) -> Path:
    path = folder / "test_pendulum.py"
    text = '"""Pendulums."""\n\n' + MARKER.format(source=source, tolerance=tolerance) + TEST
    path.write_text(text, encoding="utf-8")
    return path


def test_a_row(tmp_path: Path) -> None:
    found = read_module(module(tmp_path, 'analytic="a closed form"', "1e-6 s"))
    assert (found.title, found.summary) == ("Pendulum", "Pendulums.")
    (claim,) = found.claims
    row = (claim.what, claim.source, claim.kind, claim.tolerance)
    assert row == ("a period", "a closed form", "analytic", "1e-6 s")


@pytest.mark.parametrize(
    ("source", "tolerance", "message"),
    [
        ('analytic="a closed form"', "1e-8 s", "the tolerance '1e-8 s' is not 'identical'"),
        ('analytic="a closed form"', "small", "the tolerance 'small' is not 'identical'"),
        ('somebody="a closed form"', "1e-6", "a marker is verifies"),
        ("analytic=SOLUTION", "1e-6", "a marker is verifies"),
        ('analytic="one", published="two"', "1e-6", "a marker is verifies"),
    ],
)
def test_what_is_refused(tmp_path: Path, source: str, tolerance: str, message: str) -> None:
    with pytest.raises(MarkerError, match=message):
        read_module(module(tmp_path, source, tolerance))


def test_a_file_that_verifies_nothing(tmp_path: Path) -> None:
    path = tmp_path / "test_nothing.py"
    path.write_text(TEST, encoding="utf-8")
    with pytest.raises(MarkerError, match="say what it verifies"):
        read_module(path)
