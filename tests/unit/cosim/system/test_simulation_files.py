"""Where a simulation is written to, and in which form."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cli import main
from m4e_fmi.results.results_file import load

EXAMPLES = Path(__file__).parents[4] / "examples"
PENDULUM = str(EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml")


def simulated(*arguments: str) -> int:
    return main(["simulate", PENDULUM, "--stop-time", "0.1", "--no-plot", *arguments])


def test_csv_is_written_beside_netcdf(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path = tmp_path / "swing.csv"
    assert simulated("--output-file", str(path)) == 0
    assert f"wrote {path.with_suffix('.nc')}\nwrote {path}\n" in capsys.readouterr().out
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    results = load(path.with_suffix(".nc"))
    series = results.series
    assert header == ["time [s]", *(f"{name} [{one.unit}]" for name, one in series.items())]
    table = np.array(rows, dtype=float)
    assert np.array_equal(table[:, 0], results.time)
    assert np.array_equal(table[:, 1:].T, [one.values for one in series.values()])


def test_a_form_that_cannot_be_written_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr("m4e_fmi.results.results_file.find_spec", lambda _: None)
    assert simulated("--output-file", str(tmp_path / "swing.parquet")) == 2
    assert "Parquet needs the package pyarrow" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
