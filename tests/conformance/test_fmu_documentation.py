"""What FMUs of models carry for people: a page."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
import zipfile
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from support.fmu_instances import FILES

from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system
from m4e_fmi.fmu import Options, build_fmu
from m4e_fmi.model import Body, Joint, Model, Sphere, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.report import fmu_documentation

PENDULUM = Path(__file__).parents[2] / "examples/double_pendulum/double_pendulum.model.yaml"


@pytest.fixture(scope="module", params=FILES)
def fmu(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The documented FMU of the double pendulum, of each kind."""
    model, kind = load_model(PENDULUM), FILES[request.param]
    program = model_program(model)
    options: dict[str, Any] = {**kind.build, "stop_time": 2.0, "tolerance": 1e-10}
    documentation = fmu_documentation(model, program, Options(**options))
    path = tmp_path_factory.mktemp(request.param) / "pendulum.fmu"
    return build_fmu(program, path, documentation=documentation, **options)


class Page(HTMLParser):
    """Tags that are open, what is loaded from elsewhere, and the texts of cells."""

    EMPTY = ("meta", "br", "link", "img", "use", "path", "rect")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.loaded: list[str] = []
        self.codes: list[str] = []
        self.tags: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag not in self.EMPTY:
            self.open.append(tag)
        self.loaded += [v or "" for k, v in attrs if k in ("src", "href") and v and v[0] != "#"]

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.EMPTY:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "td":
            self.codes += [data, *data.split(", ")]


WHOLE = """\
name: carts
description: Two carts & a "table" <held>
components:
  a: {model: cart.model.yaml}
  b: {model: cart.model.yaml}
  push: {kind: table, times: [0, 1], beyond: held, signals: {f: {unit: N, values: [1, 2]}}}
connections:
  - a.body.cart.x * -10 -> b.body.cart.force_x, units ignored
  - push.f -> a.body.cart.force_x
outputs: {place: b.body.cart.x}
simulation: {stop_time: 1, step_size: 0.01}
"""
CART = """\
name: cart
description: A cart
gravity: 0
bodies: {cart: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: cart, direction: [1, 0]}}
"""


@pytest.fixture
def whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.model.yaml").write_text(CART, "utf-8")
    (tmp_path / "system.yaml").write_text(WHOLE, "utf-8")
    return tmp_path


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_the_page_of_a_whole_system(fmi: str, whole: Path) -> None:
    """Components, connections and all variables; every link leads to a file in the archive."""
    path, made = whole / "build" / "carts.fmu", []
    for _ in range(2):
        assert main(["build", "--single", "system.yaml", "--fmi", fmi]) == 0
        made.append(path.read_bytes())
    assert made[0] == made[1]
    found = contents(path)
    text = found["documentation/index.html"].decode()
    page = Page(text)
    assert page.open == []
    assert all(f"documentation/{link}" in found for link in page.loaded)
    description = fmpy.read_model_description(str(path))
    assert {v.name for v in description.modelVariables} <= {*page.codes, "time"}
    assert {"a", "b", "push", "a.body.cart", "place"} <= set(page.codes)
    assert set(load_system(whole / "system.yaml").connections) <= set(page.codes)
    assert "Two carts &amp; a &quot;table&quot; &lt;held&gt;" in text
    assert "kind table" in text
    assert text.count("cart.model.yaml") == 2
    assert validate_fmu(str(path)) == []


def test_what_is_left_open_is_on_the_page(whole: Path) -> None:
    build, path = ["build", "--single", "system.yaml"], whole / "build" / "carts.fmu"
    assert main([*build, "--open", "push"]) == 0
    text = contents(path)["documentation/index.html"].decode()
    assert "left out: what it gives are inputs" in text
    assert main([*build, "--no-documentation"]) == 0
    assert "documentation/index.html" not in contents(path)


def contents(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_page_stands_alone_and_names_everything(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []
    text = contents(fmu)["documentation/index.html"].decode()
    page, description = Page(text), fmpy.read_model_description(str(fmu))
    assert page.open == []
    assert page.loaded == ["licenses/license.txt"]
    assert "script" not in page.tags
    assert {"svg", "pre", "table"} <= page.tags
    assert {v.name for v in description.modelVariables} - {"time"} <= set(page.codes)
    assert {"body.upper", "point.tip", "joint.elbow"} <= set(page.codes)  # connectors


def test_the_equations_are_those_of_the_model(fmu: Path) -> None:
    """Of a pendulum of two equal links: M₂₂ = J + m L²/4."""
    text = contents(fmu)["documentation/index.html"].decode()
    lines = set(map(str.strip, text.splitlines()))
    assert "M₂,₂ = J + L² m/4" in lines


def test_the_same_bytes_in_another_process(tmp_path: Path) -> None:
    """Whatever the hash seed: neither the order of sets nor a date gets into the files."""
    digests = set()
    for seed in ("1", "2"):
        command = [sys.executable, "-c", "import m4e_fmi.cli, sys; sys.exit(m4e_fmi.cli.main())"]
        folder = tmp_path / seed
        subprocess.run(
            [*command, "build", str(PENDULUM), "--native", "--build-folder", str(folder)],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        )
        digests.add(hashlib.sha256((folder / "double_pendulum.fmu").read_bytes()).hexdigest())
    assert len(digests) == 1


def test_the_page_of_free_bodies() -> None:
    """Coordinates are elements; in space six equations for seven: a quaternion's rate is apart."""
    sea, options = {"sea": Joint("floating", "hull")}, Options(native=True, fmi="3")
    flat = Model("free", bodies={"hull": Body(mass=1.0, inertia=1.0)}, joints=sea)
    files = fmu_documentation(flat, model_program(flat), options)
    assert "body.hull.z" in files["documentation/index.html"].decode()
    hull = {"hull": Body(1.0, (1.0, 2.0, 2.5), shape=Sphere(0.5))}
    free = Model("free", bodies=hull, joints=sea, dimensions=3)
    text = fmu_documentation(free, model_program(free), options)[
        "documentation/index.html"
    ].decode()
    assert "but for quaternions" in text
    assert "body.hull.e3" in Page(text).codes
    assert "roll, pitch and yaw" in text
    (masses,) = re.findall(r"⎡ 1  0  0  0  +0 [^⎦]*⎣ 0  0  0  w[^⎦]*⎦\n\nForcing", text)
    assert masses.count("\n") == 7
