"""Reports in a real browser: plots, cursor and animation with one time, keys, light and dark."""

from __future__ import annotations

import base64
import itertools
from pathlib import Path

import numpy as np
import pytest
from support.browser import CHROMIUM, Page
from support.floating_boxes import floating_boxes
from support.report_pages import LONGEST_OPENING, opened, settled

from m4e_fmi.cosim import Outcome, Results, load, run
from m4e_fmi.report import report_of_run

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """Two hulls and a line at sea."""
    folder = tmp_path_factory.mktemp("boxes")
    system = floating_boxes(folder)
    return run(system, results=folder / "r.nc", build_directory=folder, animated=True)


@pytest.fixture(scope="module")
def boxes(outcome: Outcome) -> tuple[Path, Results]:
    """Their report, and the results that it is made of."""
    assert outcome.path is not None
    path = outcome.path.with_suffix(".report.html")
    return report_of_run(outcome.path, path), load(outcome.path)


def cursor_time(page: Page) -> float:
    """The time [s] at which the cursor of the first plot stands, from its place on the screen."""
    return page.value(
        "{ const plot = document.querySelector('.plot'), axis = plot._fullLayout.xaxis;"
        "axis.p2l(parseFloat(plot.querySelector('.cursor').style.left) - axis._offset) }"
    )


def dark_share(page: Page, selector: str) -> float:
    """Share of pixels of an element that differ from its corner."""
    page.value(f"document.querySelector('{selector}').scrollIntoView({{block: 'center'}})")
    settled(page)
    seen = page.seen(selector)
    return float((np.abs(seen - seen[3, 3]).max(axis=2) > 30).mean())


def test_it_opens_without_complaint_and_asks_for_nothing_else(
    page: Page, boxes: tuple[Path, Results]
) -> None:
    first = opened(page, boxes[0])
    assert first < 1000 * LONGEST_OPENING
    assert page.value("report.plots.panels.length") > 2
    assert dark_share(page, ".plot") > 0.01
    assert dark_share(page, ".animation canvas") > 0.3
    assert dark_share(page, ".sankey") > 0.02
    page.value("document.querySelector('.spectra').scrollIntoView()")
    settled(page)
    assert page.value("document.querySelectorAll('.spectrum .main-svg').length") > 2
    assert page.complaints == []
    assert page.requests == [boxes[0].absolute().as_uri()]


def test_slider_and_cursor_are_one_time(page: Page, boxes: tuple[Path, Results]) -> None:
    path, results = boxes
    opened(page, path)
    one = page.value("document.querySelector('.animation canvas').toDataURL()")
    page.choose(".slider", 4.03)
    assert cursor_time(page) == pytest.approx(4.03, abs=0.01)
    shown = page.value("document.querySelector('.readout output').textContent")
    name = page.value("report.plots.panels[0].names[0]")
    expected = np.interp(4.03, results.time, results[name])  # between two rows
    assert float(shown.split()[0]) == pytest.approx(expected, rel=1e-4)
    assert page.value("document.querySelector('.animation canvas').toDataURL()") != one
    # the other way: a click in a plot
    page.value("document.querySelector('.plot').scrollIntoView({block: 'center'})")
    x, y = (
        page.value("{ const plot = document.querySelector('.plot'), a = plot._fullLayout.xaxis;"
                   "plot.getBoundingClientRect().left + a._offset + a.l2p(2) }"),
        page.value("{ const r = document.querySelector('.plot').getBoundingClientRect();"
                   "r.top + r.height / 2 }"),
    )  # fmt: skip
    page.mouse("mouseMoved", x, y)
    settled(page)
    page.mouse("mousePressed", x, y, button="left", clickCount=1)
    page.mouse("mouseReleased", x, y, button="left", clickCount=1)
    settled(page)
    assert page.value("report.player.time()") == pytest.approx(2.0, abs=0.05)
    assert cursor_time(page) == pytest.approx(page.value("report.player.time()"), abs=0.01)
    hover = page.value("document.querySelector('.plot .hoverlayer').textContent")
    assert name in hover
    page.drag((x, y), (x + 100, y + 2))
    settled(page)
    shown = page.value(
        "[...document.querySelectorAll('.plot')].map(p => p._fullLayout.xaxis.range)"
    )
    assert shown[0][0] == pytest.approx(2.0, abs=0.05)
    assert 0.1 < shown[0][1] - shown[0][0] < 2.0
    assert all(one == shown[0] for one in shown)
    assert page.complaints == []


