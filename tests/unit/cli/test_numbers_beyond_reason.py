"""Times and counts beyond reason are refused at their place, before arrays of their size."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from support.command_line import refused

import m4e_fmi as m4e
from m4e_fmi.cosim import Simulation
from m4e_fmi.errors import InputError

MODEL = """name: mass
bodies: {m: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: m, direction: [1, 0]}}
"""
SYSTEM = """name: alone
components:
  p: {model: mass.model.yaml%s}
simulation: {%s}
"""
STUDY = """name: many
%s: %s
simulation: {%s}
vary: {%s}
wanted: {x: {variable: %s, statistic: mean}}
"""
SOUND = "stop_time: 1, step_size: 0.01"


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The text of a refusal that took less than 2 s of processor time."""
    began = time.process_time()
    text = refused(capsys, *arguments, *(["--no-plot"] if arguments[0] != "study" else []))
    assert time.process_time() - began < 2.0
    return text


@pytest.fixture(autouse=True)
def files(here: Path) -> Path:
    (here / "mass.model.yaml").write_text(MODEL, encoding="utf-8")
    (here / "alone.system.yaml").write_text(SYSTEM % ("", SOUND), encoding="utf-8")
    return here


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--stop-time", "1e300"], "stop_time 1e+300 s: times are counted up to 4e+09 s"),
        (["--output-interval", "1e-8"], "1e+09 rows in 10 s, 100,000,000 at most"),
        (["--method", "rk4", "--step-size", "1e-11"], "1e+12 steps in 10 s"),
    ],
)
def test_of_a_simulation(capsys, options, message):
    assert message in refusal(capsys, "simulate", "mass.model.yaml", *options)


@pytest.mark.parametrize(
    ("own", "simulation", "place"),
    [
        ("", "stop_time: 1e300, step_size: 0.01", "4:14: stop_time"),
        ("", "stop_time: 1e6, step_size: 1e-6", "4:30: step_size"),
        ("", "stop_time: 1e4, step_size: 1e-6, output_interval: 1e-5", "4:47: output_interval"),
        (", step_size: 1e-12", SOUND, "3:31: component 'p': step_size"),
    ],
)
def test_of_a_system(files, capsys, own, simulation, place):
    (files / "alone.system.yaml").write_text(SYSTEM % (own, simulation), encoding="utf-8")
    assert f"system.yaml:{place}" in refusal(capsys, "run", "alone.system.yaml")


@pytest.mark.parametrize(
    ("simulation", "vary", "place"),
    [
        ("stop_time: 1e300", "body.m.mass: [1]", "3:14: stop_time"),
        ("stop_time: 1e12, output_interval: 1e11", "p: [1]", "3:14: stop_time"),
        ("stop_time: 1e7", "", "3:1: output_interval"),
        ("stop_time: 10, method: rk4, step_size: 1e-11", "", "3:42: step_size"),
        ("output_interval: 1", "simulation.stop_time: [1, 1e300]", "4:8: stop_time"),
        ("stop_time: 1", "simulation.output_interval: [0.1, 1e-9]", "4:8: output_interval"),
    ],
)
def test_of_a_study_of_a_model(files, capsys, simulation, vary, place):
    text = STUDY % ("model", "mass.model.yaml", simulation, vary, "body.m.x")
    (files / "many.study.yaml").write_text(text, encoding="utf-8")
    assert f"study.yaml:{place}" in refusal(capsys, "study", "many.study.yaml")


@pytest.mark.parametrize(
    "simulation", ["stop_time: 1e300", "stop_time: 1e9, step_size: 0.01", "step_size: 1e-11"]
)
def test_of_a_study_of_a_system(files, capsys, simulation):
    text = STUDY % ("system", "alone.system.yaml", simulation, "", "p.body.m.x")
    (files / "many.study.yaml").write_text(text, encoding="utf-8")
    assert "study.yaml:3:" in refusal(capsys, "study", "many.study.yaml")


def test_of_samples_of_a_study(files, capsys):
    text = STUDY % ("model", "mass.model.yaml", "stop_time: 1", "", "body.m.x")
    text += "sample: {method: sobol, count: 1000000000, of: {gravity: [1, 2]}}\n"
    (files / "many.study.yaml").write_text(text, encoding="utf-8")
    assert "study.yaml:6:32: sample.count" in refusal(capsys, "study", "many.study.yaml")


def test_of_arguments_in_python():
    with pytest.raises(InputError, match=r"up to 4e\+09"):
        m4e.simulate("mass.model.yaml", stop_time=1e300)
    with pytest.raises(InputError, match="at most"):
        m4e.simulate("mass.model.yaml", stop_time=1.0, output_interval=1e-9)
    with pytest.raises(InputError, match="at most"):
        m4e.load_system("alone.system.yaml").changed(stop_time=1e9)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"step_size": 0.1, "stop_time": 1e300}, "stop_time 1e+300 s"),
        ({"step_size": 0.0}, "step_size 0 s: expected 1e-9 s or more"),
        ({"step_size": -1.0}, "step_size -1 s: expected 1e-9 s or more"),
        ({"step_size": 0.1, "output_interval": 0.0}, "output_interval 0 s is not a multiple"),
        ({"step_size": 0.1, "output_interval": -0.1}, "output_interval -0.1 s is not a multiple"),
    ],
)
def test_a_wrong_time_has_one_problem(given, message):
    with pytest.raises(InputError) as caught:
        Simulation(**{"stop_time": 1.0, **given})
    (problem,) = caught.value.problems
    assert message in problem.message
    with pytest.raises(InputError, match="the step size must be positive"):
        m4e.simulate("mass.model.yaml", stop_time=1.0, method="rk4", step_size=0.0)
