"""FMUs of Python code of any kind."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu
from support.fmu_instances import Instance, discarded

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource, build_fmu

Load = Callable[..., Instance]


SLAVE = '''\
"""A slave for tests: counts steps, remembers in odd ways, fails on demand."""
import sys

from .helper import TEXT
from .slave_base import M4eSlave

class Counter(M4eSlave):
    def initialise(self):
        self.steps = [0]
        self.blob = bytes([0, 255, 37])
        self.extra = None

    def step(self, t, h):
        u = self.values[self.index["u"]]
        if u == 1.0:
            raise ValueError("100 % wrong: %s %n " + TEXT)
        if u == 2.0:
            sys.exit(3)
        if u == 3.0:
            raise ValueError("lone \\ud800 surrogate")
        if u == 4.0:
            self.extra = object()
        if u == 5.0:
            self.log("percent %s %n %d")
        self.steps[0] += 1
        self.blob += b"\\x00"

    def update(self):
        self.values[self.index["count"]] = float(self.steps[0])
        self.values[self.index["size"]] = float(len(self.blob))
        note = (self.resources / "note.txt").read_text(encoding="utf-8")
        self.values[self.index["note"]] = float(len(note)) + len(self.text["label"])
        if self.values[self.index["u"]] == 7.0:
            self.values[self.index["count"]] = (-1.0) ** 0.5

    def save(self):
        if self.values[self.index["u"]] == 6.0:
            raise RuntimeError("nothing to save")
        return {"steps": self.steps, "blob": self.blob, "extra": self.extra}

    def restore(self, saved):
        self.steps, self.blob, self.extra = saved["steps"], saved["blob"], saved["extra"]

    def finish(self):
        self.steps = None
        diary = self.text["label"]
        if diary.startswith("/"):
            with open(diary, "a") as stream:
                stream.write("finished\\n")
        raise RuntimeError("finish fails, 100 % sure")
'''


def output(name: str) -> FmuVariable:
    return FmuVariable(name, "1", f"the {name}", "output", initial="calculated")


@pytest.fixture
def source(tmp_path: Path) -> PythonSource:
    here = tmp_path / "source"
    here.mkdir()
    (here / "counter.py").write_text(SLAVE)
    (here / "helper.py").write_text('TEXT = "é"\n')
    label = FmuVariable(
        "label", "", "a text", "parameter", "fixed", "exact", "start %s é", type="String"
    )
    wrong = FmuVariable("u", "1", "what goes wrong", "input", start=0.0)
    return PythonSource(
        ModelDescription(
            "counter", "counts", (wrong, label, *map(output, ("count", "size", "note")))
        ),
        "counter:Counter",
        {name: here / name for name in ("counter.py", "helper.py")},
        {"note.txt": b"12345"},
    )


@pytest.fixture
def counter(source: PythonSource, tmp_path: Path) -> Path:
    return build_fmu(source, tmp_path / "counter.fmu")


def test_it_runs(counter: Path, load: Load) -> None:
    """Texts can be set and read; outputs also after the end, when the slave has released itself."""
    assert validate_fmu(str(counter)) == []
    instance = load("python", counter)
    reference = instance.references["label"]
    assert instance.fmu.getString([reference])[0].decode() == "start %s é"
    instance.fmu.setString([reference], ["ünï"])
    assert instance.initialise()["note"] == 8.0
    assert instance.fmu.getString([reference])[0].decode() == "ünï"
    for k in range(3):
        instance.step(0.1 * k, 0.1)
    instance.fmu.terminate()
    assert instance.get(["count", "size"]) == [3.0, 6.0]


@pytest.mark.parametrize(
    ("u", "text"),
    [
        (1.0, "ValueError: 100 % wrong: %s %n é (t = 0.5 s)"),
        (2.0, "SystemExit: 3 (t = 0.5 s)"),
        (3.0, "ValueError: lone \\ud800 surrogate (t = 0.5 s)"),
    ],
)
def test_a_step_that_raises(counter: Path, load: Load, u: float, text: str) -> None:
    instance = load("python", counter).initialise()
    instance.step(0.0, 0.5)
    instance.set({"u": u})
    discarded(lambda: instance.step(0.5, 0.5))
    assert instance.last_error == text
    ((status, message),) = [m for m in instance.heard() if m[0] != 0]
    assert (status, message) == (3, f"instance: {text}")
    assert any(m.startswith("Traceback") for s, m in instance.heard() if s == 0)


def test_an_output_that_is_no_number(counter: Path, load: Load) -> None:
    instance = load("python", counter).initialise({"u": 7.0})
    assert math.isnan(instance["count"])
    assert "an output is no number" in instance.last_error
    assert "complex" in instance.last_error
    discarded(lambda: instance.step(0.0, 0.1))


def test_a_state_with_bytes_replays(counter: Path, load: Load) -> None:
    first, second = (load("python", counter).initialise() for _ in range(2))
    first.step(0.0, 0.1)
    state = first.save()
    saved = first.pack(state)
    first.step(0.1, 0.1)
    expected = first.get(["count", "size"])
    for _ in range(2):  # what was saved is not what the slave goes on changing
        first.restore(state)
        assert first.get(["count", "size"]) == [1.0, 4.0]
        first.step(0.1, 0.1)
        assert first.get(["count", "size"]) == expected
    second.restore(second.unpack(saved))
    second.step(0.1, 0.1)
    assert second.get(["count", "size"]) == expected


def test_states_that_cannot_be_saved(counter: Path, load: Load) -> None:
    """Because the slave fails; or as bytes, where the instance itself goes on."""
    instance = load("python", counter).initialise({"u": 6.0})
    instance.save()
    assert instance.last_error == "RuntimeError: nothing to save (t = 0 s)"
    discarded(lambda: instance.step(0.0, 0.1))
    instance = load("python", counter).initialise({"u": 4.0})
    instance.step(0.0, 0.1)
    saved = instance.pack(instance.save())
    instance.step(0.1, 0.1)
    instance.restore(instance.unpack(saved))
    assert "object cannot be saved" in instance.last_error


@pytest.mark.parametrize("how", ["terminate", "free", "both", "reset"])
def test_finish_is_called_once_and_may_fail(counter: Path, tmp_path: Path, how: str) -> None:
    diary = tmp_path / "diary.txt"
    instance = Instance(counter, tmp_path / "unpacked")
    instance.fmu.setString([instance.references["label"]], [str(diary)])
    instance.initialise()
    assert not diary.exists()
    if how in ("terminate", "both"):
        instance.fmu.terminate()
        instance.fmu.terminate()
    if how == "reset":
        instance.fmu.reset()
    assert how == "free" or diary.read_text() == "finished\n"
    instance.fmu.freeInstance()
    shutil.rmtree(instance.folder)
    assert diary.read_text() == "finished\n"


DO_STEP = """
    def do_step(self, current_time, step_size):
        self.values[self.index['count']] += 1.0
        return True
