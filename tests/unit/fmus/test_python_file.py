"""`kind: python`: a component in one Python file, as a program or as Python code."""

from __future__ import annotations

import io
import json
import random
import re
import sys
from collections import defaultdict, deque, namedtuple
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import PythonSource
from m4e_fmi.program import Program, evaluated
from m4e_fmus.python_file import Config, make
from m4e_fmus.python_file.saved_values import CannotBeSavedError, decoded, encoded
from m4e_fmus.python_file.user_class import Declared, Values

EXAMPLES = Path(__file__).parents[3] / "examples"
HYDRAULICS = (EXAMPLES / "hydraulic_pto" / "hydraulics.py").read_text(encoding="utf-8")
BRANCH = "        if v.oil > 1.0:\n            p = 0.0\n"
DELAY = """
from collections import defaultdict, deque, namedtuple

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


def made(folder: Path, text: str, **keys: object) -> tuple[Program | PythonSource, list[str]]:
    (folder / "force.py").write_text(dedent(text), encoding="utf-8")
    lines: list[str] = []
    config = Config(file="force.py", **keys)  # type: ignore[arg-type]
    return make(config, name="force", folder=folder, progress=lines.append), lines


def system(folder: Path, text: str, *, of: str = "hydraulic_pto") -> Path:
    """A system of the example's float with the file `text` in place of the power take-off."""
    for file in (EXAMPLES / of).glob("*.model.yaml"):
        (folder / file.name).write_text(file.read_text("utf-8"), encoding="utf-8")
    (folder / "hydraulics.py").write_text(text, encoding="utf-8")
    path = folder / "system.yaml"
    yaml = (EXAMPLES / of / "system_one_file.yaml").read_text("utf-8")
    path.write_text(yaml.replace("stop_time: 12", "stop_time: 2"), encoding="utf-8")
    return path


def results(path: Path) -> dict[str, np.ndarray]:
    prepared = prepare(load_system(path), build_directory=path.parent / "build")
    found = run(prepared, results=path.parent / "results.nc").results()
    return {name: np.asarray(found[name]) for name in found.series}


def test_the_hydraulic_power_take_off_is_that_of_its_package(tmp_path: Path) -> None:
    program, lines = made(tmp_path, HYDRAULICS)
    assert isinstance(program, Program)
    assert lines == ["force.py is recorded as a program"]
    assert len(HYDRAULICS.splitlines()) <= 40
    native, python = tmp_path / "native", tmp_path / "python"
    native.mkdir()
    python.mkdir()
    branching = HYDRAULICS.replace("        force = ", BRANCH + "        force = ")
    one, other = results(system(native, HYDRAULICS)), results(system(python, branching))
    for name in ("hydraulics.rod.force_z", "hydraulics.power", "float.body.float.z"):
        scale = np.abs(one[name]).max()
        np.testing.assert_allclose(other[name], one[name], atol=2e-5 * scale, err_msg=name)


@pytest.mark.parametrize(
    ("code", "told"),
    [
        (
            "f = v.z if v.z > 0 else 0",
            "force.py:10: TypeError: a recorded scalar cannot be compared",
        ),
        (
            "f = 1.0 if v.z == 0 else 0.0",
            "force.py:10: TypeError: a recorded scalar cannot be compared",
        ),
        (
            "f = {2: 7.0}.get(v.z, 1.0)",
            "force.py:10: TypeError: a recorded scalar cannot be compared",
        ),
        (
            "f = [0.0, 1.0].count(v.z)",
            "force.py:10: TypeError: a recorded scalar cannot be compared",
        ),
        ("f = v.z if isinstance(v.z, float) else 0.0", "line 10 asks for a type"),
        ("self.n += 1; f = self.n * v.z", "it computes something else each time|object changes"),
        ("import random; f = random.random() * v.z", "it computes something else each time"),
        ("import numpy as np; f = np.sin(v.z)", "force.py:8: TypeError"),
    ],
)
def test_what_cannot_be_recorded_stays_python_and_is_told(
    tmp_path: Path, code: str, told: str
) -> None:
    text = f"""
    class Force:
        n = 0

        inputs = {{"z": "m"}}
        outputs = {{"f": "N"}}

        def calculate(self, t, v):
            {code}
            return {{"f": f}}
    """.lstrip("\n")
    source, lines = made(tmp_path, text)
    assert isinstance(source, PythonSource)
    line = lines[-1]
    assert re.search(
        told.replace("force.py:10", r"force.py:\d+").replace("line 10", r"line \d+"), line
    )