def test_the_animation_stays_in_view_beside_the_plots(
    page: Page, boxes: tuple[Path, Results]
) -> None:
    opened(page, boxes[0])
    seen = "{ const r = document.querySelector('.animation canvas').getBoundingClientRect();"
    seen += "r.top >= 0 && r.bottom <= innerHeight }"
    page.value("document.querySelector('.dock').click()")
    for place in (0, 600, 1500):
        page.value(f"scrollTo(0, {place})")
        assert page.value(seen)
    page.value("document.querySelector('.dock').click()")
    assert not page.value(seen)
    page.value("scrollTo(0, 0)")
    assert page.value(seen)  # the page opens with it
    assert page.complaints == []


def test_all_that_a_mouse_does_keys_do(page: Page, boxes: tuple[Path, Results]) -> None:
    path, results = boxes
    opened(page, path)
    page.value("document.querySelector('.plot').focus()")
    for _ in range(3):
        page.press("ArrowRight")
    assert page.value("report.player.time()") == pytest.approx(results.time[3])
    page.press("End")
    assert cursor_time(page) == pytest.approx(results.time[-1], abs=0.01)
    page.press("Home")
    page.press("ArrowRight", modifiers=8)
    assert page.value("report.plots.now") == pytest.approx(0.1 * results.time[-1])
    page.press("+", "NumpadAdd")
    settled(page)
    ranges = page.value(
        "[...document.querySelectorAll('.plot')].map(p => p._fullLayout.xaxis.range)"
    )
    assert len(ranges) > 2
    assert ranges[0][1] - ranges[0][0] < 0.8 * results.time[-1]
    assert all(one == ranges[0] for one in ranges)
    page.press("0", "Digit0")
    settled(page)
    assert page.value("report.plots.range") == [0.0, results.time[-1]]
    # every control has a name, and is reached by Tab in the order of the page
    assert page.nameless() == []
    page.value("document.querySelector('.search').focus()")
    page.press("Tab")
    assert page.value("document.activeElement.className") == "where"
    page.press("Tab")
    assert page.value("document.activeElement.tagName") == "SUMMARY"
    assert page.complaints == []


def test_variables_are_found_and_shown(page: Page, boxes: tuple[Path, Results]) -> None:
    opened(page, boxes[0])
    count = page.value("report.plots.panels.length")
    page.choose(".search", "cube omega_x")
    assert page.value("document.querySelector('.found').textContent") == "1 found"
    page.value("document.querySelector('.groups input').click()")
    settled(page)
    assert page.value("report.plots.panels.length") == count + 1  # the first of its unit
    assert page.value("report.plots.panels.at(-1).names") == ["boxes.body.cube.omega_x"]
    assert page.value("report.plots.panels.at(-1).element.querySelectorAll('path.js-line').length")
    page.value("document.querySelector('.groups input').click()")
    assert page.value("report.plots.panels.length") == count
    page.value("document.querySelector('.clear').click()")
    settled(page)
    assert page.value("report.plots.panels.length") == 0
    assert page.complaints == []


