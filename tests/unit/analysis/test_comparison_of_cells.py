"""Files with numbers over dimensions, cell by cell."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.analysis.comparison import compare_cells
from m4e_fmi.cli import main
from m4e_fmi.errors import InputError
from m4e_fmi.files.writing import netcdf

HEIGHTS, PERIODS = [1.0, 2.0, 3.0], [6.0, 8.0, 10.0, 12.0]
POWER = np.outer(np.square(HEIGHTS), PERIODS)
"""From 6 to 108 kW."""


def study(
    path: Path,
    power: np.ndarray = POWER,
    heights: Sequence[float] = HEIGHTS,
    unit: str = "kW",
    **more: float,
) -> Path:
    with netcdf(path) as file:
        for name, values in (("height", heights), ("period", PERIODS)):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        file.createVariable("power", "f8", ("height", "period"))[:] = power
        file["power"].units = unit
        for name, value in more.items():
            file.createVariable(name, "f8", ())[...] = value
    return path


def test_a_difference_in_one_cell(tmp_path: Path) -> None:
    other = POWER.copy()
    other[1, 2] += 3.0
    one, reference = study(tmp_path / "a.nc", other), study(tmp_path / "b.nc")
    found = compare_cells(one, reference, tolerance=0.03)["power"]
    assert found.largest == pytest.approx(3.0)
    assert found.largest_at == {"height": 2.0, "period": 10.0}
    assert found.rms == pytest.approx(3.0 / np.sqrt(12.0))
    assert found.largest_share == pytest.approx(3.0 / 102.0)
    assert compare_cells(one, reference, tolerance=0.03).is_within
    assert compare_cells(one, reference, tolerance=0.029).beyond == ("power",)
    assert compare_cells(one, reference, relative_to="value")["power"].scale == 108.0


def test_cells_belong_together_by_the_values_of_their_dimensions(tmp_path: Path) -> None:
    """A study with fewer and other heights, in another order and unit, with a failed run."""
    power = 1e3 * np.outer([9.0, 1.0, 25.0], PERIODS)
    power[1, 0] = np.nan
    other = study(tmp_path / "b.nc", power, [3.0, 1.0, 5.0], "W", cost=1.0)
    found = compare_cells(study(tmp_path / "a.nc", revenue=2.0), other)
    assert found["power"].largest == pytest.approx(0.0, abs=1e-12)
    assert found["power"].left_out == 1
    assert found["power"].values.shape == (2, 4)
    assert found.notes == ("height: 2 values are in both files, of 3 and 3",)
    assert found["power"].lacking == 4  # those at 5 m
    assert (found.only_here, found.only_there) == (("revenue",), ("cost",))
    assert "power: largest" in repr(found)


def test_cells_that_are_only_in_the_reference_are_within_no_tolerance(tmp_path: Path) -> None:
    """A study of which a sea state was left out does not pass; one with more of them does."""
    less = study(tmp_path / "a.nc", POWER[:2], [1.0, 2.0])
    reference = study(tmp_path / "b.nc")
    assert compare_cells(less, reference, tolerance=0.01).beyond == ("power",)
    assert compare_cells(reference, less, tolerance=0.01).is_within


def test_what_has_no_numbers_in_either_file_is_noted(tmp_path: Path) -> None:
    """Coupling errors of a study of one model are all missing."""
    one = study(tmp_path / "a.nc", coupling_error=np.nan)
    found = compare_cells(one, one, tolerance=0.0)
    assert found.is_within
    assert list(found.differences) == ["power"]
    assert found.notes == ("coupling_error: no numbers in either file",)
    other = study(tmp_path / "b.nc", coupling_error=1.0)
    for file, reference in ((one, other), (other, one)):
        with pytest.raises(InputError, match="coupling_error: no cell has a number in both"):
            compare_cells(file, reference)
    with pytest.raises(InputError, match="coupling_error: no cell has a number in both"):
        compare_cells(one, one, variables=["coupling_error"])


def test_the_wall_time_of_runs_is_compared_on_request(tmp_path: Path) -> None:
    one = study(tmp_path / "a.nc", wall_time=1.0)
    other = study(tmp_path / "b.nc", wall_time=2.0)
    found = compare_cells(one, other, tolerance=0.0)
    assert found.is_within
    assert found.notes == ("wall_time: depends on the machine, not compared",)
    assert compare_cells(one, other, variables=["wall_time"])["wall_time"].largest == 1.0


def test_files_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    one = study(tmp_path / "a.nc")
    for other, message in (
        (study(tmp_path / "b.nc", unit="m"), "kW and m are of different dimension"),
        (study(tmp_path / "c.nc", heights=[7.0, 8.0, 9.0]), "no value of height in common"),
        (study(tmp_path / "d.nc", np.full((3, 4), np.nan)), "no cell has a number in both"),
        (tmp_path / "none.nc", "is no netCDF file with numbers"),
    ):
        with pytest.raises(InputError, match=message):
            compare_cells(one, other)
    with pytest.raises(InputError, match="did you mean 'power'"):
        compare_cells(one, one, variables=["pwer"])


def test_values_that_are_there_twice_belong_together_in_their_order(tmp_path: Path) -> None:
    one = study(tmp_path / "a.nc", heights=[1.0, 1.0, 3.0])
    found = compare_cells(one, one)["power"]
    assert found.largest == 0.0
    assert found.values.shape == POWER.shape


def test_many_values_take_no_square_of_memory(tmp_path: Path) -> None:
    """All pairs of them would be 80 GB."""
    path, count = tmp_path / "a.nc", 100_000
    with netcdf(path) as file:
        file.createDimension("sample", count)
        file.createVariable("sample", "f8", ("sample",))[:] = np.arange(count)[::-1]
        file.createVariable("power", "f8", ("sample",))[:] = np.arange(count)
    assert compare_cells(path, path)["power"].largest == 0.0


def test_wrong_numbers_are_told_together(tmp_path: Path) -> None:
    one = study(tmp_path / "a.nc")
    with pytest.raises(InputError, match=r"relative_to is 'rage'(.|\n)*the tolerance is -1"):
        compare_cells(one, one, relative_to="rage", tolerance=-1.0)


def test_files_without_a_number_have_nothing_to_compare(tmp_path: Path) -> None:
    empty = study(tmp_path / "c.nc", np.full((3, 4), np.nan))
    with pytest.raises(InputError, match="no numbers in common"):
        compare_cells(empty, empty)


def test_the_command(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study(here / "a.nc", 1.02 * POWER)
    study(here / "b.nc")
    assert main(["compare", "a.nc", "b.nc", "--tolerance", "0.01"]) == 1
    said = capsys.readouterr().out
    assert "height 3, period 12  kW" in said
    assert "1 of 1 variables beyond 1 % of the range" in said
    assert main(["compare", "a.nc", "b.nc", "--tolerance", "0.03", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["variables"]["power"]["largest"] == pytest.approx(0.02 * 108.0)
    assert main(["compare", "a.nc", "b.nc", "--start-time", "3", "--map", "a=b"]) == 2
    assert capsys.readouterr().err.count("is for records over time") == 2
    (here / "c.csv").write_text("t,power\n0,1\n1,2\n")
    assert main(["compare", "a.nc", "c.csv"]) == 2


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_cells_of_failed_runs_are_within_no_tolerance(tmp_path: Path) -> None:
    broken = POWER.copy()
    broken[0, 1] = np.nan
    one, reference = study(tmp_path / "a.nc", broken), study(tmp_path / "b.nc")
    found = compare_cells(one, reference, tolerance=0.5)
    assert found["power"].lacking == 1
    assert found.beyond == ("power",)
    assert compare_cells(reference, one, tolerance=0.5).is_within