def test_patterns_are_not_recorded(tmp_path: Path) -> None:
    source, (line,) = made(
        tmp_path,
        """
        class Force:
            parameters = {"mode": (0.0, "1")}
            outputs = {"f": "N"}

            def calculate(self, t, v):
                match v.mode:
                    case 1:
                        return {"f": 2.0}
                return {"f": 0.0}
        """,
    )
    assert isinstance(source, PythonSource)
    assert "line 7 matches patterns" in line


def test_a_changed_file_is_read_anew_within_its_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bytecode in a cache would be that of the first: of the same second, and the same size."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    text = """
    class Force:
        inputs = {"z": "m"}
        outputs = {"f": "N"}

        def calculate(self, t, v):
            return {"f": 1.0 * v.z}
    """
    programs = [made(tmp_path, text.replace("1.0", f"{k}.0"))[0] for k in (2, 3, 4)]
    for k, program in zip((2, 3, 4), programs, strict=True):
        assert isinstance(program, Program)
        assert evaluated(program.tape, program.results, {"z": 1.0}) == {program.results[0]: k}
    assert not (tmp_path / "__pycache__").exists()


def test_files_beside_are_imported_and_read(tmp_path: Path) -> None:
    (tmp_path / "gains.csv").write_text("2.5", encoding="utf-8")
    (tmp_path / "slave.py").write_text("FACTOR = 4.0\n", encoding="utf-8")
    force = """
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
    (tmp_path / "force.py").write_text("from __future__ import annotations\n" + dedent(force))
    (tmp_path / "system.yaml").write_text(
        "name: beside\n"
        "components: {force: {kind: python, file: force.py, files: [gains.csv, slave.py]}}\n"
        "simulation: {stop_time: 0.2, step_size: 0.1}\n",
        encoding="utf-8",
    )
    assert results(tmp_path / "system.yaml")["force.y"] == pytest.approx(10.0)


def test_an_import_beside_must_be_among_the_files(tmp_path: Path) -> None:
    """Else it would not travel, and its changes would go unnoticed."""
    (tmp_path / "gains.py").write_text("GAIN = 2.0\n", encoding="utf-8")
    text = HYDRAULICS.replace("import math", "import math\n\nimport gains")
    with pytest.raises(InputError, match=r"imports gains.py beside it.*'files'"):
        made(tmp_path, text)
    assert isinstance(made(tmp_path, text, files=("gains.py",))[0], PythonSource)


def test_a_folder_beside_cannot_be_imported(tmp_path: Path) -> None:
    """Nor is what a refused file has imported there for others."""
    (tmp_path / "gains").mkdir()
    (tmp_path / "gains" / "high.py").write_text("GAIN = 2.0\n", encoding="utf-8")
    text = HYDRAULICS.replace("import math", "import math\n\nimport gains.high")
    for _ in range(2):
        with pytest.raises(InputError, match=r"imports from the folder gains beside it.*'files'"):
            made(tmp_path, text)
    assert not {"gains", "gains.high"} & sys.modules.keys()


def test_an_import_from_a_folder_beside_is_refused_and_read_anew(tmp_path: Path) -> None:
    """It would not travel; a notebook would go on with what it has imported before."""
    (tmp_path / "lib").mkdir()
    text = HYDRAULICS.replace("import math", "import math\n\nfrom lib.gains import GAIN")
    for gain in ("2.0", "no number"):
        (tmp_path / "lib" / "gains.py").write_text(f"GAIN = float('{gain}')\n", encoding="utf-8")
        message = "imports from the folder lib beside it" if gain == "2.0" else "ValueError"
        with pytest.raises(InputError, match=message):
            made(tmp_path, text, files=("lib/gains.py",))
    assert not [name for name in sys.modules if name.partition(".")[0] == "lib"]


