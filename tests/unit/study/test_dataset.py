"""Result files of studies: odd numbers and texts."""

from __future__ import annotations

import csv
from pathlib import Path

import xarray
from support.written_study import axis

from m4e_fmi.study.dataset import Labels, dataset, write_dataset
from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.study import Study, Wanted
from m4e_fmi.study.runs.record import Record

LARGE = 10**30
ODD = "=HYPERLINK(1)"


def made() -> xarray.Dataset:
    grid = Grid((axis("seed", [1, LARGE]), axis("kind", ["plain", "-x"])))
    study = Study("s", Path("x"), True, grid, (Wanted("z", "b.z", "mean"),))
    records = [Record(values={"z": -1.5}), *[Record(failure=f"{ODD}\udcff")] * 3]
    return dataset(
        study, records, Labels(), start_up=[0.0] * 4, attributes={"source": "folder\udcff"}
    )


def test_whole_numbers_and_names_that_files_do_not_have(tmp_path: Path) -> None:
    path = tmp_path / "s.nc"
    write_dataset(made(), path)
    with xarray.open_dataset(path) as found:
        assert found["seed"].values.tolist() == [1.0, 1e30]
        assert found.attrs["source"] == "folder?"
        assert str(found["failure"].values[1, 1]) == f"{ODD}?"


def test_a_table_has_no_formulas(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    write_dataset(made(), path)
    head, first, second, *_ = csv.reader(path.read_text("utf-8").splitlines())
    assert first[head.index("z")] == "-1.5"
    assert second[head.index("kind")] == "'-x"
    assert second[head.index("failure")] == f"'{ODD}?"
