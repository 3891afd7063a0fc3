"""Each reader of records over time is asked the same: netCDF, rows of a killed run, CSV.

A new form is tested by its entry in `FORMS`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from netCDF4 import Dataset

import m4e_fmi
from m4e_fmi.errors import InputError
from m4e_fmi.results.compared_file import read_compared
from m4e_fmi.results.row_file import ResultColumn, RowFile, RowSection

TIME = (0.0, 0.1, 0.2, 0.4)
PLACE = np.array([1.5, np.nan, 0.25, -3e-7])


def killed_run(path: Path, time: Sequence[float], place: np.ndarray) -> None:
    file = RowFile(
        path, [RowSection("buoy", (ResultColumn("z", "m", "heave"),))], {"title": "rows"}
    )
    file.append(0, [np.array(time)[:, np.newaxis], place[:, np.newaxis]])
    file.close()


def netcdf(path: Path, time: Sequence[float], place: np.ndarray) -> None:
    """As m4e_fmi wrote them before they had a number."""
    with Dataset(path, "w") as file:
        file.createDimension("time", None)
        file.createVariable("time", "f8", ("time",))[:] = time
        variable = file.createGroup("buoy").createVariable("z", "f8", ("time",))
        variable.setncatts({"units": "m", "long_name": "heave"})
        variable[:] = place


def table(path: Path, time: Sequence[float], place: np.ndarray) -> None:
    rows = [f"{t!r},{x!r}" for t, x in zip(time, place.tolist(), strict=True)]
    path.write_text("\n".join(["time [s],buoy.z [m]", *rows]), encoding="utf-8")


FORMS: dict[str, Callable[[Path, Sequence[float], np.ndarray], None]] = {
    "killed.nc": killed_run,
    "whole.nc": netcdf,
    "table.csv": table,
}


@pytest.mark.parametrize("form", FORMS)
def test_records_are_read_to_the_bit(form: str, tmp_path: Path) -> None:
    FORMS[form](tmp_path / form, TIME, PLACE)
    found = read_compared(tmp_path / form)
    assert found.time.tolist() == [*TIME]
    assert [*found.quantities] == ["buoy.z"]
    assert found.quantities["buoy.z"].unit == "m"
    np.testing.assert_array_equal(found.quantities["buoy.z"].values, PLACE)


@pytest.mark.parametrize("form", FORMS)
def test_a_record_is_within_no_difference_of_itself_in_another_form(
    form: str, tmp_path: Path
) -> None:
    FORMS[form](tmp_path / form, TIME, PLACE)
    table(tmp_path / "reference.csv", TIME, np.append(PLACE[:3], 0.0))
    found = m4e_fmi.compare(tmp_path / form, tmp_path / "reference.csv")["buoy.z"]
    assert (found.largest, found.time[-1]) == (3e-7, 0.4)


@pytest.mark.parametrize("times", [(1.0, 0.0), (0.0, np.nan), (0.0, np.inf)])
@pytest.mark.parametrize("form", FORMS)
def test_times_that_do_not_increase_are_refused(
    form: str, times: tuple[float, float], tmp_path: Path
) -> None:
    FORMS[form](tmp_path / form, times, PLACE[2:])
    with pytest.raises(InputError, match=r"follows|finite|missing"):
        read_compared(tmp_path / form)


@pytest.mark.parametrize("form", FORMS)
def test_a_file_that_is_cut_off_is_refused(form: str, tmp_path: Path) -> None:
    FORMS[form](tmp_path / form, TIME, PLACE)
    content = (tmp_path / form).read_bytes()
    for size in (int(0.05 * len(content)), content.rindex(b"," if b"," in content else b"\0")):
        (tmp_path / form).write_bytes(content[:size])
        with pytest.raises(InputError, match=form):
            read_compared(tmp_path / form)