@pytest.mark.parametrize("name", ["fractions", "numpy", "time"])
def test_a_folder_with_the_name_of_a_package_is_no_package(name: str, tmp_path: Path) -> None:
    """NumPy cannot be imported twice."""
    (tmp_path / name).mkdir()
    (tmp_path / name / "notes.py").write_text("", encoding="utf-8")
    text = HYDRAULICS.replace("import math", f"import math\n\nimport {name}")
    before = sys.modules.get(name)
    assert made(tmp_path, text)[1] == ["force.py is recorded as a program"]
    assert before is None or sys.modules[name] is before


@pytest.mark.parametrize(
    ("file", "files", "message"),
    [
        ("force.txt", (), "force.txt is no Python file"),
        ("force.py", ("../other.csv",), "is outside of the system's folder"),
        ("force.py", ("a.csv", "sub/a.csv"), "two files are called a.csv"),
    ],
)
def test_files_that_cannot_travel(
    tmp_path: Path, file: str, files: tuple[str, ...], message: str
) -> None:
    folder = tmp_path / "system"
    (folder / "sub").mkdir(parents=True)
    for name in ("force.txt", "force.py", "../other.csv", "a.csv", "sub/a.csv"):
        (folder / name).write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        make(Config(file=file, files=files), name="force", folder=folder)


def test_a_list_of_the_class_is_refused(tmp_path: Path) -> None:
    """It would be shared, and not be saved for rollback."""
    with pytest.raises(InputError, match=r"Delay.past is a list of the class.*\n.*start"):
        made(tmp_path, DELAY.replace("parameters =", "past = []\n    parameters ="))


def test_a_file_beside_that_is_read_is_not_recorded(tmp_path: Path) -> None:
    """It must be among the files; its changes would go unnoticed."""
    (tmp_path / "gain.txt").write_text("2.0", encoding="utf-8")
    text = HYDRAULICS.replace(
        "import math",
        "import math\nfrom pathlib import Path\n\n"
        "GAIN = float((Path(__file__).parent / 'gain.txt').read_text())",
    )
    found, (line,) = made(tmp_path, text)
    assert isinstance(found, PythonSource)
    assert re.search(r"force\.py:6: FileNotFoundError: .*gain\.txt", line)


ROOT = """
import math

class Force:
    inputs = {"x": "m"}
    outputs = {"f": "N"}

    def calculate(self, t, v):
        try:
            return {"f": math.sqrt(v.x)}
        except ValueError:
            return {"f": 0.0}
"""


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (ROOT, "its results are not those of what it records"),
        (ROOT.replace("v.x", "-1 - v.x**2").replace("ValueError", "KeyError"), "fails at all"),
    ],
)
def test_code_that_fails_is_recorded_only_where_it_does_not(
    tmp_path: Path, text: str, reason: str
) -> None:
    """A program has no value where code raises: what the code then does is lost."""
    found, (line,) = made(tmp_path, text)
    assert isinstance(found, PythonSource)
    assert reason in line


@pytest.mark.parametrize(
    ("head", "told"),
    [
        ("def step(t, h, v)", r"force.py:12: step does not take t, h, v after self"),
        ("def step(self, t, v)", r"force.py:12: step does not take t, h, v after self"),
        ("def step(self, v, t, h)", r"force.py:12: step takes v, t, h in this order"),
        ("async def step(self, t, h, v)", r"force.py:12: step is a generator or async"),
    ],
)
def test_methods_that_cannot_be_called_are_told_with_their_line(
    tmp_path: Path, head: str, told: str
) -> None:
    with pytest.raises(InputError, match=told):
        made(tmp_path, DELAY.replace("def step(self, t, h, v)", head))


@pytest.mark.parametrize("arguments", ["self, *all", "self, time, size, values", "self, t, h, v=0"])
def test_arguments_have_any_names(tmp_path: Path, arguments: str) -> None:
    source, _ = made(tmp_path, DELAY.replace("def step(self, t, h, v)", f"def step({arguments})"))
    assert isinstance(source, PythonSource)


def test_a_mistake_in_a_file_beside_is_told_with_both_lines(tmp_path: Path) -> None:
    (tmp_path / "laws.py").write_text("def law(z):\n    return 1 / 0\n", encoding="utf-8")
    text = HYDRAULICS.replace("import math", "import math\n\nimport laws\n\nlaws.law(0)")
    with pytest.raises(InputError, match=r"force.py:7: in laws.py:2: ZeroDivisionError"):
        made(tmp_path, text, files=("laws.py",))


