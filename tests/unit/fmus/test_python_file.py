"""`kind: python`: a component in one Python file, as a program or as Python code."""

from __future__ import annotations

import io
import json
import random
import sys
from collections import defaultdict, deque, namedtuple
from pathlib import Path
from textwrap import dedent
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.fmu import PythonSource
from m4e_fmi.program import Program, evaluated
from m4e_fmus.python_file import KIND, Config
from m4e_fmus.python_file.saved_values import CannotBeSavedError, decoded, encoded
from m4e_fmus.python_file.user_class import Declared, Values

EXAMPLES = Path(__file__).parents[3] / "examples"
HYDRAULICS = (EXAMPLES / "hydraulic_pto" / "hydraulics.py").read_text(encoding="utf-8")
FORCE = """\
import math


class Force:
    inputs = {"z": "m"}
    outputs = {"f": "N"}

    def calculate(self, t, v):
        return {"f": 2.0 * v.z}
"""
DELAY = """\
from collections import deque


class Delay:
    parameters = {"gain": (2.0, "1")}
    inputs = {"u": "m"}
    outputs = {"y": "m", "last[2]": "m"}

    def start(self, v):
        self.past = deque([v.u] * 3, maxlen=3)

    def step(self, t, h, v):
        self.past.append(v.u)
        return {"y": v.gain * self.past[0], "last": list(self.past)[1:]}
"""


def made(folder: Path, text: str, **keys: Any) -> tuple[Program | PythonSource, list[str]]:
    (folder / "force.py").write_text(dedent(text), encoding="utf-8")
    lines: list[str] = []
    config = Config(file="force.py", **keys)
    return KIND.build(config, name="force", folder=folder, progress=lines.append), lines


def system(
    folder: Path, components: str, stop: float = 1.0, step: float = 0.5, **files: str
) -> Path:
    """A system of files `NAME.py` with these texts."""
    for name, text in files.items():
        (folder / f"{name}.py").write_text(dedent(text), encoding="utf-8")
    path = folder / "system.yaml"
    path.write_text(
        f"name: s\ncomponents: {{{components}}}\n"
        f"simulation: {{stop_time: {stop}, step_size: {step}}}\n"
    )
    return path


def results(path: Path) -> dict[str, np.ndarray]:
    prepared = prepare(load_system(path), build_directory=path.parent / "build")
    found = run(prepared, results=path.parent / "results.nc").results()
    return {name: np.asarray(found[name]) for name in found.series}


def with_float(folder: Path, text: str) -> Path:
    """The example's float with the file `text` in place of the power take-off."""
    folder.mkdir(exist_ok=True)
    example = EXAMPLES / "hydraulic_pto"
    for file in example.glob("*.model.yaml"):
        (folder / file.name).write_text(file.read_text("utf-8"), encoding="utf-8")
    (folder / "hydraulics.py").write_text(text, encoding="utf-8")
    yaml = (example / "system_one_file.yaml").read_text("utf-8")
    (folder / "system.yaml").write_text(yaml.replace("stop_time: 12", "stop_time: 2"))
    return folder / "system.yaml"


def test_the_hydraulic_power_take_off_is_the_same_recorded_and_as_code(tmp_path: Path) -> None:
    program, lines = made(tmp_path, HYDRAULICS)
    assert isinstance(program, Program)
    assert lines == ["force.py is recorded as a program"]
    branch = "        if v.oil > 1.0:\n            p = 0.0\n        force = "
    one = results(with_float(tmp_path / "native", HYDRAULICS))
    other = results(with_float(tmp_path / "python", HYDRAULICS.replace("        force = ", branch)))
    for name in ("hydraulics.rod.force_z", "hydraulics.power", "float.body.float.z"):
        scale = np.abs(one[name]).max()
        np.testing.assert_allclose(other[name], one[name], atol=2e-5 * scale, err_msg=name)


def test_functions_of_math_and_extremes_are_recorded(tmp_path: Path) -> None:
    text = """
    from math import exp, hypot, pi

    class Force:
        inputs = {"z": "m", "w[2]": "m/s"}
        outputs = {"f[2]": "N"}

        def calculate(self, t, v):
            from math import cos
            limited = max(-1, min(v.z, 1.0, v.w[0]))
            return {"f": [limited * exp(-t) * pi, cos(v.w[1])]}
    """
    program, _ = made(tmp_path, text)
    assert isinstance(program, Program)
    assert [v.name for v in program.inputs] == ["z", "w[1]", "w[2]"]
    assert [v.name for v in program.outputs] == ["f[1]", "f[2]"]
    given = {"z": 5.0, "w[1]": 0.5, "w[2]": 0.0, "time": 0.0}
    found = evaluated(program.tape, program.results, given)
    assert [found[k] for k in program.results] == pytest.approx([0.5 * np.pi, 1.0])


def test_a_changed_file_is_read_anew_within_its_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bytecode in a cache would be that of the first: of the same second, and the same size."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    for k in (2, 3, 4):
        program, _ = made(tmp_path, FORCE.replace("2.0", f"{k}.0"))
        assert isinstance(program, Program)
        assert evaluated(program.tape, program.results, {"z": 1.0}) == {program.results[0]: k}
    assert not (tmp_path / "__pycache__").exists()


