"""Dimensions of a study: ranges, quantities that move together, samples, tables, short names."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.study import load_study

HEAD = "name: s\nmodel: m.model.yaml\nwanted: {a: {variable: x, statistic: mean}}\n"


def grid(folder: Path, text: str) -> Grid:
    (folder / "m.model.yaml").write_text("name: m\n", "utf-8")
    (folder / "s.yaml").write_text(HEAD + text, "utf-8")
    return load_study(folder / "s.yaml").grid


def test_the_grid_is_the_product_of_its_dimensions(tmp_path: Path) -> None:
    found = grid(tmp_path, "vary: {a.x: [1, 2], b.y: {from: 0, to: 1, count: 3}, c: {seeds: 2}}\n")
    assert found.shape == (2, 3, 2)
    assert found.values(0) == {"a.x": 1, "b.y": 0.0, "c": 1}
    assert found.values(11) == {"a.x": 2, "b.y": 1.0, "c": 2}
    assert [axis.name for axis in found.axes] == ["x", "y", "c"]
    assert [axis.repeats for axis in found.axes] == [False, False, True]


def test_quantities_move_together(tmp_path: Path) -> None:
    found = grid(tmp_path, "vary: {sizes: {together: {a.r: [1, 2], b.r: [3, 4]}}}\n")
    assert [found.values(k) for k in range(2)] == [{"a.r": 1, "b.r": 3}, {"a.r": 2, "b.r": 4}]
    assert [v.name for v in found.axes[0].varied] == ["a_r", "b_r"]
    found = grid(tmp_path, "vary: {seed: {seeds: 2, names: [a.seed, b.seed]}}\n")
    assert found.values(1) == {"a.seed": 2, "b.seed": 2}


def test_a_range_by_steps_ends_exactly_at_its_end(tmp_path: Path) -> None:
    """Three times 0.1 is above 0.3, which may be the largest value that is allowed."""
    found = grid(tmp_path, "vary: {x: {from: 0, to: 0.3, step: 0.1}}\n")
    assert found.axes[0].labels == ["0", "0.1", "0.2", "0.3"]
    assert found.axes[0].points[-1] == (0.3,)


def test_latin_hypercubes_have_one_point_in_each_slice(tmp_path: Path) -> None:
    text = "sample: {method: latin_hypercube, count: 10, seed: 1, of: {x: [0, 10], y: [5, 6]}}\n"
    points = np.array(grid(tmp_path, text).axes[0].points)
    assert sorted(points[:, 0].astype(int)) == list(range(10))
    again = np.array(grid(tmp_path, text).axes[0].points)
    np.testing.assert_array_equal(points, again)


def test_normal_samples_have_their_mean_and_deviation(tmp_path: Path) -> None:
    """By Sobol's points: of 1024 the mean is exact to 1e-3 of the deviation, far above theirs."""
    spread = "{distribution: NAME, mean: 10, standard_deviation: 2}"
    for name in ("normal", "log_normal"):
        of = spread.replace("NAME", name)
        text = f"sample: {{method: sobol, count: 1024, of: {{x: {of}, y: [0, 1]}}}}\n"
        values = np.array(grid(tmp_path, text).axes[0].points)[:, 0]
        assert abs(values.mean() - 10.0) < 0.02
        assert abs(values.std() - 2.0) < 0.04


def test_tables_are_cases_with_weights(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("Hs,Tp,p\n1,5,2\n2,7,6\n", "utf-8")
    text = "table: {file: t.csv, columns: {w.hs: Hs, w.tp: Tp}, weight: p}\n"
    found = grid(tmp_path, text)
    assert found.values(1) == {"w.hs": 2.0, "w.tp": 7.0}
    assert found.shares[0].values.tolist() == [0.25, 0.75]


def test_a_scatter_diagram_is_two_dimensions(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("Hs/Tp,5,7,9\n1,1,2,0\n2,0,3,4\n", "utf-8")
    found = grid(tmp_path, "scatter: {file: t.csv, rows: w.hs, columns: w.tp}\n")
    assert found.shape == (2, 3)
    assert found.values(5) == {"w.hs": 2.0, "w.tp": 9.0}
    assert found.probability is not None
    names, shares = found.probability
    assert names == ("hs", "tp")
    np.testing.assert_allclose(shares, np.array([[1, 2, 0], [0, 3, 4]]) / 10)
    assert "t.csv add up to 10, which counts as all the time" in found.covered
    part = grid(tmp_path, "scatter: {file: t.csv, rows: w.hs, columns: w.tp, total: 16}\n")
    assert part.probability is not None
    np.testing.assert_allclose(part.probability[1], np.array([[1, 2, 0], [0, 3, 4]]) / 16)
    assert "t.csv cover 62.5 % of time" in part.covered
    (tmp_path / "t.csv").write_text("Hs;6.5;8.0\n1.5;900;1500\n", "utf-8")
    found = grid(tmp_path, "scatter: {file: t.csv, rows: w.hs, columns: w.tp}\n")
    assert [axis.points for axis in found.axes] == [((1.5,),), ((6.5,), (8.0,))]


def test_columns_are_not_called_as_what_is_wanted(tmp_path: Path) -> None:
    """The result would have two variables of one name, which is refused after all runs."""
    of = "{pto.a: [1, 2], pto.time: [0, 1], pto.b: [0, 1]}"
    found = grid(tmp_path, f"sample: {{method: sobol, count: 2, of: {of}}}\n")
    assert [v.name for v in found.axes[0].varied] == ["pto_a", "pto_time", "b"]


def test_what_has_no_probability_is_not_run(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text("h,5,6,7\n1,0,3,0\n2,1,0,0\n", "utf-8")
    (tmp_path / "t.csv").write_text("k,p\n1,1\n2,0\n3,3\n", "utf-8")
    scatter = "scatter: {file: s.csv, rows: w.h, columns: w.t}\n"
    found = grid(tmp_path, f"vary: {{x: [1, 2]}}\n{scatter}")
    assert (found.size, found.count) == (12, 4)
    assert [found.label(run) for run in found.runs] == [
        "x 1, h 1, t 6", "x 1, h 2, t 5", "x 2, h 1, t 6", "x 2, h 2, t 5"
    ]  # fmt: skip
    assert "not run: 4 of 6 points of h, t (scatter: {run_all" in found.shares[0].text
    table = "table: {file: t.csv, columns: {k: k}, weight: p}\n"
    both = grid(tmp_path, table + scatter)
    assert [one.names for one in both.shares] == [("h", "t"), ("case",)]
    assert both.count == 2 * 2
    every = grid(tmp_path, (table + scatter).replace("}\n", ", run_all: true}\n"))
    assert every.count == every.size == 18
    assert not any(one.text for one in every.shares)
