"""Reports in a browser: opened, and drawn."""

from __future__ import annotations

import time as clock
from pathlib import Path

from support.browser import Page

LONGEST_OPENING = 20.0
"""Seconds: ten times what is aimed at, for a machine that others use at the same time."""


def opened(page: Page, path: Path) -> float:
    """Show a report; milliseconds until the first plot was there. All plots and animation are."""
    page.complaints.clear()
    page.requests.clear()
    page.open(path)
    end = clock.monotonic() + LONGEST_OPENING
    while not page.value("globalThis.report !== undefined && (report.player || !report.moves)"):
        assert clock.monotonic() < end, page.complaints
        clock.sleep(0.05)
    return page.value("performance.getEntriesByName('plot drawn')[0].startTime")


def settled(page: Page) -> None:
    """Wait until what was asked for is drawn: timers of 120 ms, and two frames."""
    page.value("new Promise(done => setTimeout(() => requestAnimationFrame(() => "
               "requestAnimationFrame(done)), 250))")  # fmt: skip
