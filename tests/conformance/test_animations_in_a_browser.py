"""Animations of models in space in a real browser: no complaint, something to see, and to turn."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.browser import CHROMIUM, Page
from support.floating_boxes import floating_boxes

from m4e_fmi.cosim import Results, load, run
from m4e_fmi.model import load_model
from m4e_fmi.report import animate, animate_run
from m4e_fmi.simulate import simulate

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")

EXAMPLES = Path(__file__).parents[2] / "examples"
ROUND = """\
name: round
dimensions: 3
gravity: 0
bodies:
  wheel: {mass: 1, inertia: [1, 1, 1], shape: {mesh: wheel.obj}}
  ball: {mass: 1, inertia: [1, 1, 1], shape: {sphere: {radius: 0.5}}}
joints:
  a: {type: spherical, child: wheel, initial: {phi: 1, omega_z: 3}}
  b: {type: prismatic, child: ball, direction: [0, 0, 1], parent_to_joint: [0, 3, 0]}
"""


def wheel(count: int) -> str:
    """A disc with a hole, of 2·`count` triangles, as OBJ."""
    angles = [2 * math.pi * k / count for k in range(count)]
    rims = [f"v {r * math.cos(a)} {r * math.sin(a)} 0" for r in (1.0, 1.5) for a in angles]
    pairs = [*pairwise(range(1, count + 1)), (count, 1)]
    faces = [f"f {a} {b} {b + count} {a + count}" for a, b in pairs]
    return "\n".join([*rims, *faces]) + "\n"


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Animations: two examples, and a mesh with a sphere."""
    folder = tmp_path_factory.mktemp("pages")
    (folder / "wheel.obj").write_text(wheel(2000), encoding="ascii")
    (folder / "round.model.yaml").write_text(ROUND, encoding="ascii")
    files = {
        name: EXAMPLES / name / f"{name}.model.yaml" for name in ("gyroscope", "double_pendulum")
    }
    files["round"] = folder / "round.model.yaml"
    found = {}
    for name, file in files.items():
        model = load_model(file)
        simulation = simulate(model, stop_time=4.0, output_interval=0.02)
        found[name] = animate(model, simulation, folder / f"{name}.html")
    return found


@pytest.fixture(scope="module")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Results]:
    """The animation of two hulls and a line at sea, and the results that it is made of."""
    folder = tmp_path_factory.mktemp("boxes")
    run(floating_boxes(folder), results=folder / "r.nc", build_directory=folder, animated=True)
    return animate_run(folder / "r.nc", folder / "r.html"), load(folder / "r.nc")


def canvas(page: Page) -> np.ndarray:
    """What of the canvas is darker than paper and ground, (height, width) [1]."""
    return page.seen(".view").sum(axis=2) < 690


def show(page: Page, time: float) -> None:
    """Move the slider to a time [s]."""
    page.choose(".slider", time)
    page.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


@pytest.mark.parametrize("name", ["gyroscope", "double_pendulum", "round"])
def test_it_plays(page: Page, pages: dict[str, Path], name: str) -> None:
    page.open(pages[name])
    page.value("new Promise(done => setTimeout(done, 500))")
    assert 0.1 < page.value("player.time()") < 2.0
    show(page, 1.0)
    assert page.value("document.querySelector('.clock').textContent") == "1.00 s"
    one = canvas(page)
    assert 0.01 < one.mean() < 0.8
    show(page, 2.0)
    two = canvas(page)
    assert (one != two).mean() > 0.005
    show(page, 1.0)
    assert (canvas(page) != one).mean() == 0
    assert page.complaints == []