"""


@pytest.mark.parametrize(("body", "count"), [(DO_STEP, 2.0), ("    pass\n", 0.0)])
def test_a_class_with_little(source: PythonSource, load: Load, body: str, count: float) -> None:
    """Often: PythonFMU's binary crashes on the second instance of a class without methods."""
    head = "from .slave_base import M4eSlave\n\n\nclass Counter(M4eSlave):\n"
    source.modules["counter.py"].write_text(head + body)
    path = build_fmu(source, source.modules["counter.py"].with_name("only.fmu"))
    for _ in range(3):
        instance = load("python", path).initialise()
        instance.step(0.0, 0.1)
        instance.step(0.1, 0.1)
        assert instance["count"] == count


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda s: s.modules["helper.py"].write_text("TEXT = (\n") and s,
            r"helper\.py:1:8: not val",
        ),
        (lambda s: replace(s, slave="other:Counter"), "is not 'module:Class'"),
        (lambda s: replace(s, slave="counter"), "is not 'module:Class'"),
        (
            lambda s: replace(
                s,
                description=replace(
                    s.description, variables=(*s.description.variables, output("count"))
                ),
            ),
            r"variables named twice: \['count'\]",
        ),
    ],
)
def test_mistakes_are_found_when_building(
    source: PythonSource, tmp_path: Path, change: Callable, message: str
) -> None:
    with pytest.raises((InputError, ValueError), match=message):
        build_fmu(change(source), tmp_path / "broken.fmu")
