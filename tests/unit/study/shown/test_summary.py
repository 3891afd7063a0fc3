"""Summaries of studies: means over seeds with Student's t, failures that are told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from support.small_study import written_study

from m4e_fmi.statistics.marine import annual_energy
from m4e_fmi.study import run_study
from m4e_fmi.study.report.result import load_study_result
from m4e_fmi.study.shown.figure import _draw, _shown, plot_study
from m4e_fmi.study.shown.over_states import over_states, states_of
from m4e_fmi.study.shown.summary import _lacking, summary, warning_lines
from m4e_fmi.study.shown.warnings import told_once

STUDY = """\
name: carts
model: cart.model.yaml
simulation: {stop_time: 0.5}
vary: {k: [30, 40, 50], joint.hinge.q: [0.1, 0.2]}
wanted:
  swing: {variable: joint.hinge.q, statistic: maximum}
"""


def test_a_summary_has_a_matrix_and_failures(tmp_path: Path) -> None:
    outcome = run_study(written_study(tmp_path, STUDY), build_directory=tmp_path)
    text = summary(outcome)
    assert "carts: 6 runs, 6 made" in text
    assert "k \\ q" in text
    failed = replace(
        outcome, failures={4: "it broke"}, warnings={"odd value 3": 2, "odd value 4": 1}
    )
    assert "1 of 6 runs failed:\n  k 50, q 0.1: it broke" in summary(failed)
    assert "warning: odd value 3 (3 runs)" in summary(failed)


def test_kinds_of_warnings_are_told_once() -> None:
    lines = list(warning_lines({"a at t = 1.5 s": 1, "a at t = 2 s": 1, "b": 3}))
    told: list[str] = []
    once = told_once(told.append)
    for line in ("hydro: warning: H 3 m breaks (seed 1)", "hydro: warning: H 4 m breaks (seed 2)"):
        once(line)
    for line in ("2 of 3", "3 of 3", "warning: b"):
        once(line)
    assert told == ["hydro: warning: H 3 m breaks (seed 1)", "2 of 3", "3 of 3", "warning: b"]
    assert lines == ["warning: a at t = 1.5 s (2 runs)", "warning: b (3 runs)"]


@pytest.mark.parametrize("text", [STUDY, STUDY.replace(", joint.hinge.q: [0.1, 0.2]", "")])
def test_pictures_are_drawn(tmp_path: Path, text: str) -> None:
    outcome = run_study(written_study(tmp_path, text), build_directory=tmp_path)
    assert plot_study(outcome, tmp_path / "p.png").stat().st_size > 5000


def test_a_curve_is_over_the_axis_that_has_points(tmp_path: Path) -> None:
    """Whichever comes first in the file: one of one point is no axis of a picture."""
    text = STUDY.replace("[30, 40, 50]", "[40]")
    outcome = run_study(written_study(tmp_path, text), build_directory=tmp_path)
    panel = Figure().subplots()
    _draw(panel, _shown(outcome, outcome.study.wanted[0])[1], "swing", outcome)
    (curve,) = panel.get_lines()[:1]
    np.testing.assert_array_equal(curve.get_xdata(), [0.1, 0.2])
    np.testing.assert_array_equal(curve.get_ydata(), outcome.data["swing"].values[0])
    assert panel.get_xlabel() == "q [rad]"


def test_means_by_probability_leave_out_no_failed_state(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("k/u,0,1\n30,1,2\n40,3,0\n", "utf-8")
    text = STUDY.replace("vary: {k: [30, 40, 50], joint.hinge.q: [0.1, 0.2]}", "SCATTER")
    text = text.replace("statistic: maximum", "statistic: mean")
    scatter = "scatter: {file: t.csv, rows: k, columns: joint.hinge.u}"
    path = written_study(tmp_path, text.replace("SCATTER", scatter))
    outcome = run_study(path, build_directory=tmp_path)
    values = outcome.data["swing"].values
    mean = (values[0, 0] + 2 * values[0, 1] + 3 * values[1, 0]) / 6
    assert f"mean by probability: {mean:.5f} rad" in summary(outcome)
    assert "the entries of t.csv add up to 6, which counts as all the time" in summary(outcome)
    (tmp_path / "t.csv").write_text("k/u,0,1e300\n30,1,2\n40,3,0\n", "utf-8")
    failed = summary(run_study(path, build_directory=tmp_path))
    assert "mean by probability: not known, 1 states" in failed


SCATTER = "scatter: {file: t.csv, rows: k, columns: joint.hinge.u}\n"


def test_states_that_do_not_occur_are_not_run(tmp_path: Path) -> None:
    """They are nan without a failure, and nothing of sums; `run_all` runs them."""
    (tmp_path / "t.csv").write_text("k/u,0,1\n30,1,2\n40,3,0\n", "utf-8")
    text = STUDY.replace("k: [30, 40, 50], ", "").replace("maximum", "mean") + SCATTER
    path = written_study(tmp_path, text)
    told: list[tuple[int, int]] = []
    output = tmp_path / "out.nc"
    outcome = run_study(
        path, output=output, build_directory=tmp_path, progress=lambda *n: told.append(n)
    )
    assert told[0] == (0, 6)
    assert told[-1] == (6, 6)
    assert not outcome.failures
    swing, is_run = outcome.data["swing"], outcome.data["is_run"]
    np.testing.assert_array_equal(np.isnan(swing), ~is_run)
    assert not is_run.sel(k=40, u=1).any()
    assert np.isnan(outcome.data["wall_time"].sel(k=40, u=1)).all()
    lines = summary(outcome)
    assert "carts: 6 runs, 6 made" in lines
    assert "1 of 4 sea states does not occur and is not run" in lines
    assert "warning" not in lines
    assert "failed" not in lines
    assert "–" in lines
    assert plot_study(outcome, tmp_path / "p.png").is_file()
    found = load_study_result(output)
    assert (found.count, found.record.made, len(found.failed)) == (6, 6, 0)
    assert found.designs("swing").missing.sum() == 0
    every = run_study(
        written_study(tmp_path, text.replace("hinge.u}", "hinge.u, run_all: true}")),
        build_directory=tmp_path,
    )
    assert every.kept == 6
    assert np.isfinite(every.data["swing"]).all()
    state, of = states_of(outcome.data), outcome.study.wanted[0]
    assert state is not None
    sums = [
        over_states(one.study.grid, one.data["swing"].values, state, of)[1].mean
        for one in (outcome, every)
    ]
    np.testing.assert_array_equal(sums[0], sums[1])
    year = annual_energy(swing.transpose(..., "q"), outcome.data["probability"])
    assert np.isfinite([year.energy, year.error]).all()


def test_states_that_lack_a_seed_are_not_told_to_have_no_value() -> None:
    """Of two seeds and three states: a state without any, and one that lacks in each seed."""
    none = np.array([[False, True, False], [False, True, False]])
    some = np.array([[False, True, False], [True, False, False]])
    assert _lacking(none) == "1 states of the table have no value"
    assert "2 states have no value in some of the runs" in _lacking(some)


def test_a_study_without_a_sea_leaves_nothing_out(tmp_path: Path) -> None:
    path = written_study(tmp_path, STUDY)
    told = summary(run_study(path, build_directory=tmp_path / "build"))
    assert "statistics leave out nothing: no start_up is stated, and no sea has a ramp" in told
    assert "statistics are of rows every 0.01 s: extremes between them are not seen" in told
    path.write_text(f"{STUDY}start_up: 0.1\n", "utf-8")
    told = summary(run_study(path, build_directory=tmp_path / "build"))
    assert "statistics leave out all before t = 0.1 s (as stated)" in told


def test_the_picture_of_designs_is_that_over_all_states(tmp_path: Path) -> None:
    """Its title says so, and its summary has a row for each design."""
    (tmp_path / "t.csv").write_text("k/u,0,1\n30,1,2\n40,3,0\n", "utf-8")
    scatter = "scatter: {file: t.csv, rows: k, columns: joint.hinge.u}"
    text = STUDY.replace("k: [30, 40, 50], ", "") + scatter + "\n"
    outcome = run_study(written_study(tmp_path, text), build_directory=tmp_path)
    largest = np.nanmax(outcome.data["swing"].values[:, [0, 0, 1], [0, 1, 0]], axis=1)
    assert "largest of all states [rad]:\n    q" in summary(outcome)
    lines = summary(outcome).splitlines()  # a scatter diagram for each design
    first = lines.index("  q 0.1")
    assert lines[first + 1].split() == ["k", "\\", "u", "0", "1"]
    shown = [float(entry) for entry in lines[first + 2].split()]
    np.testing.assert_allclose(shown, [30, *outcome.data["swing"].sel(q=0.1, k=30)], rtol=1e-3)
    assert lines[first + 3].split()[-1] == "–"
    name, found = _shown(outcome, outcome.study.wanted[0])
    assert name == ", largest of all states"
    np.testing.assert_allclose(found.mean, largest)
    assert plot_study(outcome, tmp_path / "p.png").is_file()


def test_sea_states_and_cases_have_the_product_of_their_probabilities(tmp_path: Path) -> None:
    text = (
        STUDY.replace(
            "vary: {k: [30, 40, 50], joint.hinge.q: [0.1, 0.2]}",
            "table: {file: cases.csv, columns: {k: k}, weight: p}\n"
            "scatter: {file: s.csv, rows: joint.hinge.q, columns: joint.hinge.u}",
        )
        .replace("name: carts", "name: weighted")
        .replace("maximum", "mean")
    )
    (tmp_path / "cases.csv").write_text("k,p\n30,1\n40,3\n", "utf-8")
    (tmp_path / "s.csv").write_text("q,0,0.5,1\n0.1,1,2,3\n0.2,4,0,6\n", "utf-8")
    outcome = run_study(written_study(tmp_path, text), build_directory=tmp_path)
    probability = outcome.data["probability"]
    assert float(probability.sum()) == pytest.approx(1.0)
    assert float(probability.sel(q=0.2, u=1, case=40)) == pytest.approx(0.75 * 6 / 16)
    mean = float((outcome.data["swing"] * probability).sum())
    (line,) = (x for x in summary(outcome).splitlines() if "mean by probability" in x)
    assert float(line.split()[3]) == pytest.approx(mean, rel=2e-3)  # it shows four digits