def test_files_beside_are_imported_and_read(tmp_path: Path) -> None:
    (tmp_path / "gains.csv").write_text("2.5", encoding="utf-8")
    force = """
    from __future__ import annotations
    from dataclasses import dataclass
    from pathlib import Path
    import slave

    @dataclass
    class Gain:
        value: float

    class Force:
        outputs = {"y": "N"}

        def start(self, v):
            text = (Path(__file__).parent / "gains.csv").read_text()
            self.gain = Gain(float(text)).value * slave.FACTOR

        def calculate(self, t, v):
            return {"y": self.gain}
    """
    files = "force: {kind: python, file: force.py, files: [gains.csv, slave.py]}"
    path = system(tmp_path, files, force=force, slave="FACTOR = 4.0\n")
    assert results(path)["force.y"] == pytest.approx(10.0)


@pytest.mark.parametrize("name", ["fractions", "numpy"])
def test_a_folder_with_the_name_of_a_package_is_no_package(name: str, tmp_path: Path) -> None:
    """NumPy cannot be imported twice."""
    (tmp_path / name).mkdir()
    (tmp_path / name / "notes.py").write_text("", encoding="utf-8")
    before = sys.modules.get(name)
    text = FORCE.replace("import math", f"import {name}")
    assert made(tmp_path, text)[1] == ["force.py is recorded as a program"]
    assert before is None or sys.modules[name] is before


@pytest.mark.parametrize("arguments", ["self, *all", "self, time, size, values", "self, t, h, v=0"])
def test_arguments_have_any_names(tmp_path: Path, arguments: str) -> None:
    source, _ = made(tmp_path, DELAY.replace("def step(self, t, h, v)", f"def step({arguments})"))
    assert isinstance(source, PythonSource)


def test_sampled_code_is_made_once_for_each_of_its_points(tmp_path: Path) -> None:
    """The default algorithm makes steps again: each begins with the object as it was."""
    source = FORCE.replace('{"f": 2.0 * v.z}', '{"f": math.sin(t)}').replace('"z": "m"', "")
    path = system(
        tmp_path,
        "source: {kind: python, file: source.py}, "
        "delay: {kind: python, file: delay.py, step_size: 0.25}",
        stop=2.0, step=0.125, source=source.replace('"N"', '"m"'), delay=DELAY,
    )  # fmt: skip
    path.write_text(path.read_text() + "connections: [source.f -> delay.u]\n")
    found = results(path)
    u, y = found["source.f"][::2], found["delay.y"][::2]
    np.testing.assert_allclose(y[3:], 2.0 * u[:-3], atol=1e-12)


def test_a_step_returns_the_outputs_at_its_end(tmp_path: Path) -> None:
    """As the page of the kind says: a controller acts one step after it has read its inputs."""
    clock = """
    import numpy as np

    class Clock:
        outputs = {"y": "s"}

        def start(self, v):
            return {"y": -1.0}

        def step(self, t, h, v):
            return {"y": np.array(t)}  # of no dimension, as NumPy's functions give it
    """
    given = "clock: {kind: python, file: clock.py, step_size: 0.2}"
    found = results(system(tmp_path, given, 0.5, 0.1, clock=clock))["clock.y"]
    np.testing.assert_allclose(found, [-1.0, -1.0, 0.0, 0.0, 0.2, 0.2], atol=1e-12)


def test_attributes_are_saved_and_come_back() -> None:
    values: dict[str, object] = {
        "a": (1, [2.5, None, True]),
        "b": deque([1.0, 2.0], maxlen=4),
        "c": np.float64(0.1),
        "d": {1: "one", (2, 3.0): [4], None: 1 + 2j, "a": {True: 0}},
    }
    again = decoded(encoded(values, "self"))
    assert again == values
    assert again["b"].maxlen == 4
    assert decoded(json.loads(json.dumps(encoded(values["d"], "self.table")))) == values["d"]
    for generator in (random.Random(5), np.random.default_rng(5)):
        generator.random()
        again = decoded(json.loads(json.dumps(encoded(generator, "self.noise"))))
        assert again.random() == generator.random()
    for array in (
        np.zeros((0, 3)),
        np.asfortranarray(np.arange(6).reshape(2, 3)),
        np.array([1 + 2j]),
        np.array(["2026-01-01"], dtype="datetime64[D]"),
        np.array([True, False]),
        np.array(["a", "bc"]),
        np.random.default_rng(1).random(300_000),  # as bytes
    ):
        again = decoded(encoded(array, "self.a"))
        np.testing.assert_array_equal(again, array)
        assert (again.shape, again.dtype) == (array.shape, array.dtype)
        again[...] = again  # can be changed


def values(*names: str) -> Values:
    return Values({name: Declared(name, "m", "", 0.0, None) for name in names})


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (defaultdict(list), "self.a"),
        (namedtuple("Pair", "a b")(1, 2), "self.a"),  # pyrefly: ignore[untyped-namedtuple]
        ({"log": io.StringIO()}, r"self.a\['log'\] is of type StringIO"),
        (values("rod.vz").filled({"rod.vz": 2.0}), r"self.a is the object of values"),
    ],
)
def test_what_cannot_be_saved_is_named(value: object, told: str) -> None:
    with pytest.raises(CannotBeSavedError, match=told):
        encoded(value, "self.a")


def test_a_connector_may_have_any_name() -> None:
    names = ("path.x", "path.end.x", "prefix")
    found = values(*names).filled(dict(zip(names, (1.0, 2.0, 3.0), strict=True)))
    assert (found.path.x, found.path.end.x, found.prefix) == (1.0, 2.0, 3.0)
    with pytest.raises(AttributeError, match=r"path\.end\.y is declared; there are: x$"):
        found.path.end.y  # noqa: B018
    with pytest.raises(TypeError, match=r"write v.path.x, not v\['x'\]"):
        found.path["x"]
