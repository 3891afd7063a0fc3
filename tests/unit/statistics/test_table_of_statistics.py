"""The table of statistics in the docs is made from the registry."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.statistics import STATISTICS, Statistic

PAGE = Path(__file__).parents[3] / "docs" / "statistics.md"
HEAD = "| statistic | definition | unit, of values in m | parameters |\n|---|---|---|---|\n"


def row(one: Statistic) -> str:
    given = ", ".join(
        f"`{name}`" if default is None else f"`{name}={default:g}`"
        for name, default in one.parameters.items()
    )
    return f"| `{one.name}` | {one.text} | {one.unit('m')} | {given} |\n"


def test_the_docs_have_all_statistics(request: pytest.FixtureRequest) -> None:
    text = PAGE.read_text("utf-8")
    start = text.index(HEAD)
    rows = "".join(row(one) for one in STATISTICS.values())
    expected = text[:start] + HEAD + rows + text[text.index("\n\n", start) + 1 :]
    if request.config.getoption("--update"):
        PAGE.write_text(expected, encoding="utf-8")
        text = expected
    assert text == expected
