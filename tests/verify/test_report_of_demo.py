"""The report of the demo: its size, how fast it opens, and the picture of it in the docs."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest
from support.browser import CHROMIUM, Page, browser
from support.report_pages import opened
from support.reports import results_of

from m4e_fmi.cli import main
from m4e_fmi.report import report_of_run

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
ROOT = Path(__file__).parents[2]
DEMO, PICTURE = ROOT / "examples/moored_buoy/system.yaml", ROOT / "docs/report.png"
LARGEST = 6e6
"""Bytes of the demo's report."""
AIM = 2.0
"""Seconds until the first plot is drawn, the second time that a browser opens a page."""


def opening(page: Page, path: Path) -> float:
    """Seconds until the first plot was drawn, of the best of three times."""
    found = []
    for _ in range(3):
        found.append(opened(page, path) / 1000)
        assert page.complaints == []
    print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB, first plot after {found} s")
    return min(found)


def test_the_demo(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    path = tmp_path / "demo.html"
    files = ["--output-file", str(tmp_path / "r.nc"), "--build-folder", str(tmp_path)]
    assert main(["run", str(DEMO), *files, "--report", str(path)]) == 0
    assert path.stat().st_size <= LARGEST
    with browser(tmp_path / "browser") as page:
        assert opening(page, path) <= AIM
        if request.config.getoption("--update"):
            _take_picture(page)
        assert page.complaints == []


def _take_picture(page: Page) -> None:
    """Plots and animation of the demo at 321 s, each with the other's time."""
    page.call("Emulation.setDeviceMetricsOverride", width=1100, height=1000, deviceScaleFactor=1,
              mobile=False)  # fmt: skip
    page.value("new Promise(done => setTimeout(done, 1000))")
    page.value(
        "for (const panel of report.plots.panels.slice(3).reverse()) report.plots.close(panel);"
        "document.querySelector('.dock').click();"
        "document.querySelector('.groups').style.maxHeight = '330px';"
        "document.querySelector('.groups details').open = true;"
        "report.plots.range = [280, 400]; report.player.seek(321);"
        "document.querySelector('#histories').scrollIntoView(); document.activeElement.blur();"
        "new Promise(done => setTimeout(done, 1000))"
    )
    shot = page.call("Page.captureScreenshot", format="png")
    PICTURE.write_bytes(base64.b64decode(shot["data"]))


def test_noise_of_three_million_numbers_opens_as_fast(tmp_path: Path) -> None:
    time, random = 0.05 * np.arange(100_000), np.random.default_rng(1)
    values = {f"noise.n{k}": random.normal(size=100_000) for k in range(30)}
    path = report_of_run(results_of(time, values), tmp_path / "noise.html")
    with browser(tmp_path / "browser") as page:
        assert opening(page, path) <= AIM
