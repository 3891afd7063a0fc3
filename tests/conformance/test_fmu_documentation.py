"""What FMUs of models carry for people: the page, the picture, the reference series."""

from __future__ import annotations

import csv
import hashlib
import io
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.util import read_csv
from fmpy.validation import validate_fmu
from matplotlib import rc_context
from PIL import Image
from support.driven import driven

from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system
from m4e_fmi.fmu import Options, build_fmu
from m4e_fmi.model import Body, Joint, Model, Sphere, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.report import fmu_documentation
from m4e_fmi.report.drawing.schematic import model_figure

PENDULUM = Path(__file__).parents[2] / "examples/double_pendulum/double_pendulum.model.yaml"
RENAME = {"joint.elbow.*": "knee.*", "m": "mass"}


@pytest.fixture(scope="module")
def model() -> Model:
    return load_model(PENDULUM)


@pytest.fixture(scope="module", params=[False, True], ids=["python", "native"])
def fmu(request: pytest.FixtureRequest, model: Model, tmp_path_factory: pytest.TempPathFactory):
    program = model_program(model)
    options = {"native": request.param, "rename": RENAME, "stop_time": 2.0, "tolerance": 1e-10}
    documentation = fmu_documentation(model, program, Options(**options))
    path = tmp_path_factory.mktemp("documented") / "pendulum.fmu"
    return build_fmu(program, path, documentation=documentation, **options)


