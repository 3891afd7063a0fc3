"""The limits of input files: those of the docs, and far beyond the largest example."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.files import limits
from m4e_fmi.files.limits import LIMITS, MB

ROOT = Path(__file__).parents[3]
HEAD = "| file | limited | at most | why |\n|---|---|---|---|\n"


def shown(most: int, unit: str) -> str:
    if unit == "bytes" and most >= MB:
        return f"{most // MB:,} MB"
    return f"{most:,} {unit}".strip()


def test_the_docs_have_the_limits(request: pytest.FixtureRequest) -> None:
    page = ROOT / "docs" / "safety.md"
    text = page.read_text("utf-8")
    rows = "".join(
        f"| {one.file} | {one.what} | {shown(one.most, one.unit)} | {one.reason} |\n"
        for one in LIMITS
    )
    start = text.index(HEAD)
    expected = text[:start] + HEAD + rows + text[text.index("\n\n", start) + 1 :]
    if request.config.getoption("--update"):
        page.write_text(expected, encoding="utf-8")
        text = expected
    assert text == expected


def test_all_limits_are_in_the_table() -> None:
    named = {value for name, value in vars(limits).items() if name.isupper() and name != "LIMITS"}
    assert named - {one.most for one in LIMITS} <= {limits.MB, limits.SMALL}
