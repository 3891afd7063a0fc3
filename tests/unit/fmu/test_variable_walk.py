"""A variable's way into the description of an FMU, traced, is the one that the docs show."""

import re
import sys
from pathlib import Path
from types import FrameType

import pytest

import m4e_fmi
from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource, build_fmu
from m4e_fmi.program import Program, Recorder, Variable

NAME = "walked"
PACKAGE = Path(m4e_fmi.__file__).parent
OTHERS = ("native_members", "python_members", "python_slave")  # of the archive


def program() -> Program:
    recorder = Recorder("tiny", "one state")
    recorder.rate(NAME, -recorder.state(Variable(NAME, "m", "what is followed", start=1.0)))
    return recorder.program()


def slave() -> PythonSource:
    description = ModelDescription("tiny", "one output", (FmuVariable(NAME, "m", "followed"),))
    return PythonSource(description, "slave:Slave", {"slave.py": Path(__file__)}, {})


def holds(value: object, depth: int = 3) -> bool:
    if isinstance(value, str | bytes):  # its name, or what that is in
        return NAME in str(value)
    value = [*value, *value.values()] if isinstance(value, dict) else value
    if isinstance(value, list | tuple | set) and depth > 0:
        return any(holds(one, depth - 1) for one in value)
    return getattr(value, "name", None) == NAME


@pytest.mark.parametrize("kind", ["native 2", "native 3", "Python 2", "slave 2"])
def test_a_variable_passes_the_files_that_the_docs_name(kind: str, tmp_path: Path) -> None:
    source = slave() if kind == "slave 2" else program()
    seen, elsewhere = set[Path](), list[FrameType]()

    def trace(frame: FrameType, event: str, result: object) -> None:
        if event == "call" and frame.f_code.co_name in OTHERS:
            elsewhere.append(frame)
        if not elsewhere and holds([*frame.f_locals.values(), event == "return" and result]):
            seen.add(Path(frame.f_code.co_filename))
        if event == "return" and frame in elsewhere:
            elsewhere.remove(frame)

    sys.setprofile(trace)
    build_fmu(source, tmp_path / "a.fmu", native="native" in kind, fmi=kind[-1])
    sys.setprofile(None)
    page = (PACKAGE.parent / "docs/architecture.md").read_text()
    walk = page.split("\n## A variable from description to file")[1].split("\n## ")[0]
    told = {PACKAGE.parent / name for name in re.findall(r"\n\d+\. `([^`]+)`", walk)}
    found = {path for path in seen if path.is_relative_to(PACKAGE)}
    assert found < told if kind == "slave 2" else found == told
    assert len(told) <= 7