@pytest.fixture(scope="module")
def fmu3(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = model_program(model)
    options = {"native": True, "fmi": "3", "stop_time": 2.0, "tolerance": 1e-10}
    documentation = fmu_documentation(model, program, Options(**options))
    path = tmp_path_factory.mktemp("documented") / "pendulum.fmu"
    return build_fmu(program, path, documentation=documentation, **options)


@pytest.mark.parametrize("native", [True, False])
def test_licenses_of_what_is_inside(native: bool, tmp_path: Path) -> None:
    path = build_fmu(driven(), tmp_path / "m.fmu", native=native)
    with zipfile.ZipFile(path) as archive:
        texts = {
            name.rpartition("/")[2]: archive.read(name).decode()
            for name in archive.namelist()
            if name.startswith("documentation/licenses/")
        }
        libraries = [name for name in archive.namelist() if name.endswith(".dll")]
    overview = texts.pop("license.txt")
    assert all(f"see {name}" in overview for name in texts)
    assert overview.count("see ") == len(texts)
    assert "BSD 3-Clause License" in texts.pop("m4e_fmi.txt")
    if not native:
        assert "MIT License" in texts.pop("pythonfmu.txt")
    elif libraries:
        assert "Zope Public License" in texts.pop("mingw-w64.txt")
    assert texts == {}


class Page(HTMLParser):
    """Tags that are open, what is loaded from elsewhere, and the texts of `code` elements."""

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
        if self.open and self.open[-1] == "code":
            self.codes.append(data)


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
    assert main(["build", "--single", "system.yaml", "--fmi", fmi]) == 0
    path = whole / "build" / "carts.fmu"
    found = contents(path)
    page = Page(found["documentation/index.html"].decode())
    assert page.open == []
    assert "carts_ref.csv" in page.loaded
    assert all(f"documentation/{link}" in found for link in page.loaded)
    description = fmpy.read_model_description(str(path))
    assert {v.name for v in description.modelVariables} <= set(page.codes)
    assert {"a", "b", "push", "a.body.cart", "place"} <= set(page.codes)
    assert set(load_system(whole / "system.yaml").connections) <= set(page.codes)
    text = found["documentation/index.html"].decode()
    assert "Two carts &amp; a &quot;table&quot; &lt;held&gt;" in text
    assert "kind table" in text
    assert text.count("cart.model.yaml") == 2
    series = found["documentation/carts_ref.csv"].decode().splitlines()
    assert series[-1].startswith("1,")
    assert validate_fmu(str(path)) == []


def test_what_is_left_open_is_on_the_page(whole: Path) -> None:
    assert main(["build", "--single", "system.yaml", "--open", "push"]) == 0
    text = contents(whole / "build" / "carts.fmu")["documentation/index.html"].decode()
    assert "left out: what it gives are inputs" in text
    assert main(["build", "--single", "system.yaml", "--no-documentation"]) == 0
    found = contents(whole / "build" / "carts.fmu")
    assert "documentation/index.html" not in found


def test_the_same_system_gives_the_same_bytes(whole: Path) -> None:
    made = []
    for _ in range(2):
        assert main(["build", "--single", "system.yaml"]) == 0
        made.append((whole / "build" / "carts.fmu").read_bytes())
    assert made[0] == made[1]


def contents(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_no_finding(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []


def test_the_page_stands_alone_and_names_everything(fmu: Path) -> None:
    page = Page(contents(fmu)["documentation/index.html"].decode())
    assert page.open == []
    assert page.loaded == ["double_pendulum_ref.csv", "licenses/license.txt"]
    assert "msubsup" in page.tags  # a power of what has an index
    assert "script" not in page.tags
    assert {"svg", "math", "table"} <= page.tags
    description = fmpy.read_model_description(str(fmu))
    assert {v.name for v in description.modelVariables} <= set(page.codes)
    assert {"body.upper", "point.tip", "knee"} <= set(page.codes)  # connectors


def test_the_equations_are_those_of_the_model(fmu: Path) -> None:
    """Of a pendulum of two equal links: M₂₂ = J + m L²/4, the second with its states' names."""
    text = contents(fmu)["documentation/index.html"].decode()
    lines = {
        re.sub(r"<[^>]*>|&InvisibleTimes;", "", line)
        for line in re.findall(r"<li>(.*?)</li>", text, re.DOTALL)
    }
    shared = next(line for line in lines if line in ("w1=L2m", "w1=mL2"))
    assert f"M2,2=J+{shared[:2]}4" in lines
    assert "q2=θ2knee.q" in lines
    assert "u2=θ.2knee.u" in lines


def test_the_icon_is_a_square_picture_with_something_on_it(fmu: Path) -> None:
    picture = Image.open(io.BytesIO(contents(fmu)["model.png"]))
    assert picture.size == (256, 256)
    assert not picture.info  # neither date nor version
    colours = picture.convert("RGB").getcolors(maxcolors=1 << 16) or []
    covered = sum(count for count, colour in colours if colour != (255, 255, 255))
    assert 0.05 * 256**2 < covered < 0.95 * 256**2


def test_the_drawing_is_rounded_in_its_places_only(tmp_path: Path) -> None:
    """Links of 8 mm, whose axes have thousandths: the texts are matplotlib's, the places are its
    to half of the last digit that is kept, 0.005 pt."""
    text = PENDULUM.read_text(encoding="utf-8").replace("L: {value: 1,", "L: {value: 0.008,")
    path = tmp_path / "small.model.yaml"
    path.write_text(text, encoding="utf-8")
    small = load_model(path)
    program, plain = model_program(small), io.StringIO()
    page = fmu_documentation(small, program, Options())["documentation/index.html"].decode()
    drawing = page[page.index("<svg") : page.index("</svg>") + len("</svg>")]
    with rc_context({"svg.fonttype": "none"}):
        figure = model_figure(small, program=program)
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        figure.savefig(plain, format="svg", bbox_inches="tight", pad_inches=0.15, metadata=nothing)
    given, found = (ET.fromstring(svg) for svg in (plain.getvalue(), drawing))
    texts = [[t.strip() for t in svg.itertext() if t.strip()] for svg in (given, found)]
    assert any(re.search(r"0\.00\d", t) for t in texts[1])
    assert texts[1] == texts[0]
    for attribute in ("d", "x", "y", "transform"):
        lists = [
            [
                number
                for element in svg.iter()
                if element.tag.partition("}")[2] in ("path", "use", "text", "rect")
                for number in re.findall(r"-?\d+(?:\.\d+)?", element.get(attribute, ""))
            ]
            for svg in (given, found)
        ]
        assert lists[1]
        assert max(len(n.partition(".")[2]) for n in lists[1]) <= 2
        before, after = (np.array(numbers, float) for numbers in lists)
        np.testing.assert_allclose(after, before, rtol=0, atol=0.005 + 1e-9)


def test_the_reference_series_is_what_the_fmu_gives(fmu: Path) -> None:
    """FMPy's run of the default experiment, whose steps are others; the tolerance is 1e-10 per
    step, of some 20 in 2 s, and digits after the tenth are not written."""
    files = contents(fmu)
    rows = list(csv.reader(files["documentation/double_pendulum_ref.csv"].decode().splitlines()))
    table = np.array(rows[1:], float)
    lines = files["documentation/double_pendulum_ref.opt"].decode().splitlines()
    settings = dict(line.split(", ") for line in lines)
    assert float(settings["StopTime"]) == 2.0
    description = fmpy.read_model_description(str(fmu))
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    assert rows[0] == ["time", *outputs]
    found = fmpy.simulate_fmu(
        str(fmu), stop_time=2.0, output_interval=float(settings["StepSize"]), output=outputs
    )
    for k, name in enumerate(rows[0]):
        scale = max(1.0, np.abs(table[:, k]).max())
        np.testing.assert_allclose(found[name], table[:, k], rtol=0, atol=1e-8 * scale)


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


class TestFmi3:
    def test_the_icon_is_elsewhere(self, fmu3: Path) -> None:
        assert validate_fmu(str(fmu3)) == []
        names = contents(fmu3).keys()
        assert "terminalsAndIcons/icon.png" in names
        assert "model.png" not in names

    def test_the_page_has_the_variables_of_this_fmu(self, fmu3: Path) -> None:
        """Arrays, not their elements by the names of FMI 2.0; elements only of states."""
        text = contents(fmu3)["documentation/index.html"].decode()
        found = set(re.findall(r'<td class="name"><code>(.*?)</code>', text))
        description = fmpy.read_model_description(str(fmu3))
        assert found == {v.name for v in description.modelVariables}
        assert "body.upper.x" not in Page(text).codes
        assert "<code>body.upper.position</code>[2]" in text

    def test_states_that_are_elements(self) -> None:
        """Of a free body, whose coordinates are the elements of its position."""
        sea = {"sea": Joint("floating", "hull")}
        free = Model("free", bodies={"hull": Body(mass=1.0, inertia=1.0)}, joints=sea)
        program = model_program(free)
        files = fmu_documentation(free, program, Options(native=True, fmi="3"))
        assert "body.hull.position[2]" in files["documentation/index.html"].decode()

    def test_the_page_of_a_model_in_space(self) -> None:
        """Six equations for seven coordinates: a quaternion's rate is told apart."""
        sea = {"sea": Joint("floating", "hull")}
        hull = {"hull": Body(1.0, (1.0, 2.0, 2.5), shape=Sphere(0.5))}
        free = Model("free", bodies=hull, joints=sea, dimensions=3)
        files = fmu_documentation(free, model_program(free), Options(native=True, fmi="3"))
        text = files["documentation/index.html"].decode()
        assert "but for quaternions" in text
        assert "body.hull.quaternion[4]" in Page(text).codes
        assert "roll, pitch and yaw" in text
        rows = re.findall(r"<msub><mi>M</mi><mrow><mn>(\d)</mn><mo>,</mo><mn>(\d)</mn>", text)
        assert {row for pair in rows for row in pair} == set("123456")

    def test_the_reference_series_is_read_by_fmpy(self, fmu3: Path, tmp_path: Path) -> None:
        """With a column for each array, as in FMPy's own results; tolerances as above."""
        path = tmp_path / "ref.csv"
        path.write_bytes(contents(fmu3)["documentation/double_pendulum_ref.csv"])
        table = read_csv(path)
        assert table.dtype["body.upper.position"].shape == (2,)
        times = table["time"]
        found = fmpy.simulate_fmu(str(fmu3), stop_time=2.0, output_interval=times[1] - times[0])
        assert table.dtype.names == found.dtype.names
        for name in table.dtype.names or ():
            scale = max(1.0, np.abs(table[name]).max())
            np.testing.assert_allclose(found[name], table[name], rtol=0, atol=1e-8 * scale)


def test_a_default_experiment_that_fails_is_told(tmp_path: Path) -> None:
    """A pendulum whose push is no number from 1 s on."""
    text = PENDULUM.read_text(encoding="utf-8").replace("[20, 20]", "[sqrt(1 - t), 0]")
    path = tmp_path / "wild.model.yaml"
    path.write_text(text, encoding="utf-8")
    model = load_model(path)
    files = fmu_documentation(model, model_program(model), Options())
    assert not any(name.endswith("_ref.csv") for name in files)
    page = files["documentation/index.html"].decode()
    assert "no reference series, because the default experiment fails" in page
