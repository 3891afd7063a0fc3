"""Files with numbers over dimensions, cell by cell."""

from __future__ import annotations

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


@pytest.fixture
def reference(tmp_path: Path) -> Path:
    return study(tmp_path / "b.nc")


def test_a_difference_in_one_cell(tmp_path: Path, reference: Path) -> None:
    other = POWER.copy()
    other[1, 2] += 3.0
    one = study(tmp_path / "a.nc", other)
    found = compare_cells(one, reference, tolerance=0.03)["power"]
    assert found.largest == pytest.approx(3.0)
    assert found.largest_at == {"height": 2.0, "period": 10.0}
    assert found.rms == pytest.approx(3.0 / np.sqrt(12.0))
    assert found.largest_share == pytest.approx(3.0 / 102.0)
    assert compare_cells(one, reference, tolerance=0.03).is_within
    assert compare_cells(one, reference, tolerance=0.029).beyond == ("power",)
    assert compare_cells(one, reference, relative_to="value")["power"].scale == 108.0
    command = ["compare", str(one), str(reference), "--tolerance"]
    assert [main([*command, tolerance]) for tolerance in ("0.029", "0.03")] == [1, 0]


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


def test_cells_without_a_number_are_within_no_tolerance(tmp_path: Path, reference: Path) -> None:
    """A sea state that was left out, or a run that failed; those of the reference may lack."""
    broken = POWER.copy()
    broken[0, 1] = np.nan
    less = study(tmp_path / "a.nc", POWER[:2], [1.0, 2.0])
    for one in (less, study(tmp_path / "c.nc", broken)):
        assert compare_cells(one, reference, tolerance=0.5).beyond == ("power",)
        assert compare_cells(reference, one, tolerance=0.5).is_within


def test_what_has_no_numbers_in_either_file_is_noted(tmp_path: Path) -> None:
    """Coupling errors of a study of one model are all missing."""
    one = study(tmp_path / "a.nc", coupling_error=np.nan, wall_time=1.0)
    other = study(tmp_path / "b.nc", coupling_error=1.0, wall_time=2.0)
    found = compare_cells(one, one, tolerance=0.0)
    assert found.is_within
    assert list(found.differences) == ["power"]
    assert "coupling_error: no numbers in either file" in found.notes
    assert "wall_time: depends on the machine, not compared" in found.notes
    assert compare_cells(one, other, variables=["wall_time"])["wall_time"].largest == 1.0
    for file, reference, given in ((one, other, None), (other, one, None),
                                   (one, one, ["coupling_error"])):  # fmt: skip
        with pytest.raises(InputError, match="coupling_error: no cell has a number in both"):
            compare_cells(file, reference, variables=given)


def test_files_that_do_not_fit_are_refused(tmp_path: Path, reference: Path) -> None:
    empty = study(tmp_path / "d.nc", np.full((3, 4), np.nan))
    for one, other, given, said in (
        (reference, study(tmp_path / "e.nc", unit="m"), {}, "kW and m are of different dimension"),
        (reference, study(tmp_path / "c.nc", heights=[7, 8, 9]), {}, "no value of height in comm"),
        (reference, empty, {}, "no cell has a number in both"),
        (empty, empty, {}, "no numbers in common"),
        (reference, tmp_path / "none.nc", {}, "is no netCDF file with numbers"),
        (reference, reference, {"variables": ["pwer"]}, "did you mean 'power'"),
        (reference, reference, {"relative_to": "rage", "tolerance": -1.0},
         r"relative_to is 'rage'(.|\n)*the tolerance is -1"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said):
            compare_cells(one, other, **given)  # type: ignore[arg-type]
    assert main(["compare", str(reference), str(reference), "--start-time", "3"]) == 2


def test_many_values_take_no_square_of_memory(tmp_path: Path) -> None:
    """All pairs of them would be 80 GB."""
    path, count = tmp_path / "a.nc", 100_000
    with netcdf(path) as file:
        file.createDimension("sample", count)
        file.createVariable("sample", "f8", ("sample",))[:] = np.arange(count)[::-1]
        file.createVariable("power", "f8", ("sample",))[:] = np.arange(count)
    assert compare_cells(path, path)["power"].largest == 0.0
