"""Summaries of studies: means over seeds and over states, and what is not run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import t as student
from support.small_study import written_study

from m4e_fmi.statistics import STATISTICS
from m4e_fmi.study import StudyOutcome, run_study
from m4e_fmi.study.given.grid import Axis, Grid, Varied
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.report.result import load_study_result
from m4e_fmi.study.shown.over_states import (
    LARGEST,
    States,
    over_states,
    states_of,
)
from m4e_fmi.study.shown.summary import summary

STUDY = """\
name: carts
model: cart.model.yaml
simulation: {stop_time: 0.5}
vary: {k: [30, 40, 50], joint.hinge.q: [0.1, 0.2]}
wanted:
  swing: {variable: joint.hinge.q, statistic: maximum}
"""
SCATTER = "scatter: {file: t.csv, rows: k, columns: joint.hinge.u}\n"
IN_STATES = STUDY.replace("k: [30, 40, 50], ", "") + SCATTER
"""Two designs in the three states of `TABLE` that occur."""
TABLE = "k/u,0,1\n30,1,2\n40,3,0\n"


def made(folder: Path, text: str, table: str = TABLE, **given: Any) -> StudyOutcome:
    (folder / "t.csv").write_text(table, "utf-8")
    path = written_study(folder, text)
    return run_study(path, build_directory=folder / "build", **given)


def test_a_summary_has_a_matrix_failures_warnings_and_the_start_up(tmp_path: Path) -> None:
    outcome = made(tmp_path, STUDY)
    odd = {"odd value 3": 2, "odd value 4": 1, "b": 3}
    text = summary(replace(outcome, failures={4: "it broke"}, warnings=odd))
    for part in (
        "carts: 6 runs, 6 made",
        "k \\ q",
        "1 of 6 runs failed:\n  k 50, q 0.1: it broke",
        "warning: odd value 3 (3 runs)",
        "warning: b (3 runs)",
        "statistics leave out nothing: no start_up is stated, and no sea has a ramp",
        "statistics are of rows every 0.01 s: extremes between them are not seen",
    ):
        assert part in text
    stated = summary(made(tmp_path, f"{STUDY}start_up: 0.1\n"))
    assert "statistics leave out all before t = 0.1 s (as stated)" in stated


def test_means_by_probability_leave_out_no_failed_state(tmp_path: Path) -> None:
    text = STUDY.replace("vary: {k: [30, 40, 50], joint.hinge.q: [0.1, 0.2]}\n", SCATTER)
    text = text.replace("statistic: maximum", "statistic: mean")
    outcome = made(tmp_path, text)
    values = outcome.data["swing"].values
    mean = (values[0, 0] + 2 * values[0, 1] + 3 * values[1, 0]) / 6
    assert f"mean by probability: {mean:.5f} rad" in summary(outcome)
    assert "the entries of t.csv add up to 6, which counts as all the time" in summary(outcome)
    failed = summary(made(tmp_path, text, TABLE.replace("k/u,0,1", "k/u,0,1e300")))
    assert "mean by probability: not known, 1 of 3 states without a value" in failed


def test_states_that_do_not_occur_are_not_run(tmp_path: Path) -> None:
    """They are nan without a failure, and nothing of sums; `run_all` runs them."""
    text, output = IN_STATES.replace("maximum", "mean"), tmp_path / "out.nc"
    told: list[tuple[int, int]] = []
    outcome = made(tmp_path, text, output=output, progress=lambda *n: told.append(n))
    assert (told[0], told[-1]) == ((0, 6), (6, 6))
    assert not outcome.failures
    swing, is_run = outcome.data["swing"], outcome.data["is_run"]
    np.testing.assert_array_equal(np.isnan(swing), ~is_run)
    assert not is_run.sel(k=40, u=1).any()
    assert np.isnan(outcome.data["wall_time"].sel(k=40, u=1)).all()
    lines = summary(outcome)
    assert "carts: 6 runs, 6 made" in lines
    assert "and not run: 1 of 4 points of k, u" in lines
    assert not {"warning", "failed"} & set(lines.split())
    found = load_study_result(output)
    assert (found.grid.count, found.record.made, len(found.failed)) == (6, 6, 0)
    assert found.designs("swing").missing.sum() == 0
    every = made(tmp_path, text.replace("hinge.u}", "hinge.u, run_all: true}"))
    assert every.kept == 6
    assert np.isfinite(every.data["swing"]).all()
    state, of = states_of(outcome.data), outcome.study.wanted[0]
    assert state is not None
    sums = [
        over_states(one.study.grid, one.data["swing"].values, state, of, "W")
        for one in (outcome, every)
    ]
    (_, _, mean), (_, unit, year) = sums[0]
    np.testing.assert_array_equal(mean.mean, sums[1][0][2].mean)
    assert unit == "MWh"  # if they were powers
    np.testing.assert_allclose(year.mean, mean.mean * 8766e-6, rtol=1e-12)


def test_designs_are_shown_over_all_states(tmp_path: Path) -> None:
    """The summary says so, and has a scatter diagram for each design."""
    outcome = made(tmp_path, IN_STATES)
    largest = np.nanmax(outcome.data["swing"].values[:, [0, 0, 1], [0, 1, 0]], axis=1)
    assert "largest of all states [rad]:\n    q" in summary(outcome)
    lines = summary(outcome).splitlines()
    first = lines.index("  q 0.1")
    assert lines[first + 1].split() == ["k", "\\", "u", "0", "1"]
    shown = [float(entry) for entry in lines[first + 2].split()]
    np.testing.assert_allclose(shown, [30, *outcome.data["swing"].sel(q=0.1, k=30)], rtol=1e-3)
    assert lines[first + 3].split()[-1] == "–"
    state, wanted = states_of(outcome.data), outcome.study.wanted[0]
    assert state is not None
    values = outcome.data["swing"].values
    ((name, _, found),) = over_states(outcome.study.grid, values, state, wanted, "rad")
    assert name == "largest of all states"
    np.testing.assert_allclose(found.mean, largest)


def test_sea_states_and_cases_have_the_product_of_their_probabilities(tmp_path: Path) -> None:
    given = (
        "table: {file: cases.csv, columns: {k: k}, weight: p}\n"
        "scatter: {file: t.csv, rows: joint.hinge.q, columns: joint.hinge.u}\n"
    )
    text = STUDY.replace("vary: {k: [30, 40, 50], joint.hinge.q: [0.1, 0.2]}\n", given)
    (tmp_path / "cases.csv").write_text("k,p\n30,1\n40,3\n", "utf-8")
    outcome = made(tmp_path, text.replace("maximum", "mean"), "q,0,0.5,1\n0.1,1,2,3\n0.2,4,0,6\n")
    probability = outcome.data["probability"]
    assert float(probability.sum()) == pytest.approx(1.0)
    assert float(probability.sel(q=0.2, u=1, case=40)) == pytest.approx(0.75 * 6 / 16)
    mean = float((outcome.data["swing"] * probability).sum())
    (line,) = (x for x in summary(outcome).splitlines() if "mean by probability" in x)
    assert float(line.split()[3]) == pytest.approx(mean, rel=2e-3)  # it shows four digits


SEEDS, DESIGNS = 3, 2


def half_width(sums: np.ndarray) -> np.ndarray:
    """Of 95 %, of the means over the last axis."""
    n = sums.shape[-1]
    return student.ppf(0.975, n - 1) * sums.std(axis=-1, ddof=1) / np.sqrt(n)


STATES = States(("height", "period"), np.array([[0.5, 0.25], [0.0, 0.25]]))


def axis(name: str, count: int, *, repeats: bool = False) -> Axis:
    points = tuple((k,) for k in range(count))
    return Axis(name, (Varied(name, (name,)),), points, repeats=repeats)


GRID = Grid(
    (axis("period", 2), axis("seed", SEEDS, repeats=True), axis("x", DESIGNS), axis("height", 2))
)
VALUES = np.random.default_rng(1).uniform(1.0, 2.0, GRID.shape)
VALUES[0, :, :, 1] = 100.0  # of the state that never occurs


def test_a_seed_that_failed_in_a_state_counts_by_the_others_there() -> None:
    """Its other states are there: left out with it, the rough states alone would count less."""
    grid = Grid((axis("height", 2), axis("seed", 2, repeats=True)))
    values = np.array([[1.0, 3.0], [np.nan, 10.0]])
    states, wanted = States(("height",), np.array([0.5, 0.5])), Wanted("p", "x.p", "mean")
    (_, _, mean), (_, _, year) = over_states(grid, values, states, wanted, "kW")
    assert mean.cell(()) == "6.000*"
    assert float(year.mean) == pytest.approx(6 * 8.766, rel=1e-12)
    assert (int(mean.missing), float(mean.half_width)) == (1, pytest.approx(np.nan, nan_ok=True))


@pytest.mark.parametrize(
    ("statistic", "parameters", "power", "said"),
    [
        ("mean", (), 1.0, "mean by probability"),
        ("rms", (), 2.0, "rms by probability"),
        ("damage_equivalent_load", (("exponent", 5.0),), 5.0, "damage equivalent by probability"),
    ],
)
def test_sums_over_states_of_each_design(
    statistic: str, parameters: tuple[tuple[str, float], ...], power: float, said: str
) -> None:
    of = Wanted("w", "v", statistic, parameters)
    ((name, _, found),) = over_states(GRID, VALUES, STATES, of, "N")
    assert name == said
    assert [one.name for one in found.axes] == ["x"]
    sums = np.einsum("psxh,hp->xs", VALUES**power, STATES.shares) ** (1 / power)
    np.testing.assert_allclose(found.mean, sums.mean(axis=-1), rtol=1e-12)
    np.testing.assert_allclose(found.half_width, half_width(sums), rtol=1e-9)


@pytest.mark.parametrize(("statistic", "sign"), [("most_probable_maximum", 1), ("minimum", -1)])
def test_extremes_are_those_of_a_state(statistic: str, sign: int) -> None:
    of = Wanted("w", "v", statistic)
    ((_, _, found),) = over_states(GRID, sign * VALUES, STATES, of, "N")
    means = VALUES.mean(axis=1)  # period, x, height
    there = np.stack([means[0, :, 0], means[1, :, 0], means[1, :, 1]], axis=-1)
    np.testing.assert_allclose(found.mean, sign * there.max(axis=-1))


def test_a_failed_seed_is_missing_in_the_sum() -> None:
    values = VALUES.copy()
    values[0, 1, 0, 0] = np.nan
    ((_, _, found),) = over_states(GRID, values, STATES, Wanted("w", "v", "mean"), "N")
    assert found.missing.tolist() == [1, 0]
    assert np.isfinite(found.mean).all()


def test_all_statistics_of_maxima_are_known() -> None:
    assert {name for name in STATISTICS if "maximum" in name} | {"range", "largest_magnitude"} == (
        LARGEST
    )