def test_functions_of_math_and_extremes_are_recorded(tmp_path: Path) -> None:
    program, _ = made(
        tmp_path,
        """
        from math import exp, hypot, pi

        class Force:
            inputs = {"z": "m", "w[2]": "m/s"}
            outputs = {"f[2]": "N"}

            def calculate(self, t, v):
                from math import cos
                limited = max(-1, min(v.z, 1.0, v.w[0]))
                return {"f": [limited * exp(-t) * pi, cos(v.w[1])]}
        """,
    )
    assert isinstance(program, Program)
    assert [v.name for v in program.inputs] == ["z", "w[1]", "w[2]"]
    assert [v.name for v in program.outputs] == ["f[1]", "f[2]"]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('{"rod.vz": "m/s"', '{"rod.vz": "m/sec"', r"hydraulics\.py:16: 'rod.vz': .*sec"),
        ('(0.0, "m3")', '"m3"', r"hydraulics\.py:18: 'oil' of states is 'm3'"),
        ("def rates", "def rate", r"hydraulics\.py:6: there are states and no method rates"),
        ("def rates", "def rate", r"HydraulicPto.rate means nothing here(.|\n)*'rates'"),
        ('"pressure": "Pa"', '"oil": "Pa"', r"'oil' is in outputs and in states"),
        ("import math", "import maths", r"hydraulics\.py:3: ModuleNotFoundError"),
        ("(self, t, v):", "(self, t, v:", r"hydraulics\.py:\d+: not valid Python"),
        ("import math", "import math, os; os._exit(0)", r"hydraulics\.py:3: os\._exit ends the"),
        ("import math", "import math\nfrom os import abort", r"hydraulics\.py:4: os\.abort ends"),
        ("class HydraulicPto:", "def HydraulicPto():", r"one class must have a method .* none"),
    ],
)
def test_mistakes_are_found_before_the_run(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    assert old in HYDRAULICS
    path = system(tmp_path, HYDRAULICS.replace(old, new))
    with pytest.raises(InputError) as caught:
        prepare(load_system(path), build_directory=tmp_path / "build")
    assert re.search(problem, str(caught.value))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("p = self.pressure(v)", "p = self.pressure(v) / int(t < 1)", "ZeroDivisionError"),
        ("p = self.pressure(v)", "p = float('nan') if t > 1 else 1.0", "calculate returns nan"),
        ('"pressure": p, ', "", "calculate: it does not return 'pressure'"),
        ('"pressure": p, ', '"pressure": [p, p], ', "'pressure' has 2 values, 1 are declared"),
        ('"pressure": p, ', '"pressure": "ten", ', "calculate returns 'ten' for pressure"),
        ('"pressure": p, ', '"pressure": p, "heat": p, ', "'heat' is not declared"),
        ("v.rod.vz /", "v.rod.vy /", "AttributeError: no variable rod.vy is declared; .*: vz"),
    ],
)
def test_mistakes_end_the_run_with_file_and_line(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    assert old in HYDRAULICS
    path = system(tmp_path, HYDRAULICS.replace(old, new))
    with pytest.raises((InputError, RunError)) as caught:
        results(path)
    assert re.search(rf"hydraulics\.py:\d+: .*{told}", str(caught.value))


def test_a_recorded_program_that_has_no_value_tells_the_line(tmp_path: Path) -> None:
    path = system(tmp_path, HYDRAULICS.replace("p = self.pressure(v)", "p = math.log(1 - t)"))
    with pytest.raises(RunError, match=r"pressure is -inf at t = 1 s \(hydraulics\.py:35\)"):
        results(path)


def test_an_array_without_a_dimension_is_a_number(tmp_path: Path) -> None:
    """As NumPy's functions give them."""
    (tmp_path / "one.py").write_text(
        "import numpy as np\n\n\nclass One:\n"
        '    outputs = {"u": "m"}\n\n'
        "    def step(self, t, h, v):\n"
        '        return {"u": np.array(3.0)}\n',
        encoding="utf-8",
    )
    (tmp_path / "system.yaml").write_text(
        "name: one\ncomponents: {one: {kind: python, file: one.py}}\n"
        "simulation: {stop_time: 1, step_size: 0.5}\n",
        encoding="utf-8",
    )
    assert results(tmp_path / "system.yaml")["one.u"].tolist() == [0.0, 3.0, 3.0]


def test_sampled_code_is_made_once_for_each_of_its_points(tmp_path: Path) -> None:
    """The default algorithm makes steps again: each begins with the object as it was."""
    source = """
    import math

    class Source:
        outputs = {"u": "m"}

        def calculate(self, t, v):
            return {"u": math.sin(t)}
    """
    (tmp_path / "source.py").write_text(dedent(source), encoding="utf-8")
    (tmp_path / "delay.py").write_text(DELAY, encoding="utf-8")
    (tmp_path / "system.yaml").write_text(
        "name: delayed\n"
        "components:\n"
        "  source: {kind: python, file: source.py}\n"
        "  delay: {kind: python, file: delay.py, step_size: 0.25}\n"
        "connections: [source.u -> delay.u]\n"
        "simulation: {stop_time: 2, step_size: 0.125}\n",
        encoding="utf-8",
    )
    found = results(tmp_path / "system.yaml")
    u, y = found["source.u"][::2], found["delay.y"][::2]
    np.testing.assert_allclose(y[3:], 2.0 * u[:-3], atol=1e-12)


def test_attributes_are_saved_and_come_back() -> None:
    values: dict[str, object] = {
        "a": np.arange(6.0).reshape(2, 3),
        "b": (1, [2.5, None, True]),
        "c": deque([1.0, 2.0], maxlen=4),
        "e": np.float64(0.1),
    }
    again = decoded(encoded(values, "self"))
    assert again["c"] == values["c"]
    assert again["c"].maxlen == 4
    assert again["b"] == values["b"]
    assert again["e"] == values["e"]
    np.testing.assert_array_equal(again["a"], values["a"])


@pytest.mark.parametrize(
    "value",
    [
        np.zeros((0, 3)),
        np.asfortranarray(np.arange(6).reshape(2, 3)),
        np.array([1 + 2j]),
        np.array(["2026-01-01"], dtype="datetime64[D]"),
        np.array([True, False]),
        np.array(["a", "bc"]),
    ],
)
def test_arrays_come_back_with_shape_and_type_and_can_be_changed(value: np.ndarray) -> None:
    again = decoded(encoded(value, "self.a"))
    np.testing.assert_array_equal(again, value)
    assert (again.shape, again.dtype) == (value.shape, value.dtype)
    again[...] = again


def test_a_large_array_is_saved_as_bytes() -> None:
    value = np.random.default_rng(1).random(300_000)
    saved = encoded({"table": value}, "self")
    assert isinstance(saved["table"]["content"], bytes)
    assert decoded(saved)["table"] is not value


def test_a_dict_has_any_keys() -> None:
    value = {1: "one", (2, 3.0): [4], None: 1 + 2j, "a": {True: 0}}
    assert decoded(json.loads(json.dumps(encoded(value, "self.table")))) == value


def test_random_generators_go_on_where_they_were() -> None:
    for generator in (random.Random(5), np.random.default_rng(5)):
        generator.random()
        again = decoded(json.loads(json.dumps(encoded(generator, "self.noise"))))
        assert again.random() == generator.random()


def test_kinds_of_dicts_and_tuples_are_not_taken_for_plain_ones() -> None:
    for value in (defaultdict(list), namedtuple("Pair", "a b")(1, 2)):
        with pytest.raises(CannotBeSavedError):
            encoded(value, "self.table")


def test_what_cannot_be_saved_is_named() -> None:
    with pytest.raises(CannotBeSavedError, match=r"self.files\['log'\] is of type StringIO"):
        encoded({"log": io.StringIO()}, "self.files")


def test_values_are_attributes_and_not_kept() -> None:
    values = Values({"rod.vz": Declared("rod.vz", "m/s", "", 0.0, None)}).filled({"rod.vz": 2.0})
    with pytest.raises(TypeError, match=r"write v.rod.vz, not v\['vz'\]"):
        values.rod["vz"]
    with pytest.raises(CannotBeSavedError, match=r"self.before is the object of values"):
        encoded(values, "self.before")


def test_a_connector_may_have_any_name() -> None:
    names = ("path.x", "path.end.x", "prefix")
    values = Values({name: Declared(name, "m", "", 0.0, None) for name in names})
    found = values.filled(dict(zip(names, (1.0, 2.0, 3.0), strict=True)))
    assert (found.path.x, found.path.end.x, found.prefix) == (1.0, 2.0, 3.0)
    with pytest.raises(AttributeError, match=r"path\.end\.y is declared; there are: x$"):
        found.path.end.y  # noqa: B018


SAMPLED = """
import random

import numpy as np

class Counter:
    inputs = {"rod.vz": "m/s"}
    outputs = {"rod.force_z": "N"}
    count = 0

    def start(self, v):
        self.n = 0
        self.rng = random.Random(1)

    def step(self, t, h, v):
        PLACE
        return {"rod.force_z": 100.0 * number}
"""


@pytest.mark.parametrize(
    "place",
    ["Counter.count += 1; number = Counter.count", "number = np.random.randn()"],
)
def test_a_state_outside_of_the_object_is_told_and_never_made_again(
    tmp_path: Path, place: str
) -> None:
    path = system(tmp_path, SAMPLED.replace("PLACE", place))
    prepared = prepare(load_system(path), build_directory=tmp_path / "build")
    (warning,) = [line for line in prepared.warnings if "rollback" in line]
    assert "hydraulics: " in warning
    assert "give another rod.force_z" in warning
    assert "keep all that changes, random generators with a seed too, in attributes" in warning


def test_a_state_in_attributes_is_not_told(tmp_path: Path) -> None:
    place = "self.n += 1; number = self.n + self.rng.random()"
    path = system(tmp_path, SAMPLED.replace("PLACE", place))
    prepared = prepare(load_system(path), build_directory=tmp_path / "build")
    assert not [line for line in prepared.warnings if "rollback" in line]


def test_a_step_returns_the_outputs_at_its_end(tmp_path: Path) -> None:
    """As the page of the kind says: a controller acts one step after it has read its inputs."""
    clock = """
    class Clock:
        outputs = {"y": "s"}

        def start(self, v):
            return {"y": -1.0}

        def step(self, t, h, v):
            return {"y": t}
    """
    (tmp_path / "clock.py").write_text(dedent(clock), encoding="utf-8")
    (tmp_path / "system.yaml").write_text(
        "name: late\n"
        "components: {clock: {kind: python, file: clock.py, step_size: 0.2}}\n"
        "simulation: {stop_time: 0.5, step_size: 0.1}\n",
        encoding="utf-8",
    )
    found = results(tmp_path / "system.yaml")["clock.y"]
    np.testing.assert_allclose(found, [-1.0, -1.0, 0.0, 0.0, 0.2, 0.2], atol=1e-12)


def test_a_memory_that_calculate_sets_is_a_warning(tmp_path: Path) -> None:
    text = HYDRAULICS.replace('        return {"rod', '        self.last = p\n        return {"rod')
    _, lines = made(tmp_path, text)
    assert lines[0].startswith("warning: force.py:35: calculate sets self.last, but it is called")
    assert not [line for line in made(tmp_path, HYDRAULICS)[1] if "warning" in line]


SLOW = """
import time

class Slow:
    inputs = {"u": "1"}
    outputs = {"y": "1"}

    def step(self, t, h, v):
        time.sleep(0.02)
        return {"y": v.u}
"""


@pytest.mark.parametrize("slow", [True, False])
def test_a_run_tells_that_code_takes_most_of_it(tmp_path: Path, slow: bool) -> None:
    """A hundred steps of 20 ms, beside whatever else a run takes."""
    code = SLOW if slow else SLOW.replace("time.sleep(0.02)", "pass")
    (tmp_path / "slow.py").write_text(code, encoding="utf-8")
    path = tmp_path / "system.yaml"
    path.write_text(
        "name: s\ncomponents: {slow: {kind: python, file: slow.py}}\n"
        "simulation: {stop_time: 1, step_size: 0.01, algorithm: jacobi}\n",
        encoding="utf-8",
    )
    notes = run(prepare(load_system(path)), results=tmp_path / "r.nc").notes
    told = [note for note in notes if "many times faster" in note]
    assert len(told) == slow
    for note in told:
        taken = re.match(r"steps of slow took (\d+)% of the run's ([\d.]+) s", note)
        assert taken
        assert int(taken[1]) / 100 * float(taken[2]) == pytest.approx(2.0, rel=0.5)