def test_the_mouse_turns_and_zooms_the_view(page: Page, pages: dict[str, Path]) -> None:
    page.open(pages["gyroscope"])
    show(page, 1.0)
    before = canvas(page)
    page.drag((500, 300), (400, 330))
    # a hundredth of a radian for each pixel
    assert page.value("player.eye.turn") == pytest.approx(-np.pi / 3 + 1.0, abs=1e-9)
    assert page.value("player.eye.rise") == pytest.approx(np.radians(22) + 0.3, abs=1e-9)
    turned = canvas(page)
    assert (turned != before).mean() > 0.01
    page.mouse("mouseMoved", 600, 300)  # no button: nothing turns
    assert page.value("player.eye.turn") == pytest.approx(-np.pi / 3 + 1.0, abs=1e-9)
    page.mouse("mouseWheel", 500, 300, deltaX=0, deltaY=-500)
    page.value("new Promise(done => setTimeout(done, 100))")
    assert page.value("player.eye.zoom") == pytest.approx(np.exp(0.5))
    assert canvas(page).mean() > turned.mean()
    for _ in range(2):
        page.mouse("mousePressed", 500, 300, button="left", clickCount=2)
        page.mouse("mouseReleased", 500, 300, button="left", clickCount=2)
    show(page, 1.0)
    assert (canvas(page) != before).mean() == 0
    assert page.complaints == []


def test_a_system_is_shown_as_its_results_have_it(page: Page, boxes: tuple[Path, Results]) -> None:
    """The page's own numbers between rows: bodies, nodes of the line, and the water at a point."""
    path, results = boxes
    page.open(path)
    row = 80
    time = float(results.time[row])
    show(page, time)
    one = page.picture()
    assert 0.3 < canvas(page).mean() < 1.0
    pose = page.value(f"player.posesAt({time})[1].slice(0, 3)")
    recorded = [results[f"boxes.body.cube.{axis}"][row] for axis in "xyz"]
    assert pose == pytest.approx(recorded, abs=1e-4)  # 16 bits of a few metres
    nodes = page.value(f"player.cablesAt({time})[0].points")
    places = [
        [results[f"mooring.line.node_{axis}[{k}]"][row] for axis in "xyz"] for k in (1, 7, 13)
    ]
    assert [nodes[k] for k in (0, 6, 12)] == [pytest.approx(p, abs=1e-3) for p in places]
    for at in (0.7, time):
        height = page.value(f"player.elevation(7, -3, {at})")
        # the smallest waves are left out: 0.3 % of the sea's height
        expected = np.interp(at, results.time, results["sea.buoy.elevation"])
        assert height == pytest.approx(expected, abs=0.005 * 0.4)
    show(page, 1.0)
    two = page.picture()
    assert (np.abs(two - one).max(axis=2) > 20).mean() > 0.02
    page.value("document.querySelector('.whole').click()")
    assert (np.abs(page.picture() - two).max(axis=2) > 20).mean() > 0.05
    assert page.complaints == []


def test_a_page_can_follow_the_time_that_is_shown(page: Page, boxes: tuple[Path, Results]) -> None:
    page.open(boxes[0])
    page.value("globalThis.told = []; player.onTime(time => told.push(time)); player.seek(2.5)")
    assert page.value("told") == [2.5]
    page.value("player.seek(1e9)")
    assert page.value("player.time()") == pytest.approx(6.0)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_a_narrow_window_in_light_and_dark(
    page: Page, boxes: tuple[Path, Results], scheme: str
) -> None:
    with page.emulated(width=420, scheme=scheme):
        page.open(boxes[0])
        show(page, 2.0)
        assert page.value("document.documentElement.scrollWidth") == 420
        corner = page.picture()[2, 2].mean()
        assert corner > 230 if scheme == "light" else corner < 50
        assert page.complaints == []


def test_keys_play_and_pause(page: Page, boxes: tuple[Path, Results]) -> None:
    page.open(boxes[0])
    show(page, 1.0)
    space = {"code": "Space", "key": " ", "text": " "}
    page.call("Input.dispatchKeyEvent", type="keyDown", **space)
    page.value("new Promise(done => setTimeout(done, 400))")
    assert page.value("player.time()") > 1.05
    page.call("Input.dispatchKeyEvent", type="keyUp", **space)
    page.call("Input.dispatchKeyEvent", type="keyDown", **space)
    still = page.value("player.time()")
    page.value("new Promise(done => setTimeout(done, 300))")
    assert page.value("player.time()") == still
