"""Studies of models: bits of ensembles, keys, units of columns, systems as one program."""

from __future__ import annotations

import signal
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.small_study import written_study

from m4e_fmi.runtime.engine import Engine
from m4e_fmi.study import StudyOutcome, run_study
from m4e_fmi.study.programs import chunks
from m4e_fmi.study.programs.chunks import in_threads

STUDY = """\
name: carts
model: cart.model.yaml
simulation: {stop_time: 2}
sample: {method: latin_hypercube, count: 20, seed: 3, of: {k: [30, 50], joint.hinge.q: [0.1, 0.5]}}
wanted:
  swing: {variable: joint.hinge.q, statistic: maximum}
  push: {variable: load.spring.effort, statistic: rms}
"""


def made(path: Path, **given: Any) -> StudyOutcome:
    return run_study(path, build_directory=path.parent / "build", **given)


def test_a_compiled_ensemble_has_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written_study(tmp_path, STUDY)
    first = made(path, jobs=1)
    compiled: list[bool] = []
    compile_ = Engine.compile

    def noted(engine: Engine) -> bool:
        compiled.append(compile_(engine))
        return compiled[-1]

    monkeypatch.setattr(Engine, "compile", noted)
    monkeypatch.setattr(chunks, "COMPILING_PAYS", 0.0)
    second = made(path, jobs=1, fresh=True)
    assert set(compiled) == {True}  # after the first part, which shows how long they take
    for name in ("swing", "push"):
        np.testing.assert_array_equal(first.data[name], second.data[name])


def test_keys_of_the_model_are_varied(tmp_path: Path) -> None:
    """The mass is a number of the program: there is one program for each."""
    text = STUDY.replace("sample:", "vary: {bodies.bob.mass: [1, 2]}\nsample:")
    path = written_study(tmp_path, text.replace("count: 20", "count: 2"))
    found = made(path).data["swing"]
    model = (tmp_path / "cart.model.yaml").read_text("utf-8")
    (tmp_path / "cart.model.yaml").write_text(model.replace("bob: {mass: 1", "bob: {mass: 2"))
    path.write_text(STUDY.replace("count: 20", "count: 2"), "utf-8")
    np.testing.assert_array_equal(found.sel(mass=2), made(path).data["swing"])
    assert not np.array_equal(found.sel(mass=1), found.sel(mass=2))


def test_angles_of_an_attitude_are_start_values_of_all_runs(tmp_path: Path) -> None:
    """As for single simulations: no variable is called so, the states are a quaternion."""
    (tmp_path / "top.model.yaml").write_text(
        "name: top\ndimensions: 3\ngravity: 0\n"
        "parameters: {m: {value: 2, unit: kg}}\n"
        "bodies: {hull: {mass: m, inertia: [1, 2, 3]}}\n"
        "joints: {free: {type: floating, child: hull}}\n",
        encoding="utf-8",
    )
    path = tmp_path / "study.yaml"
    path.write_text(
        "name: tops\nmodel: top.model.yaml\nsimulation: {stop_time: 0.1}\n"
        "start: {body.hull.phi: 30 deg}\nvary: {m: [2, 4]}\n"
        "wanted: {phi: {variable: body.hull.phi, statistic: mean}}\n",
        encoding="utf-8",
    )
    np.testing.assert_allclose(made(path).data["phi"], np.radians(30.0), rtol=1e-12)


def test_interruption_does_not_wait_for_a_call() -> None:
    go_on = threading.Event()
    calls = [lambda: "first", lambda: go_on.wait(20.0)]
    made = in_threads(iter(calls), 1)
    assert next(made) == "first"
    timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
    began = time.monotonic()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # it may be ignored
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            next(made)
    finally:
        signal.signal(signal.SIGINT, before)
    took = time.monotonic() - began
    go_on.set()
    assert took < 5.0
