"""The way of a study's parameter to its run and of the result to its cell is that of the docs."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from support.walks import Ways, documented, traced

from m4e_fmi.study import run_study
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.record import Record
from m4e_fmi.study.systems.task import Task

Given = ParamSpec("Given")
Result = TypeVar("Result")
VALUE = "1.4321"
TITLE = "A study's parameter, and its result"
MODEL = """\
name: one
parameters: {m: {value: 1, unit: kg}}
bodies: {mass: {mass: m, inertia: 1}}
joints: {rail: {type: prismatic, child: mass, direction: [1, 0], initial: {q: 0.1}}}
"""
SYSTEM = """\
name: two
components: {left: {model: one.model.yaml}, right: {model: one.model.yaml}}
connections: ["left.joint.rail.q * -20 -> right.joint.rail.effort, units ignored"]
simulation: {stop_time: 20 ms, step_size: 2 ms}
"""
STUDY = f"""\
name: masses
system: two.system.yaml
vary: {{right.m: [{VALUE}, 2]}}
wanted: {{far: {{variable: right.joint.rail.q, statistic: maximum}}}}
"""


class Here(Executor):
    """Performs each task in this thread, as it comes."""

    def submit(
        self, fn: Callable[Given, Result], /, *args: Given.args, **kwargs: Given.kwargs
    ) -> Future[Result]:
        future: Future[Result] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def is_parameter(value: object) -> bool:
    return isinstance(value, Study | Task) or (type(value) in (str, float) and str(value) == VALUE)


def is_result(value: object) -> bool:
    return isinstance(value, Record)


def test_a_parameter_passes_the_files_that_the_docs_name(tmp_path: Path) -> None:
    for name, text in (("one.model", MODEL), ("two.system", SYSTEM), ("study", STUDY)):
        (tmp_path / f"{name}.yaml").write_text(text)
    there, back = Ways(is_parameter), Ways(is_result)

    def seen(*event: Any) -> None:
        there.seen(*event)
        back.seen(*event)

    with traced(seen):
        build = tmp_path / "build"
        run_study(tmp_path / "study.yaml", build_directory=build, executor=Here())
    names = documented(TITLE)
    assert len(names) <= 8
    task = "m4e_fmi/study/systems/task.py"
    to_run = names[: names.index(task) + 1]
    assert to_run in there.shortest("m4e_fmi/files/document.py", task)
    record, *backwards = back.shortest("m4e_fmi/study/record.py", names[-1])[0]
    assert {*names} == {*to_run, record, *backwards}
