"""`m4e-fmi study`: exit codes, tables; the example's names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from support.small_study import written_study

from m4e_fmi.study import load_study
from m4e_fmi.study.names import named_system

Said = Callable[..., str]
STUDY = """\
name: carts
model: cart.model.yaml
simulation: {stop_time: 0.5}
vary: {k: [30, 40], joint.hinge.u: [0, 1]}
wanted: {swing: {variable: joint.hinge.q, statistic: maximum}}
"""
EXAMPLE = Path(__file__).parents[3] / "examples/power_matrix/study.yaml"


@pytest.mark.usefixtures("here")
def test_a_study_prints_tables_and_writes_its_files(said: Said) -> None:
    written_study(Path(), STUDY)
    text = said("study", "study.yaml")
    assert "0 runs kept, 4 to make\n" in text
    assert "carts: 4 runs, 4 made" in text
    assert "swing [rad]: maximum of joint.hinge.q" in text
    assert Path("build/carts.nc").is_file()
    again = said("study", "study.yaml", "--output-file", "t.csv")
    assert "4 runs kept, 0 to make, the last took" in again
    assert "0 made, 4 kept from before" in again
    assert len(Path("t.csv").read_text("utf-8").splitlines()) == 5


@pytest.mark.usefixtures("here")
def test_a_study_writes_its_report(said: Said) -> None:
    written_study(Path(), f"{STUDY}series: [joint.hinge.q]\n")
    assert "carts.report.html" in said("study", "study.yaml", "--report")
    page = Path("build/carts.report.html").read_text("utf-8")
    assert "m4e-fmi study study.yaml --report" in page
    assert "4 made, 0 kept" in page
    assert "cart.model.yaml" in page
    given = ["study", "study.yaml", "--output-file", "t.csv", "--report", "r.html"]
    assert "--report is made from a netCDF file" in said(*given, code=2)
    said("study", "study.yaml", "--report", "r.pdf", code=2)


@pytest.mark.usefixtures("here")
def test_a_failed_run_is_exit_code_1(said: Said) -> None:
    written_study(Path(), STUDY.replace("[0, 1]", "[0, 1.e+300]"))
    text = said("study", "study.yaml", code=1)
    assert "2 of 4 runs failed:\n  k 30, u 1e+300: cart at t = 0 s" in text
    assert "failed" in text


def test_names_of_the_example_stand_for_something() -> None:
    study = load_study(EXAMPLE)
    assert study.grid.shape == (6, 8, 5)
    found, _ = named_system(study)
    assert [str(target) for target in found.targets.values()] == [
        f"the key waves.{key} of the section of hydro"
        for key in ("significant_height", "peak_period", "seed")
    ]
