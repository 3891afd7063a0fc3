"""Dimensions of a study: ranges, quantities that move together, samples, tables, short names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.study.given.axes import short_names
from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.study import read_study

HEAD = "name: s\nmodel: m.model.yaml\nwanted: {a: {variable: x, statistic: mean}}\n"


def grid(folder: Path, text: str) -> Grid:
    (folder / "m.model.yaml").write_text("name: m\n", "utf-8")
    (folder / "s.yaml").write_text(HEAD + text, "utf-8")
    study, problems = read_study(folder / "s.yaml")
    if problems or study is None:
        raise InputError(dict.fromkeys(problems))
    return study.grid


def test_the_grid_is_the_product_of_its_dimensions(tmp_path: Path) -> None:
    found = grid(tmp_path, "vary: {a.x: [1, 2], b.y: {from: 0, to: 1, count: 3}, c: {seeds: 2}}\n")
    assert found.shape == (2, 3, 2)
    assert found.values(0) == {"a.x": 1, "b.y": 0.0, "c": 1}
    assert found.values(11) == {"a.x": 2, "b.y": 1.0, "c": 2}
    assert [axis.name for axis in found.axes] == ["x", "y", "c"]
    assert [axis.repeats for axis in found.axes] == [False, False, True]


def test_quantities_move_together(tmp_path: Path) -> None:
    text = "vary: {sizes: {together: {a.r: [1, 2], b.r: [3, 4]}}}\n"
    found = grid(tmp_path, text)
    assert [found.values(k) for k in range(2)] == [{"a.r": 1, "b.r": 3}, {"a.r": 2, "b.r": 4}]
    assert [v.name for v in found.axes[0].varied] == ["a_r", "b_r"]


def test_one_value_for_several_names(tmp_path: Path) -> None:
    found = grid(tmp_path, "vary: {seed: {seeds: 2, names: [a.seed, b.seed]}}\n")
    assert found.values(1) == {"a.seed": 2, "b.seed": 2}


def test_a_range_by_steps_meets_its_end(tmp_path: Path) -> None:
    found = grid(tmp_path, "vary: {x: {from: 0, to: 0.3, step: 0.1}}\n")
    assert found.axes[0].labels == ["0", "0.1", "0.2", "0.3"]
    with pytest.raises(InputError, match=r"write to: 0\.3"):
        grid(tmp_path, "vary: {x: {from: 0, to: 0.35, step: 0.1}}\n")


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
    assert found.axes[0].weights == (0.25, 0.75)


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


def test_decimal_commas_of_a_scatter_diagram_are_read(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("Hs;6,5;8,0\n1,5;900;1500\n", "utf-8")
    found = grid(tmp_path, "scatter: {file: t.csv, rows: w.hs, columns: w.tp}\n")
    assert [axis.points for axis in found.axes] == [((1.5,),), ((6.5,), (8.0,))]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("vary: {x: []}\n", "x has no values"),
        ("vary: {x: {values: [1], seeds: 3}}\n", "x has values and seeds"),
        ("vary: {x: {from: 1, to: 2}}\n", "either 'step' or 'count'"),
        ("vary: {x: {together: {a: [1], b: [1, 2]}}}\n", "as many values each"),
        (
            "vary: {x: [1]}\nsample: {method: sobol, count: 2, of: {x: [0, 1]}}\n",
            "x is varied twice",
        ),
        ("sample: {method: sobol, count: 6, of: {x: [0, 1]}}\n", "take 4 or 8"),
        ("sample: {method: sobol, count: 4, of: {x: [1, 1]}}\n", "is not below"),
        ("vary: {failure: [1]}\n", "cannot be called 'failure'"),
        (
            "sample: {method: sobol, count: 2, of: {a: [0, 1], x: [0, 1]}}\n",
            "cannot be called 'a'",
        ),
        ("table: {file: none.csv, columns: {x: X}}\n", "no such file"),
        ("scatter: {file: t.csv, rows: x, columns: y, total: 2}\n", "add up to 3, more than"),
    ],
)
def test_what_is_no_dimension_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "t.csv").write_text("x/y,5,7\n1,1,2\n", "utf-8")
    with pytest.raises(InputError, match=said):
        grid(tmp_path, text)


def test_short_names_are_as_short_as_they_are_unique() -> None:
    found = short_names(["hydro.waves.seed", "gauge.waves.seed", "pto.damping"])
    assert list(found.values()) == ["hydro_waves_seed", "gauge_waves_seed", "damping"]


def test_columns_are_not_called_as_what_is_wanted(tmp_path: Path) -> None:
    """The result would have two variables of one name, which is refused after all runs."""
    found = grid(
        tmp_path,
        "sample: {method: sobol, count: 2, of: {pto.a: [1, 2], pto.time: [0, 1], pto.b: [0, 1]}}\n",
    )
    assert [v.name for v in found.axes[0].varied] == ["pto_a", "pto_time", "b"]


def test_a_mistake_in_one_of_two_forms_is_told_once(tmp_path: Path) -> None:
    """In the words of the file, without the form that is not meant."""
    text = """\
