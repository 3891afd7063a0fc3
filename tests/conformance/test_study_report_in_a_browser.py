"""Reports of studies in a real browser: maps, curves, scatter, table, histories; light, narrow."""

from __future__ import annotations

import base64
import csv
import io
from pathlib import Path

import numpy as np
import pytest
from support.browser import CHROMIUM, Page
from support.report_pages import opened, settled
from support.written_study import DAMPINGS, EVIL, HEIGHTS, PERIODS, SEEDS, matrix, power, samples

from m4e_fmi.study.report.of_study import report_of_study

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")


@pytest.fixture(scope="module")
def sea(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a power matrix with failed runs."""
    folder = tmp_path_factory.mktemp("sea")
    return report_of_study(matrix(folder), folder / "r.html")


@pytest.fixture(scope="module")
def shown(page: Page, sea: Path) -> Page:
    """The page with that report, for tests that leave the form of its maps as it is."""
    opened(page, sea)
    return page


def choose(page: Page, selector: str, value: object) -> None:
    page.choose(selector, value)
    settled(page)


def traces(page: Page, keys: str, selector: str = "#results .chart") -> list[dict]:
    """Some entries of the traces of a plot."""
    return page.value(
        f"document.querySelector('{selector}').data.map(({{{keys}}}) => ({{{keys}}}))"
    )


def mean(i: int, j: int, k: int) -> float:
    return float(np.mean([power(HEIGHTS[i], PERIODS[j], DAMPINGS[k], s) for s in range(SEEDS)]))


def test_a_map_has_means_and_marks_what_failed(shown: Page, sea: Path) -> None:
    page = shown
    heat, written, failed = traces(page, "type, z, x, y, text, customdata, name, textfont")
    assert heat["type"] == "heatmap"
    assert np.shape(heat["z"]) == (3, 4)  # Hs up, Tp across
    assert heat["z"][0][1] == pytest.approx(mean(0, 1, 0) / 1e3)
    assert heat["z"][2][0] is None
    texts = dict(zip(zip(written["x"], written["y"], strict=True), written["text"], strict=True))
    assert texts[1, 2].endswith("*")
    assert set(texts) == {(i, j) for i in range(4) for j in range(3)} - {(0, 2)}
    colours = written["textfont"]["color"]
    values = [heat["z"][j][i] for i, j in texts]
    assert colours[int(np.argmin(values))] == "#ffffff"  # on the dark end
    assert colours[int(np.argmax(values))] == "#000000"
    head = page.value("document.querySelector('#results .panel strong').textContent")
    assert head == "mean_power [kW]"
    assert "±" in heat["customdata"][0][1][0]
    assert "3 of 3 runs" in heat["customdata"][0][1][0]
    assert (failed["name"], failed["x"], failed["y"]) == ("failed", [0], [2])
    assert "3 failed: buoy at t = 3 s: &lt;img" in failed["customdata"][0][0]
    cells = page.value("document.querySelectorAll('#results .chart .heatmaplayer image').length")
    assert cells >= 1
    assert page.value("document.querySelectorAll('img').length") == 0
    assert EVIL in page.value("document.querySelector('h1').textContent")
    assert page.complaints == []
    assert page.requests == [sea.absolute().as_uri()]


def test_keys_choose_a_design_and_its_run(shown: Page) -> None:
    page = shown
    page.value("document.querySelector('#results .chart').focus()")
    for key in ("ArrowRight", "ArrowUp", "ArrowUp", "Enter"):
        page.press(key)
    settled(page)
    told = page.value("document.querySelector('#results .cell').textContent")
    assert told.startswith("Hs 3 m, Tp 8 s, damping 5: ")
    assert "2 of 3 runs; 1 failed: buoy" in told
    missing = page.value("document.querySelector('.missing').textContent")
    assert "no series of run 55 (Hs 3 m, Tp 8 s, damping 5, seed 1)" in missing  # it failed
    choose(page, ".run", 3)
    assert page.value("report.plots.panels.map(panel => panel.names)") == [["buoy.z, run 4"]]
    page.value("document.querySelector('.beside').click()")
    page.value("document.querySelector('.after').click()")
    settled(page)
    names = page.value("report.plots.panels[0].names")
    assert names == ["buoy.z, run 4", "buoy.z, run 5"]
    page.value("report.spectra.draw()")
    assert "without the start-up (until 30 s)" in page.value(
        "document.querySelector('.spectra .told').textContent"
    )
    assert page.nameless() == []
    assert page.complaints == []


def test_the_table_is_the_numbers(shown: Page) -> None:
    page = shown
    rows = list(csv.DictReader(io.StringIO(page.value("report.numbers.csv()"))))
    assert len(rows) == 24
    assert float(rows[3]["mean_power [W]"]) == pytest.approx(mean(0, 1, 1), rel=1e-14)
    assert rows[16]["failed runs"] == "3"
    assert rows[16]["mean_power [W]"] == ""
    choose(page, ".rows", "runs")
    rows = list(csv.DictReader(io.StringIO(page.value("report.numbers.csv()"))))
    assert len(rows) == 72
    assert rows[54]["failure"] == f"buoy at t = 3 s: {EVIL}"
    head = "[...document.querySelectorAll('#numbers th button')]"
    click = f"{head}.find(b => b.textContent.startsWith('mean_power')).click()"
    page.value(click)
    page.value(click)
    column = page.value(
        "[...document.querySelectorAll('#numbers tbody tr')].map(r => r.cells[5].textContent)"
    )
    values = [float(text) for text in column if text != "–"]
    assert values == sorted(values, reverse=True)
    assert len(values) == 64
    assert column[64:] == ["–"] * 8
    assert page.complaints == []


def test_a_point_for_each_run(shown: Page) -> None:
    page = shown
    page.value("report.scatter.draw()")
    settled(page)
    points, failed = traces(page, "x, y, name", "#scatter .chart")
    assert len(points["x"]) == 64
    assert points["y"][0] == pytest.approx(power(HEIGHTS[0], PERIODS[0], DAMPINGS[0], 0) / 1e3)
    assert (failed["name"], failed["x"]) == ("failed", [3.0] * 8)
    choose(page, "#scatter .over", "Tp")
    assert traces(page, "x", "#scatter .chart")[0]["x"][3 * SEEDS * 2] == PERIODS[3]
    assert page.complaints == []


def choices(page: Page) -> None:
    """Choices of dimensions, points, forms and quantities, each with what it shows."""
    choose(page, "#results input[type=range]", 1)
    heat = traces(page, "z")[0]
    assert heat["z"][0][1] == pytest.approx(mean(0, 1, 1) / 1e3)
    assert page.value("document.querySelector('#results .others output').textContent") == "7"
    choose(page, "#results .up", 2)
    heat = traces(page, "z")[0]
    assert np.shape(heat["z"]) == (2, 4)  # damping up
    choose(page, "#results .up", "")
    found = traces(page, "type, x, y, fill")
    band, line = found[0], found[1]
    assert band["fill"] == "toself"
    assert line["x"] == list(PERIODS)
    assert line["y"][1] == pytest.approx(mean(0, 1, 1) / 1e3)
    choose(page, "#results .form", "histogram")
    assert traces(page, "type")[0]["type"] == "histogram"
    page.value("document.querySelector('#results .quantities input').click()")
    assert page.value("report.maps.panels.size") == 1


def test_choices_change_what_is_shown_in_a_narrow_window_and_on_paper(
    page: Page, sea: Path
) -> None:
    with page.emulated(width=420, mobile=True, scheme="dark"):
        opened(page, sea)
        assert page.value("document.documentElement.scrollWidth") == 420
        ink = page.value("document.querySelector('#results .chart')._fullLayout.font.color")
        assert page.picture()[2, 2].mean() < 50
        choose(page, ".theme", "light")
        assert page.picture()[2, 2].mean() > 230
        other = page.value("document.querySelector('#results .chart')._fullLayout.font.color")
        assert other != ink
        pdf = base64.b64decode(page.call("Page.printToPDF", preferCSSPageSize=True)["data"])
        assert len(pdf) > 100_000  # maps and curves
        choices(page)
        assert page.complaints == []


def test_many_points_are_drawn_where_a_part_of_webgl_is_missing(page: Page, tmp_path: Path) -> None:
    """Some browsers give a context, but not that which the plots need."""
    opened(page, report_of_study(samples(tmp_path, 2100), tmp_path / "r.html"))
    page.value(
        "{ const usual = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
        "return more.length && kind !== '2d' ? null : usual.call(this, kind, ...more); } }"
    )
    page.value("report.scatter.draw()")
    settled(page)
    assert page.value("document.querySelector('.no-webgl')") is None
    points = traces(page, "type, x", "#scatter .chart")[0]
    assert (points["type"], len(points["x"])) == ("scatter", 2100 - 21)