def test_power_flow_is_that_of_the_run(
    page: Page, boxes: tuple[Path, Results], outcome: Outcome
) -> None:
    """The whole run: its own energies. A part: forces times velocities of the rows."""
    path, results = boxes
    opened(page, path)
    page.value("report.flows.draw()")
    settled(page)
    span = results.time[-1] - results.time[0]
    link = page.value("document.querySelector('.sankey').data[0].link")
    shown = dict(zip(link["label"], link["value"], strict=True))
    for bond in outcome.energy:
        expected = abs(bond.given) / span
        assert shown[bond.connection.replace("<", "&lt;").replace(">", "&gt;")] == (
            pytest.approx(expected, rel=1e-12)
        )
    # sums at each node: what flows in flows out, but at the ends
    net = np.zeros(len(page.value("document.querySelector('.sankey').data[0].node.label")))
    np.add.at(net, link["target"], link["value"])
    np.subtract.at(net, link["source"], link["value"])
    ends = set(link["source"]) ^ set(link["target"])
    inner = [k for k in range(len(net)) if k not in ends]
    assert inner
    assert net[inner] == pytest.approx(0.0, abs=1e-9 * max(link["value"]))
    # what the boxes hold more or less at the end is told in words where it is much
    held = results["boxes.energy.total"].values
    ends = [k for k in range(len(net)) if k not in link["target"]]
    given = -net[ends].sum() * span
    told = page.value(
        "document.querySelector('.sankey').parentElement.querySelector('.told').textContent"
    )
    much = abs(held[-1] - held[0]) > 0.02 * given
    assert ("energy of boxes is" in told) == much
    if much:
        assert f"{'lower' if held[-1] < held[0] else 'higher'} at the end" in told
    page.value("report.plots.range = [2, 5]")
    settled(page)
    rows = (results.time >= 2.0) & (results.time <= 5.0)
    power = sum(
        results[f"mooring.bow.force_{axis}"].values * results[f"boxes.point.bow.v{axis}"].values
        for axis in "xyz"
    )
    expected = np.trapezoid(np.asarray(power)[rows], results.time[rows]) / 3.0
    link = page.value("document.querySelector('.sankey').data[0].link")
    shown = dict(zip(link["label"], link["value"], strict=True))
    found = shown["boxes.point.bow &lt;-&gt; mooring.bow"]
    assert found == pytest.approx(abs(expected), rel=1e-5)
    assert page.complaints == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_and_dark_follow_the_system_or_the_reader(
    page: Page, boxes: tuple[Path, Results], scheme: str
) -> None:
    other = {"light": "dark", "dark": "light"}[scheme]
    with page.emulated(scheme=scheme):
        opened(page, boxes[0])
        corner = page.picture()[2, 2].mean()
        assert corner > 230 if scheme == "light" else corner < 50
        ink = page.value("document.querySelector('.plot')._fullLayout.font.color")
        page.choose(".theme", other)
        settled(page)
        corner = page.picture()[2, 2].mean()
        assert corner < 50 if scheme == "light" else corner > 230
        assert page.value("document.querySelector('.plot')._fullLayout.font.color") != ink
        assert page.complaints == []


def test_it_fits_a_narrow_window_and_paper(page: Page, boxes: tuple[Path, Results]) -> None:
    with page.emulated(width=420, mobile=True):
        opened(page, boxes[0])
        page.value("report.spectra.draw()")
        settled(page)
        assert page.value("document.documentElement.scrollWidth") == 420
        # the system is folded, and shown in a size that can be read, which moves within its frame
        assert not page.value("document.querySelector('.picture').checkVisibility()")
        page.value("location.hash = '#system'")
        settled(page)
        assert page.value("document.querySelector('.picture').clientWidth") > 700
        page.value("report.flows.draw()")
        settled(page)
        places = page.value(
            "Array.from(document.querySelectorAll('.sankey .node-label'), label => {"
            "const box = label.getBoundingClientRect();"
            "return [box.left, box.right, box.top, box.bottom]; })"
        )
        assert len(places) > 2
        for (l1, r1, t1, b1), (l2, r2, t2, b2) in itertools.combinations(places, 2):
            assert l1 >= r2 or l2 >= r1 or t1 >= b2 or t2 >= b1
        # the animation beside the plots leaves more than a plot free above it, also at the end
        page.value("document.querySelector('.dock').click()")
        page.value("document.querySelector('.plot').scrollIntoView()")
        strip = page.value("document.querySelector('.docked').getBoundingClientRect().top")
        assert page.value("document.querySelector('.plot').getBoundingClientRect().bottom") < strip
        assert strip > 0.6 * 800
        assert page.value("document.documentElement.scrollWidth") == 420
        page.value("scrollTo(0, document.body.scrollHeight)")
        assert page.value("document.querySelector('main').getBoundingClientRect().bottom") < strip
        page.value("document.querySelector('.dock').click()")
        pdf = base64.b64decode(page.call("Page.printToPDF", preferCSSPageSize=True)["data"])
        assert pdf.startswith(b"%PDF")
        assert len(pdf) > 100_000  # curves, not empty frames
        assert page.complaints == []
