"""Scenarios in system files: what is read, recorded and told; what is refused, and where."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from support.small_systems import Fmus

from m4e_fmi.cosim import load, run, save_system
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.report.text.summaries import run_summary

FILE = """\
name: small
components:
  body: {{fmu: mass.fmu, process: here, start: {{body.m.x: 1.0}}}}
  spring: {{fmu: spring.fmu, process: here}}
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
    path = written(
        c_fmu,
        tmp_path,
        "stuck: {at: 505 ms, for: 1 s, freeze: spring.end.x}",
        "soft: {when: body.body.m.x < -20 cm, set: {spring.damping: 0.5}}",
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


def test_a_package_keeps_the_scenario(c_fmu: Fmus, tmp_path: Path) -> None:
    path = written(
        c_fmu,
        tmp_path,
        "stuck: {at: 505 ms, for: 1 s, freeze: spring.end.x}",
        "soft: {when: body.body.m.x < -20 cm, set: {spring.damping: 0.5}}",
    )
    given = load_system(path)
    package = save_system(given, tmp_path / "small.ssp", build_directory=tmp_path / "build")
    outcomes = [run(one, build_directory=tmp_path / "build") for one in (given, package)]
    assert load_system(package).scenario.keys() == given.scenario.keys()
    assert outcomes[0].scenario == outcomes[1].scenario
    assert "on:" in outcomes[0].scenario[1]
