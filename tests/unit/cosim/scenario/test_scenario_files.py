"""Scenarios in system files: what is read, recorded and told; what is refused, and where."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, system

from m4e_fmi.cosim import Action, load, prepare, run, save_system
from m4e_fmi.cosim.input_checks.inputs import checked_inputs
from m4e_fmi.cosim.load import load_system
from m4e_fmi.errors import InputError
from m4e_fmi.report.text.summaries import run_summary

FILE = """\
name: small
components:
  body: {{fmu: mass.fmu, start: {{body.m.x: 1.0}}}}
  spring: {{fmu: spring.fmu}}
connections:
  - body.m <-> spring.end
simulation: {{stop_time: 3, step_size: 0.02}}
scenario:
  {}
"""


def written(fmus: Fmus, folder: Path, *actions: str) -> Path:
    """A system file with these actions, beside its FMUs."""
    for name in ("mass", "spring"):
        shutil.copy(fmus(f"{name}+state+inputs"), folder / f"{name}.fmu")
    path = folder / "system.yaml"
    path.write_text(FILE.format("\n  ".join(actions)), encoding="utf-8")
    return path


def test_actions_are_recorded_and_told(c_fmu: Fmus, tmp_path: Path) -> None:
    (tmp_path / "soft.yaml").write_text("values: {spring.damping: 0.5}\n", encoding="utf-8")
    path = written(
        c_fmu,
        tmp_path,
        "stuck: {at: 505 ms, for: 1 s, freeze: spring.end.x}",
        "soft: {when: body.body.m.x < -20 cm, parameters: soft.yaml}",
        "never: {when: body.body.m.x > 5 m, offset: {spring.end.x: 1}}",
        "later: {at: 10, freeze: spring.end.x}",
    )
    outcome = run(path, results=tmp_path / "small.nc", build_directory=tmp_path / "build")
    found = load(tmp_path / "small.nc")
    stuck, soft = (found[f"scenario.{name}"].values for name in ("stuck", "soft"))
    assert np.array_equal(stuck, (found.time >= 0.505) & (found.time < 1.505))
    below = found["body.body.m.x"].values < -0.2
    first = found.time[np.argmax(below)]
    assert np.array_equal(soft, found.time >= first)
    assert not found["scenario.never"].values.any()
    lines = (
        "stuck: from t = 0.505 s to 1.505 s",
        f"soft: from t = {first:.9g} s on: spring.damping = 0.5 N.s/m",
        "never: never happened (when body.body.m.x > 5 m)",
        "later: never happened (at 10 s)",
    )
    assert outcome.scenario == lines
    assert found.attributes["scenario"] == "\n".join(lines)
    assert "scenario:\n  " + "\n  ".join(lines) in run_summary(outcome)
    assert "no energy balance there" in "\n".join(outcome.notes)
    assert not outcome.energy


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ("{at: 1, freeze: spring.end.z}", "no variable 'end.z'\n.*\n.*\n.*did you mean"),
        ("{at: 1, freeze: sprin.end.x}", "no component 'sprin'"),
        ("{at: 1, freeze: body.mass}", "body.mass carries no signal: nobody takes it"),
        ("{at: 1, offset: {body.damping: 1}}", "carries no signal: it is not connected"),
        ("{at: 1, offset: {spring.end.x: 2 kg}}", "'2 kg' for spring.end.x is wrong"),
        ("{at: 1, set: {spring.end.x: 1}}", "is connected to body.body.m.x"),
        ("{at: 1, set: {body.mass: 1}}", "is a fixed parameter"),
        ("{at: 1, ramp: {body.damping: 1}}", "a ramp without a time"),
        ("{at: 1, for: 1, ramp: {body.damping: 1}, within: 2}", "ends the ramp after 1 s"),
        ("{at: 1, noise: {spring.end.x: 1}, seed: 1, every: 1e-9}", "over 10000 drawings in a"),
        ("{at: 1, when: body.body.m.x > 1, freeze: spring.end.x}", "both 'at' and 'when'"),
        ("{freeze: spring.end.x}", "neither 'at' nor 'when'"),
        ("{at: 1}", "does nothing"),
        ("{at: -1, freeze: spring.end.x}", "before the start time of 0 s"),
        ("{at: .nan, freeze: spring.end.x}", "'at' is nan s"),
        ("{at: .inf, freeze: spring.end.x}", "'at' is inf s"),
        ("{when: body.body.m.x > 1e999, freeze: spring.end.x}", "give a finite number"),
        ("{at: 1, offset: {spring.end.x: .nan}}", "finite"),
        ("{at: 1, delay: {spring.end.x: .nan}}", "give a time above 0"),
        ("{at: 1, for: .nan, freeze: spring.end.x}", "'for' is nan s"),
        ("{at: 1, set: {body.damping: .inf}}", "give a finite number"),
        ("{at: 1, for: 0 s, freeze: spring.end.x}", "'for' is 0 s"),
        ("{at: 1, freeze: spring.end.x, seed: 1}", "'freeze' has no 'seed'"),
        ("{at: 1, noise: {spring.end.x: 1}, every: 1}", "noise without a seed"),
        ("{at: 1, noise: {spring.end.x: 1}, seed: 1}", "noise without 'every'"),
        ("{at: 1, dropout: spring.end.x, share: 0.2, seed: 1}", "without 'every'"),
        ("{at: 1, noise: {spring.end.x: -1}, seed: 1, every: 1}", "deviation is not negative"),
        ("{at: 1, dropout: spring.end.x, share: 2, seed: 1, every: 1}", "less than or equal to 1"),
        ("{at: 1, delay: {spring.end.x: 0}}", "give a time above 0"),
        ("{at: 1, replace: {spring.end.x: body.body.m.vx}}", "it is in m/s, spring.end.x in m"),
        ("{when: body.body.m.x == 1, freeze: spring.end.x}", "hardly ever equal"),
        ("{when: body.body.m.x >, freeze: spring.end.x}", "is not a condition"),
        ("{when: __import__('os').name > 1, freeze: spring.end.x}", "no component"),
        ("{when: body.body.m.x > 1 kg, freeze: spring.end.x}", "'1 kg' is no value"),
        ("{at: 1, broken_line: spring.line_1}", "no line 'spring.line_1' that can part"),
        ("{at: 1, parameters: missing.yaml}", "no such file: .*missing.yaml"),
        ("{at: 1, freeze: spring.end.x, until: 3}", "until"),
    ],
)
def test_what_is_refused(c_fmu: Fmus, tmp_path: Path, action: str, message: str) -> None:
    path = written(c_fmu, tmp_path, f"wrong: {action}")
    with pytest.raises(InputError, match=message) as caught:
        prepare(path, build_directory=tmp_path / "build")
    (problem,) = caught.value.problems
    assert (problem.file, problem.line) == (str(path), 9)


def test_all_problems_are_found_before_anything_is_built(c_fmu: Fmus, tmp_path: Path) -> None:
    path = written(
        c_fmu,
        tmp_path,
        "one: {at: 1, freeze: spring.end.z}",
        "two: {at: 1, set: {body.mass: 1}}",
        "three: {when: body.body.m.x > 1 kg, freeze: spring.end.x}",
    )
    problems, _ = checked_inputs(load_system(path))
    assert [problem.line for problem in problems] == [9, 10, 11]


def test_a_replacement_that_follows_its_taker_at_once_is_refused(c_fmu: Fmus) -> None:
    names = {"first": "stage", "second": "stage", "third": "stage"}
    chain = system(c_fmu, names, "first.y -> second.u", "second.y -> third.u")
    crossed = {"crossed": Action(at=0.5, replace={"second.u": "third.y"})}
    with pytest.raises(InputError, match=r"third\.y depends on second\.u at once"):
        prepare(replace(chain, scenario=crossed))
    prepare(replace(chain, scenario={"passed": Action(at=0.5, replace={"third.u": "first.y"})}))


def test_replacements_that_follow_each_other_at_once_are_refused(c_fmu: Fmus) -> None:
    names = {"first": "stage", "second": "stage", "third": "stage"}
    chain = system(c_fmu, names, "first.y -> second.u", "first.y -> third.u")
    there = Action(at=0.1, replace={"second.u": "third.y"}, duration=0.4)
    back = Action(at=0.3, replace={"third.u": "second.y"})
    with pytest.raises(InputError, match=r"second\.y depends on third\.u at once"):
        prepare(replace(chain, scenario={"there": there, "back": back}))
    later = back.model_copy(update={"at": 0.5})
    prepare(replace(chain, scenario={"there": there, "back": later}))


def test_in_python_a_file_of_parameters_is_to_be_read_first(c_fmu: Fmus) -> None:
    plain = system(c_fmu, {"body": "mass", "spring": "spring"}, "body.m <-> spring.end")
    soft = {"soft": Action(at=0.5, parameters="soft.yaml")}
    with pytest.raises(InputError) as raised:
        prepare(replace(plain, scenario=soft))
    (problem,) = raised.value.problems
    assert problem.message == "test: the file 'soft.yaml' of 'soft' is not read here"
    assert "read_parameters" in problem.remedy


def test_a_package_keeps_the_scenario(c_fmu: Fmus, tmp_path: Path) -> None:
    (tmp_path / "soft.yaml").write_text("values: {spring.damping: 0.5}\n", encoding="utf-8")
    path = written(
        c_fmu,
        tmp_path,
        "stuck: {at: 505 ms, for: 1 s, freeze: spring.end.x}",
        "soft: {when: body.body.m.x < -20 cm, parameters: soft.yaml}",
        "rough: {at: 1, noise: {spring.end.x: 1 mm}, seed: 3, every: 0.1}",
    )
    given = load_system(path)
    package = save_system(given, tmp_path / "small.ssp", build_directory=tmp_path / "build")
    outcomes = [run(one, build_directory=tmp_path / "build") for one in (given, package)]
    assert load_system(package).scenario.keys() == given.scenario.keys()
    assert outcomes[0].scenario == outcomes[1].scenario
    assert "on:" in outcomes[0].scenario[1]


def test_outputs_in_place_of_others_before_their_fmus_are_built(tmp_path: Path) -> None:
    """What depends on what is not known then; loops are looked for when it is."""
    (tmp_path / "box.model.yaml").write_text(
        "name: box\nbodies: {box: {mass: 1, inertia: 1}}\n"
        "joints: {free: {type: floating, child: box}}\n"
    )
    path = tmp_path / "system.yaml"
    path.write_text(
        "name: pair\ncomponents:\n  a: {model: box.model.yaml}\n  b: {model: box.model.yaml}\n"
        "connections: ['a.body.box.x -> b.body.box.force_x, units ignored']\n"
        "scenario: {n: {at: 0.5, replace: {a.body.box.x: b.body.box.z}}}\n"
        "simulation: {stop_time: 1, step_size: 0.1}\n"
    )
    problems, _ = checked_inputs(load_system(path))
    assert problems == []
    assert prepare(load_system(path), build_directory=path.parent).system.name == "pair"
