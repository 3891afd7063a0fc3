"""Studies of a system: the same numbers as single runs, kept runs, failures, files."""

from __future__ import annotations

import csv
import hashlib
import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from support.small_study import SYSTEM, Here, written_study

import m4e_fmi
from m4e_fmi.files.locks import claimed
from m4e_fmi.study import StudyOutcome, load_study, run_study
from m4e_fmi.study.systems.plan import SystemPlan
from m4e_fmi.study.systems.task import Blob, perform

STUDY = """\
name: carts
system: system.yaml
start_up: 0.2
vary:
  pto.damping: [2, 6]
  cart.k: {from: 30, to: 50, step: 10}
wanted:
  power: {variable: pto.power, statistic: mean}
  force: {variable: pto.force, statistic: maximum}
"""


def made(path: Path, **given: Any) -> StudyOutcome:
    here = Here()
    return run_study(path, build_directory=path.parent / "build", executor=here, **given)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, StudyOutcome, list[str]]:
    """A study with series: its folder, outcome, and what was told.

    Its system was edited while it ran; the result is that of what it began with.
    """
    folder, told = tmp_path_factory.mktemp("study"), list[str]()
    path = written_study(folder, f"{STUDY}series: [pto.force]\n")

    def broken(done: int, _: int) -> None:
        if done:
            (folder / "system.yaml").write_text("name: [", encoding="utf-8")

    outcome = made(path, output=folder / "out.nc", progress=broken, tell=told.append)
    written_study(folder, f"{STUDY}series: [pto.force]\n")
    return folder, outcome, told


def test_numbers_are_those_of_single_runs(whole: tuple[Path, StudyOutcome, list[str]]) -> None:
    folder, outcome, _ = whole
    text = SYSTEM.replace("damping: 4", "damping: 6")
    (folder / "one.yaml").write_text(text, "utf-8")
    system = m4e_fmi.load_system(folder / "one.yaml").changed(start={"cart.k": 40.0})
    run = m4e_fmi.run(system, results=folder / "one.nc", build_directory=folder / "other")
    found = run.results()
    force = found["pto.force"].values[found.time >= 0.2].max()
    one = outcome.data.sel(damping=6, k=40)
    assert float(one["force"]) == force
    assert float(one["coupling_error"]) == run.certificate.errors[0].error  # pyrefly: ignore[missing-attribute]
    late = outcome.data["pto.force"].where(outcome.data["time"] >= 0.2)
    np.testing.assert_array_equal(late.max("time"), outcome.data["force"])


def test_files_are_labelled_and_tell_what_the_study_began_with(
    whole: tuple[Path, StudyOutcome, list[str]],
) -> None:
    folder, outcome, told = whole
    assert sum("building" in line and line.startswith("pto") for line in told) == 1
    with xarray.open_dataset(folder / "out.nc") as data:
        assert data["power"].dims == ("damping", "k")
        assert data["pto.force"].dims == ("damping", "k", "time")
        assert {n: data[n].attrs["units"] for n in ("power", "k", "damping")} == {
            "power": "W", "k": "N/m", "damping": "N.s/m"
        }  # fmt: skip
        assert data["k"].attrs["long_name"] == "Stiffness of the spring"
        assert data.attrs["study"].startswith(STUDY)
        assert (data["start_up"] == 0.2).all()
        assert (data["failure"] == "").all()
        np.testing.assert_array_equal(data["power"], outcome.data["power"])
        record = json.loads(data.attrs["record"])
    (system,) = (one for one in record["inputs"] if one["name"] == "system.yaml")
    assert system["text"] == SYSTEM
    assert system["sha256"] == hashlib.sha256(SYSTEM.encode()).hexdigest()
    kept = made(folder / "study.yaml", output=folder / "out.csv")
    np.testing.assert_array_equal(kept.data["pto.force"], outcome.data["pto.force"])
    rows = list(csv.DictReader((folder / "out.csv").open(encoding="utf-8")))
    power = [float(row["power [W]"]) for row in rows]
    np.testing.assert_array_equal(power, outcome.data["power"].values.ravel())
    assert [row["k [N/m]"] for row in rows[:3]] == ["30.0", "40.0", "50.0"]


def test_processes_give_the_same_bits(tmp_path: Path) -> None:
    text = STUDY.replace("[2, 6]", "[2]").replace("step: 10", "step: 20")
    path = written_study(tmp_path, text)
    here = made(path)
    other = run_study(path, build_directory=tmp_path / "build", jobs=1, fresh=True)
    for name in ("power", "force", "coupling_error"):
        np.testing.assert_array_equal(here.data[name], other.data[name])


def test_a_worker_takes_no_other_file_than_that_of_the_plan(tmp_path: Path) -> None:
    study = load_study(written_study(tmp_path, STUDY))
    plan = SystemPlan(study, tmp_path, tmp_path, print)
    plan.build()
    task = plan.task(0, [])
    other = tmp_path / "other.fmu"
    other.write_bytes(b"another one")
    for path, why in ((other, "it has changed since the study began"), (tmp_path / "x", "x")):
        odd = Blob("0" * 64, "pto.fmu", path)
        assert why in perform(replace(task, fmus={**task.fmus, "pto": odd})).failure
    assert not perform(task).failure


def test_series_of_adaptive_steps_have_times_of_their_own(tmp_path: Path) -> None:
    settings = "simulation: {coupling_tolerance: 1.e-8, stop_time: 0.4}"
    text = STUDY.replace("start_up: 0.2\n", f"{settings}\nseries: [pto.force]\n")
    data = made(written_study(tmp_path, text)).data
    assert data["pto.force"].dims == data["time"].dims == ("damping", "k", "row")
    ends = data["time"].max("row")
    np.testing.assert_array_equal(ends, 0.4)


def test_two_studies_do_not_write_one_file(tmp_path: Path) -> None:
    path, output = written_study(tmp_path, STUDY), tmp_path / "out.nc"
    with claimed(output), ThreadPoolExecutor(1) as pool:
        other = pool.submit(made, path, output=output)
        with pytest.raises(m4e_fmi.RunError, match="another run writes it"):
            other.result()


def test_a_warning_of_runs_is_told_with_the_first(tmp_path: Path) -> None:
    text = STUDY.replace("statistic: mean", "statistic: zero_crossing_period")
    path = written_study(tmp_path, text.replace("start_up: 0.2", "start_up: 0.97"))
    told: list[str] = []
    outcome = made(path, tell=told.append, progress=lambda *n: told.append(f"{n[0]} done"))
    (line,) = (line for line in told if "power is not defined" in line)
    assert told.index("0 done") < told.index(line) < told.index("1 done")
    assert "in the run of damping" in line
    assert sum(outcome.warnings.values()) >= 6
