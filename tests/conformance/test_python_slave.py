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


class TestPythonSlave:
    @pytest.fixture
    def source(self, tmp_path: Path) -> PythonSource:
        here = tmp_path / "source"
        here.mkdir()
        (here / "counter.py").write_text(SLAVE)
        (here / "helper.py").write_text('TEXT = "é"\n')
        variables = (
            FmuVariable("u", "1", "what goes wrong", "input", start=0.0),
            FmuVariable(
                "label", "", "a text", "parameter", "fixed", "exact", "start %s é", type="String"
            ),
            output("count"),
            output("size"),
            output("note"),
        )
        return PythonSource(
            ModelDescription("counter", "counts steps", variables),
            "counter:Counter",
            {name: here / name for name in ("counter.py", "helper.py")},
            {"note.txt": b"12345"},
        )

    @pytest.fixture
    def counter(self, source: PythonSource, tmp_path: Path) -> Path:
        return build_fmu(source, tmp_path / "counter.fmu")

    def test_no_findings(self, counter: Path) -> None:
        assert validate_fmu(str(counter)) == []

    def test_it_runs(self, counter: Path, load: Load) -> None:
        instance = load("python", counter).initialise()
        assert instance["note"] == 5 + len("start %s é")
        for k in range(3):
            instance.step(0.1 * k, 0.1)
        assert instance.get(["count", "size"]) == [3.0, 6.0]

    def test_texts_can_be_set_and_read(self, counter: Path, load: Load) -> None:
        instance = load("python", counter)
        reference = instance.references["label"]
        assert instance.fmu.getString([reference])[0].decode() == "start %s é"
        instance.fmu.setString([reference], ["ünï"])
        assert instance.initialise()["note"] == 8.0
        assert instance.fmu.getString([reference])[0].decode() == "ünï"

    @pytest.mark.parametrize(
        ("u", "text"),
        [
            (1.0, "ValueError: 100 % wrong: %s %n é (t = 0.5 s)"),
            (2.0, "SystemExit: 3 (t = 0.5 s)"),
            (3.0, "ValueError: lone \\ud800 surrogate (t = 0.5 s)"),
        ],
    )
    def test_a_step_that_raises(self, counter: Path, load: Load, u: float, text: str) -> None:
        instance = load("python", counter).initialise()
        instance.step(0.0, 0.5)
        instance.set({"u": u})
        discarded(lambda: instance.step(0.5, 0.5))
        assert instance.last_error == text
        ((status, message),) = [m for m in instance.heard() if m[0] != 0]
        assert status == 3
        assert message == f"instance: {text}"
        details = [m for s, m in instance.heard() if s == 0]
        assert any(detail.startswith("Traceback") for detail in details)

    def test_outputs_can_be_read_after_terminate(self, counter: Path, load: Load) -> None:
        """Although the slave has released what it computes them from."""
        instance = load("python", counter).initialise()
        instance.step(0.0, 0.1)
        instance.fmu.terminate()
        assert instance["count"] == 1.0

    def test_an_output_that_is_no_number(self, counter: Path, load: Load) -> None:
        instance = load("python", counter).initialise({"u": 7.0})
        assert math.isnan(instance["count"])
        assert "an output is no number" in instance.last_error
        assert "complex" in instance.last_error
        discarded(lambda: instance.step(0.0, 0.1))

    def test_percent_signs_in_log_messages(self, counter: Path, load: Load) -> None:
        instance = load("python", counter).initialise({"u": 5.0})
        instance.step(0.0, 0.1)
        assert (0, "percent %s %n %d") in instance.heard()

    def test_state_with_bytes_replays(self, counter: Path, load: Load) -> None:
        first = load("python", counter).initialise()
        first.step(0.0, 0.1)
        state = first.fmu.getFMUstate()
        saved = first.fmu.serializeFMUstate(state)
        first.step(0.1, 0.1)
        expected = first.get(["count", "size"])
        for _ in range(2):  # what was saved is not what the slave goes on changing
            first.fmu.setFMUstate(state)
            assert first.get(["count", "size"]) == [1.0, 4.0]
            first.step(0.1, 0.1)
            assert first.get(["count", "size"]) == expected
        second = load("python", counter).initialise()
        second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(saved))
        second.step(0.1, 0.1)
        assert second.get(["count", "size"]) == expected

    def test_a_state_that_cannot_be_saved(self, counter: Path, load: Load) -> None:
        instance = load("python", counter).initialise({"u": 6.0})
        instance.fmu.getFMUstate()
        assert instance.last_error == "RuntimeError: nothing to save (t = 0 s)"
        discarded(lambda: instance.step(0.0, 0.1))

    def test_a_state_that_is_no_json(self, counter: Path, load: Load) -> None:
        instance = load("python", counter).initialise({"u": 4.0})
        instance.step(0.0, 0.1)
        state = instance.fmu.getFMUstate()
        saved = instance.fmu.serializeFMUstate(state)
        instance.step(0.1, 0.1)  # the instance itself goes on
        instance.fmu.setFMUstate(instance.fmu.deSerializeFMUstate(saved))
        assert "object cannot be saved" in instance.last_error

    @pytest.mark.parametrize("how", ["terminate", "free", "both", "reset"])
    def test_finish_is_called_once_and_may_fail(
        self, counter: Path, tmp_path: Path, how: str
    ) -> None:
        diary = tmp_path / "diary.txt"
        instance = Instance(counter, tmp_path / "unpacked")
        instance.fmu.setString([instance.references["label"]], [str(diary)])
        instance.initialise()
        assert not diary.exists()
        if how in ("terminate", "both"):
            instance.fmu.terminate()
            instance.fmu.terminate()
            assert diary.read_text() == "finished\n"
        if how == "reset":
            instance.fmu.reset()
            assert diary.read_text() == "finished\n"
        instance.fmu.freeInstance()
        shutil.rmtree(instance.folder)
        assert diary.read_text() == "finished\n"

    def test_a_class_with_do_step_only(self, source: PythonSource, load: Load) -> None:
        source.modules["counter.py"].write_text(
            "from .slave_base import M4eSlave\n\n\n"
            "class Counter(M4eSlave):\n"
            "    def do_step(self, current_time, step_size):\n"
            "        self.values[self.index['count']] += 1.0\n"
            "        return True\n"
        )
        path = build_fmu(source, source.modules["counter.py"].with_name("only.fmu"))
        assert validate_fmu(str(path)) == []
        instance = load("python", path).initialise()
        instance.step(0.0, 0.1)
        instance.step(0.1, 0.1)
        assert instance["count"] == 2.0

    def test_an_empty_class(self, source: PythonSource, load: Load) -> None:
        """Twice: PythonFMU's binary crashes on the second instance of a class without methods."""
        source.modules["counter.py"].write_text(
            "from .slave_base import M4eSlave\n\n\nclass Counter(M4eSlave):\n    pass\n"
        )
        path = build_fmu(source, source.modules["counter.py"].with_name("empty.fmu"))
        for _ in range(3):
            instance = load("python", path).initialise()
            instance.step(0.0, 0.1)
            assert instance["count"] == 0.0

    def test_a_syntax_error_is_found_when_building(
        self, source: PythonSource, tmp_path: Path
    ) -> None:
        source.modules["helper.py"].write_text("TEXT = (\n")
        with pytest.raises(InputError, match=r"helper\.py:1:8: not valid Python"):
            build_fmu(source, tmp_path / "broken.fmu")

    @pytest.mark.parametrize("slave", ["other:Counter", "counter", "counter:"])
    def test_a_slave_that_is_not_there_is_found_when_building(
        self, source: PythonSource, tmp_path: Path, slave: str
    ) -> None:
        with pytest.raises(ValueError, match="is not 'module:Class'"):
            build_fmu(replace(source, slave=slave), tmp_path / "broken.fmu")

    def test_two_variables_of_one_name(self, source: PythonSource, tmp_path: Path) -> None:
        variables = (*source.description.variables, output("count"))
        description = replace(source.description, variables=variables)
        with pytest.raises(ValueError, match=r"variables named twice: \['count'\]"):
            build_fmu(replace(source, description=description), tmp_path / "twice.fmu")
