"""Studies of FMUs that end a run by themselves, or whose arrays have other sizes."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from support.small_study import Here

from m4e_fmi.study import StudyOutcome, run_study

Fmus = Callable[[str], Path]


def made(folder: Path, component: str, fmu: Path, study: str) -> StudyOutcome:
    """A study of one FMU as a `component`, in 5 steps of 0.2 s."""
    shutil.copy(fmu, folder / "own.fmu")
    (folder / "system.yaml").write_text(
        f"name: s\ncomponents: {{{component}: {{fmu: own.fmu}}}}\n"
        "simulation: {stop_time: 1, step_size: 0.2, algorithm: jacobi}\n",
        "utf-8",
    )
    path = folder / "study.yaml"
    path.write_text(f"name: s\nsystem: system.yaml\nstart_up: 0\n{study}", "utf-8")
    return run_study(path, build_directory=folder / "build", executor=Here())


def test_a_run_that_an_fmu_ends_before_the_stop_time_is_told(c_fmu: Fmus, tmp_path: Path) -> None:
    """Its statistics are of a shorter record."""
    study = (
        "vary: {fuse.when: [0.4, 9]}\nwanted: {y: {variable: fuse.y, statistic: maximum}}\n"
        "series: [fuse.y]\n"
    )
    outcome = made(tmp_path, "fuse", c_fmu("ending"), study)
    ends = [record.time[-1] for record in outcome.records]
    assert ends == pytest.approx([0.4, 1.0])
    told = "the run ended before its stop time of 1 s: fuse requested the end of the simulation"
    (line,) = (w for w in outcome.warnings if w.startswith(told))
    assert line.endswith("at t = 0.4 s")
    assert outcome.warnings[line] == 1


def test_a_varied_structural_parameter_sizes_the_arrays_of_each_run(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    study = (
        "start: {g.gain: 2}\nvary: {g.size: [3, 5]}\n"
        'wanted: {y: {variable: "g.y[3]", statistic: maximum}}\n'
    )
    outcome = made(tmp_path, "g", c_fmu("3:gallery"), study)
    assert not outcome.failures
    alone = made(tmp_path, "g", c_fmu("3:gallery"), study.replace("[3, 5]", "[5]"))
    assert alone.kept == 1
    assert alone.data["y"].values == outcome.data["y"].values[1]
