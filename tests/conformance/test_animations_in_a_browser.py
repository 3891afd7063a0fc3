"""Animations of models in space in a real browser: no complaint, something to see, and to turn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.browser import CHROMIUM, Page, browser

from m4e_fmi.model import load_model
from m4e_fmi.report import animate
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
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with browser(tmp_path_factory.mktemp("browser")) as opened:
        yield opened


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


def canvas(page: Page) -> np.ndarray:
    """What of the canvas is darker than paper and ground, (height, width) [1]."""
    x, y, width, height = (
        round(page.value(f"document.querySelector('.view').getBoundingClientRect().{side}"))
        for side in ("x", "y", "width", "height")
    )
    return page.picture()[y + 2 : y + height - 2, x + 2 : x + width - 2].sum(axis=2) < 690


def show(page: Page, time: float) -> None:
    """Move the slider to a time [s]."""
    page.value(
        f"{{ const slider = document.querySelector('.slider'); slider.value = {time}; "
        "slider.dispatchEvent(new Event('input')); } "
        "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )


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
    assert page.value("player.eye.zoom") == pytest.approx(1.15 * np.exp(0.5))
    assert canvas(page).mean() > turned.mean()
    for _ in range(2):
        page.mouse("mousePressed", 500, 300, button="left", clickCount=2)
        page.mouse("mouseReleased", 500, 300, button="left", clickCount=2)
    show(page, 1.0)
    assert (canvas(page) != before).mean() == 0
    assert page.complaints == []
