"""Dates and times of day in tables: forms, columns, midnight."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import pytest

from m4e_fmi.results.compared_file import ComparedFile, read_compared

FORMS = {
    "ISO 8601": "timestamp,x [m]\n{0}T12:00:00.250,1\n{0}T12:00:00.5,2\n{0}T12:00:01,3\n",
    "a blank, quoted": 'Date,x [m]\n"{0} 12:00:00.250",1\n"{0} 12:00:00.500",2\n'
    '"{0} 12:00:01.0",3\n',
    "UTC": "time,x [m]\n{0}T12:00:00.250Z,1\n{0}T12:00:00.5Z,2\n{0}T12:00:01Z,3\n",
    "offsets": "time,x [m]\n{0}T12:00:00.250+01:00,1\n{0}T12:00:00.5+0100,2\n{0}T10:00:01-01,3\n",
    "two columns": "Date,Time,x [m]\n{0},12:00:00.25,1\n{0},12:00:00.5,2\n{0},12:00:01,3\n",
    "decimal commas": "Zeit;x [m]\n01.03.2026 12:00:00,250;1,0\n01.03.2026 12:00:00,5;2,0\n"
    "01.03.2026 12:00:01;3,0\n",
    "blanks": "time x\n[-] [m]\n{0} 12:00:00.25 1\n{0} 12:00:00.5 2\n{0} 12:00:01 3\n",
    "blanks, two names": "date time x(m)\n{0} 12:00:00.25 1\n{0} 12:00:00.5 2\n{0} 12:00:01 3\n",
    "blanks and commas": "time x(m)\n{0} 12:00:00,25 1,0\n{0} 12:00:00,5 2,0\n{0} 12:00:01 3,0\n",
    "time of day": "Time,x [m]\n12:00:00.25,1\n12:00:00.50,2\n12:00:01.00,3\n",
    "day or month": "t,x [m]\n03/01/26 11:59:59.75 AM,1\n03/01/26 12:00:00 PM,2\n"
    "03/01/26 12:00:00.5 PM,3\n",
    "MATLAB": "t,x [m]\n01-Mar-2026 12:00:00.25,1\n01-Mar-2026 12:00:00.5,2\n"
    "01-Mar-2026 12:00:01,3\n",
    "a row number before": "n,TIMESTAMP,x [m]\n7,{0} 12:00:00.25,1\n8,{0} 12:00:00.5,2\n"
    "9,{0} 12:00:01,3\n",
    "TOA5": '"TOA5","CR1000","tank"\n"TIMESTAMP","RECORD","x"\n"TS","RN","m"\n"","","Avg"\n'
    '"{0} 12:00:00.25",7,1\n"{0} 12:00:00.5",8,2\n"{0} 12:00:01",9,3\n',
    "metadata": "Start: {0} 11:00:00\nn,Time,x [m]\n7,{0} 12:00:00.25,1\n8,{0} 12:00:00.5,2\n"
    "9,{0} 12:00:01,3\n",
}


def read(folder: Path, text: str) -> ComparedFile:
    path = folder / "logger.csv"
    path.write_text(text, encoding="utf-8")
    return read_compared(path)


@pytest.mark.parametrize("form", FORMS)
def test_all_forms_are_seconds_from_the_first_row(form: str, tmp_path: Path) -> None:
    found = read(tmp_path, FORMS[form].format("2026-03-01"))
    # of days after the year 0, in seconds, a double has 8e-6 s; of differences on one day less
    assert found.time.tolist() == pytest.approx([0.0, 0.25, 0.75], abs=1e-9)
    assert found.quantities["x"].values.tolist() == [1.0, 2.0, 3.0]
    assert found.quantities["x"].unit == "m"
    assert any(note.startswith("times are seconds from the first row, ") for note in found.notes)
    assert found.zoned == (form in ("UTC", "offsets"))
    assert (found.origin is None) == (form in ("time of day", "day or month"))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("2026-02-28 23:59:59.5", "2026-03-01 00:00:00.5"),
        ("28.02.2026 23:59:59.5", "01.03.2026 00:00:00.5"),
        ("12/31/2026 11:59:59.5 PM", "01/01/2027 12:00:00.5 AM"),
        ("28-Feb-2026 23:59:59.5", "1 Mar 2026 00:00:00.5"),
    ],
)
def test_a_record_goes_on_after_midnight(before: str, after: str, tmp_path: Path) -> None:
    assert read(tmp_path, f"t,x\n{before},1\n{after},2\n").time.tolist() == [0.0, 1.0]


def test_a_time_in_seconds_is_preferred(tmp_path: Path) -> None:
    found = read(tmp_path, "stamp,time [s],x\n2026-03-01 12:00:00,5,1\n2026-03-01 12:00:01,6,2\n")
    assert found.time.tolist() == [5.0, 6.0]
    assert "dates or times of day in 'stamp' left out: a time in seconds is there" in found.notes
    assert list(found.quantities) == ["x"]
    found = read(tmp_path, "stamp,T\n2026-03-01 12:00:00,5\n2026-03-01 12:00:01,6\n")
    assert found.time.tolist() == [0.0, 1.0]
    assert list(found.quantities) == ["T"]  # a temperature


@pytest.mark.parametrize(("unit", "zone"), [("ms", None), ("us", "UTC"), ("ns", None)])
def test_dates_of_parquet_are_those_of_a_table(unit: str, zone: str | None, tmp_path: Path) -> None:
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    first = datetime(2026, 3, 1, 12, 0, 0, 250_000)
    times = [first + timedelta(seconds=0.25 * k) for k in range(4)]
    columns = {
        "when": pyarrow.array(times, pyarrow.timestamp(unit, tz=zone)),
        "x [ft]": pyarrow.array([1.0, 2.0, 3.0, 4.0]),
    }
    parquet.write_table(pyarrow.table(columns), tmp_path / "logger.parquet")
    found = read_compared(tmp_path / "logger.parquet")
    text = read(tmp_path, FORMS["ISO 8601"].format("2026-03-01"))
    assert found.time.tolist() == [0.0, 0.25, 0.5, 0.75]
    assert found.origin == text.origin
    assert found.zoned == (zone is not None)
    assert found.quantities["x"].unit == "ft"
