"""Reports of studies from result files: texts, means, energies, the numbers of the page."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from scipy.stats import t as student
from support.written_study import (
    DAMPINGS,
    EVIL,
    FAILED_CELL,
    HEIGHTS,
    PERIODS,
    PROBABILITY,
    SEEDS,
    axis,
    matrix,
    power,
    samples,
    written,
)

import m4e_fmi as m4e
from m4e_fmi.errors import InputError
from m4e_fmi.study.dataset import Labels, dataset, write_dataset
from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.study import Study, Wanted
from m4e_fmi.study.record import Record
from m4e_fmi.study.report.annual import annual, contributions
from m4e_fmi.study.report.content import content_of
from m4e_fmi.study.report.of_study import report_of_study
from m4e_fmi.study.report.result import load_study_result
from m4e_fmi.study.report.summary import figures, numerics, warnings

YEAR = 8766.0 * 3600.0


def test_means_over_seeds_are_those_of_the_runs_that_are_left(tmp_path: Path) -> None:
    result = load_study_result(matrix(tmp_path))
    found = result.designs("mean_power")
    assert np.isnan(found.mean[FAILED_CELL]).all()
    values = [power(HEIGHTS[0], PERIODS[1], DAMPINGS[1], s) for s in range(SEEDS)]
    np.testing.assert_allclose(found.mean[0, 1, 1], np.mean(values))
    width = student.ppf(0.975, SEEDS - 1) * np.std(values, ddof=1) / np.sqrt(SEEDS)
    np.testing.assert_allclose(found.half_width[0, 1, 1], width)
    assert found.missing[2].tolist() == [[3, 3], [1, 1], [0, 0], [0, 0]]


def test_the_summary_has_failures_errors_and_their_runs(tmp_path: Path) -> None:
    result = load_study_result(matrix(tmp_path))
    text = numerics(result)
    for part in (
        "0.072 % of range, at buoy.force", "in the run of Hs 3 m, Tp 12 s, damping 7, seed 3",
        "all before t = 30 s (30 s)", "128 s in all", "72 made, 0 kept",
        "Hs: 1 to 3 m, 3 values", "3 seeds",
    ):  # fmt: skip
        assert part in text
    doubts = warnings(result)
    for part in (
        "8 of 72 runs failed",
        "<td>Hs 3 m, Tp 6 s, damping 5, seed 1</td>",
        "odd &lt;img",
    ):
        assert part in doubts
    assert "No run failed" not in doubts
    sound = replace(result.record, warnings=())
    none = replace(load_study_result(matrix(tmp_path, failing=False)), record=sound)
    assert warnings(none).startswith('<p class="good">No run failed; no warnings; largest coupling')


def test_cards_have_the_largest_values_and_the_energy_of_the_best_design(tmp_path: Path) -> None:
    result = load_study_result(matrix(tmp_path, failing=False))
    found = re.findall(r"<dt>(.*?)</dt><dd[^>]*>(.*?)</dd><dd[^>]*>(.*?)</dd>", figures(result))
    assert [name for name, _, _ in found] == [
        "energy of a year of 8766 h, mean_power", "mean by probability, mean_power",
        "largest of all states, most_tension", "largest mean_power", "largest most_tension",
    ]  # fmt: skip
    assert (found[0][1].endswith("MWh"), found[0][2]) == (True, "damping 7")
    assert found[3][1:] == ("63.01 ± 0.02 kW", "Hs 3 m, Tp 8 s, damping 7")


def test_capture_widths_are_powers_over_those_of_the_waves(tmp_path: Path) -> None:
    """Of what a load of a model takes from the motion, the negative; not without waves."""
    assert "capture width, mean_power" not in load_study_result(matrix(tmp_path)).quantities
    grid = Grid((axis("Hs", HEIGHTS),))
    wanted = tuple(
        Wanted(name, variable, "mean")
        for name, variable in (("a", "pto.power"), ("b", "w.load.pto.power"))
    )
    records = [Record(values={"a": 2e3 * h**2, "b": -3e3 * h**2}) for h in HEIGHTS]
    units = {"pto.power": "W", "w.load.pto.power": "W"}
    waves = [1e3 * h**2 for h in HEIGHTS]
    path = written(tmp_path, grid, records, wanted, units=units, wave_power=waves)
    result = load_study_result(path)
    np.testing.assert_allclose(result.numbers["capture width, a"], 2.0)
    np.testing.assert_allclose(result.numbers["capture width, b"], 3.0)
    assert result.units["capture width, a"] == "m"
    text = result.quantities["capture width, a"]
    assert "ρ g a² c_g/2" in text
    assert text.endswith("in 50 m of water")


def test_energies_of_a_year_are_those_of_the_sums_of_each_seed(tmp_path: Path) -> None:
    result = load_study_result(matrix(tmp_path, failing=False))
    text = annual(result)
    powers = [
        [[power(h, p, DAMPINGS[0], s) for s in range(SEEDS)] for p in PERIODS] for h in HEIGHTS
    ]
    sums = np.einsum("hp,hps->s", PROBABILITY, np.array(powers))
    energy = YEAR * np.mean(sums) / 3.6e9
    error = YEAR * np.std(sums, ddof=1) / np.sqrt(SEEDS) / 3.6e9
    shown = re.findall(
        r"<td>mean_power</td><td>([^<]*)</td><td>damping 5</td><td[^>]*>([\d.]+) ± ([\d.]+) ", text
    )
    assert [told for told, _, _ in shown] == ["energy of a year of 8766 h", "mean by probability"]
    assert float(shown[1][1]) == pytest.approx(np.mean(sums) / PROBABILITY.sum() / 1e3, rel=1e-3)
    assert float(shown[0][1]) == pytest.approx(energy, rel=1e-3)
    width = student.ppf(0.975, SEEDS - 1) * error
    assert float(shown[0][2]) == pytest.approx(width, abs=0.06)
    assert text.count("<td>largest of all states</td>") == len(DAMPINGS)
    (only,) = contributions(result)  # the largest tension of all states is no sum over them
    assert only.unit == "MWh"
    assert only.values[..., 0].sum() == pytest.approx(energy)


def test_the_page_has_every_number_once(tmp_path: Path) -> None:
    result = load_study_result(samples(tmp_path, 300))
    content = content_of(result, [])
    assert content.exact
    names = [one["name"] for one in content.data["runs"]["variables"]]  # pyrefly: ignore[bad-index]
    assert names == ["m", "c", "mean_power", "most_tension", "wall_time", "start_up"]
    assert content.data["designs"]["variables"] == []  # pyrefly: ignore[bad-index]
    assert content.data["failures"] == {"texts": ["it broke"], "runs": [[0, 0], [100, 0], [200, 0]]}
    assert content.data["series"] is None
    states = load_study_result(matrix(tmp_path, failing=False))
    dims = content_of(states, []).data["dims"]  # maps show sea states first
    assert [one["name"] for one in dims if one["state"]] == ["Hs", "Tp"]  # pyrefly: ignore[not-iterable]


def test_texts_stay_texts_in_the_page_of_a_study(tmp_path: Path) -> None:
    file = matrix(tmp_path)
    own = report_of_study(file, tmp_path / "own.html")
    assert m4e.write_report(file).read_bytes() == own.read_bytes()
    page = report_of_study(file, tmp_path / "r.html", command=EVIL).read_text("utf-8")
    assert EVIL not in page
    assert "&lt;img src=x onerror=alert(1)&gt;" in page
    assert page.count("<script") == page.count("</script>")


def test_series_at_times_of_their_own_are_in_the_file_only(tmp_path: Path) -> None:
    records = [
        Record(time=time, series={"buoy.z": 2.0 * time})
        for time in (np.array([0.0, 0.5, 2.0]), np.array([0.0, 1.0]))
    ]
    path = written(tmp_path, Grid((axis("Hs", (1.0, 2.0)),)), records, (), series=("buoy.z",))
    assert load_study_result(path).series is None
    page = report_of_study(path, tmp_path / "r.html").read_text("utf-8")
    assert "each run has rows at times of its own" in page


@pytest.mark.parametrize(
    ("attributes", "said"),
    [
        ({}, "no result of a study, or an old one"),
        ({"record": "{"}, "damaged"),
        ({"record": '{"format": 9}'}, "of format 9"),
        (None, "no netCDF file of a study"),
    ],
)
def test_files_that_are_no_results_are_refused(
    attributes: dict[str, str] | None, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "r.nc"
    if attributes is None:
        path.write_bytes(b"nothing")
    else:
        xarray.Dataset(attrs=attributes).to_netcdf(path)
    with pytest.raises(InputError, match=said):
        report_of_study(path, tmp_path / "r.html")
    assert not (tmp_path / "r.html").exists()


LARGE = 10**30
ODD = "=HYPERLINK(1)"


def odd_dataset() -> xarray.Dataset:
    grid = Grid((axis("seed", [1, LARGE]), axis("kind", ["plain", "-x"])))
    study = Study("s", Path("x"), True, grid, (Wanted("z", "b.z", "mean"),))
    records = [Record(values={"z": -1.5}), *[Record(failure=f"{ODD}\udcff")] * 3]
    return dataset(
        study, records, Labels(), start_up=[0.0] * 4, attributes={"source": "folder\udcff"}
    )


def test_whole_numbers_and_names_that_files_do_not_have(tmp_path: Path) -> None:
    path = tmp_path / "s.nc"
    write_dataset(odd_dataset(), path)
    with xarray.open_dataset(path) as found:
        assert found["seed"].values.tolist() == [1.0, 1e30]
        assert found.attrs["source"] == "folder?"
        assert str(found["failure"].values[1, 1]) == f"{ODD}?"


def test_a_table_has_no_formulas(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    write_dataset(odd_dataset(), path)
    head, first, second, *_ = csv.reader(path.read_text("utf-8").splitlines())
    assert first[head.index("z")] == "-1.5"
    assert second[head.index("kind")] == "'-x"
    assert second[head.index("failure")] == f"'{ODD}?"
