"""The report of 10,000 samples: its size, how fast it opens, and that every run is drawn."""

from __future__ import annotations

import re
import time as clock
from pathlib import Path

import pytest
from support.browser import CHROMIUM, browser
from support.report_pages import opened, settled
from support.written_study import samples

from m4e_fmi.study.report.of_study import report_of_study

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
MANY, LARGEST = 10_000, 6e6
"""Runs, and bytes of their report."""
LONGEST = 20.0
"""Seconds of each step, ten times the aim, for a machine that others use at the same time."""
SOFTWARE = ("WebGL", "swiftshader")
"""Words of what Chromium says where it has no graphics card."""


def test_many_samples_are_small_and_drawn(tmp_path: Path) -> None:
    result = samples(tmp_path, MANY)
    began = clock.monotonic()
    path = report_of_study(result, tmp_path / "r.html")
    made = clock.monotonic() - began
    assert path.stat().st_size < LARGEST
    with browser(tmp_path / "browser") as page:
        first = opened(page, path) / 1000
        began = clock.monotonic()
        page.value("report.scatter.draw()")
        scatter = clock.monotonic() - began
        settled(page)
        print(f"{path.stat().st_size / 1e6:.2f} MB, {made=}, {first=}, {scatter=} s")
        assert max(made, first, scatter) < LONGEST
        points, failed = page.value(
            "document.querySelector('#scatter .chart').data"
            ".map(({ type, x, name }) => ({ type, x, name }))"
        )
        assert page.value("document.querySelector('.no-webgl')") is None, points["type"]
        assert len(points["x"]) == MANY - MANY // 100
        assert (failed["name"], len(failed["x"])) == ("failed", MANY // 100)
        told = page.value("document.querySelector('#scatter .told').textContent")
        assert re.match(r"9,900 runs. 100 failed runs are marked ✕", told)
        assert [one for one in page.complaints if not any(word in one for word in SOFTWARE)] == []