sample:
  method: latin_hypercube
  count: 4
  of:
    a: [3, three]
    b: [1, 2, 3]
    c: {distribution: lognormal, mean: 7}
    d: 5
vary:
  e: {form: 0, to: 1, count: 3}
"""
    with pytest.raises(InputError) as caught:
        grid(tmp_path, text)
    first = len(HEAD.splitlines())
    assert [(p.line - first, p.message) for p in caught.value.problems] == [
        (5, "sample.of.a.1: expected a number, got 'three'"),
        (6, "b: too many entries, expected 2, got 3"),
        (7, "unknown distribution 'lognormal'"),
        (8, "sample.of.d: expected a list or 'key: value' lines, got 5"),
        (10, "unknown key 'form'"),
    ]


def test_two_dimensions_of_one_name_are_refused(tmp_path: Path) -> None:
    """xarray refuses them too, but only when all runs are made."""
    text = "vary: {a.x: {values: [1, 2], as: n}, b.y: {values: [1, 2, 3], as: n}}\n"
    with pytest.raises(InputError, match="two dimensions or columns are called 'n'"):
        grid(tmp_path, text)


def test_two_dimensions_of_seeds_are_refused(tmp_path: Path) -> None:
    """Of n times n runs, n are independent: Student's interval would be too narrow."""
    with pytest.raises(InputError, match="a second dimension of seeds"):
        grid(tmp_path, "vary: {a.seed: {seeds: 3}, b.seed: {seeds: 3}}\n")
    assert grid(tmp_path, "vary: {a.seed: {seeds: 3}, b.seed: [1, 2, 3]}\n").count == 9


def test_what_has_no_probability_is_not_run(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text("h,5,6,7\n1,0,3,0\n2,1,0,0\n", "utf-8")
    (tmp_path / "t.csv").write_text("k,p\n1,1\n2,0\n3,3\n", "utf-8")
    scatter = "scatter: {file: s.csv, rows: w.h, columns: w.t}\n"
    found = grid(tmp_path, f"vary: {{x: [1, 2]}}\n{scatter}")
    assert (found.size, found.count) == (12, 4)
    assert [found.told(run) for run in found.runs] == [
        "x 1, h 1, t 6", "x 1, h 2, t 5", "x 2, h 1, t 6", "x 2, h 2, t 5"
    ]  # fmt: skip
    assert "4 of 6 sea states do not occur and are not run" in found.not_run[0].text
    table = "table: {file: t.csv, columns: {k: k}, weight: p}\n"
    both = grid(tmp_path, table + scatter)
    assert [one.names for one in both.not_run] == [("case",), ("h", "t")]
    assert both.count == 2 * 2
    every = grid(tmp_path, (table + scatter).replace("}\n", ", run_all: true}\n"))
    assert every.count == every.size == 18
    assert not every.not_run


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("vary: {x: {from: 1, to: 2, count: 3000000000}}\n", "less than or equal to 1000000"),
        ("vary: {x: {seeds: 3000000000}}\n", "less than or equal to 1000000"),
        ("sample: {method: sobol, count: 2147483648, of: {x: [0, 1]}}\n", "equal to 1000000"),
        ("vary: {x: {from: 0, to: 1, count: 2000}, y: {from: 0, to: 1, count: 2000}}\n",
         "4,000,000 points together"),
        ("vary: {x: {from: 0, to: .inf, count: 3}}\n", "a range of inf"),
        ("vary: {x: {from: 3, to: 9, count: 1}}\n", "one value cannot be both 3 and 9"),
        ("vary: {x: {from: 3, to: 1, step: 1}}\n", "write step: -1"),
        ("vary: {x: {from: .nan, to: 1, step: 0.1}}\n", "a range of nan"),
        ("sample: {method: sobol, count: 2, seed: -1, of: {x: [0, 1]}}\n", "sample.seed"),
    ],
)  # fmt: skip
def test_dimensions_that_no_machine_makes_are_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        grid(tmp_path, text)


def test_steps_end_exactly_at_the_end(tmp_path: Path) -> None:
    """Three times 0.1 is above 0.3, which may be the largest value that is allowed."""
    found = grid(tmp_path, "vary: {x: {from: 0, to: 0.3, step: 0.1}}\n")
    assert found.axes[0].points[-1] == (0.3,)
