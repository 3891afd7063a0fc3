"""Columns of CSV files that look right and are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.files.csv_columns import read_columns


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,-5\n1,1\n2,1\n", "column names are missing"),
        ("time [m],force\n0,1\n1,1\n", "column 'time [m]' is not in a unit of s: m is not s"),
        ("time,force [N]\n0,1\n1,1\n", "'unit: N'"),
        ("time,force [1e2 N]\n0,1\n1,1\n", "column 'force [1e2 N]' is not in a unit of 1: unit"),
        ("time,force\n0,1,5\n1,1\n", "3 entries, the header has 2"),
    ],
)
def test_what_would_be_read_wrongly_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "t.csv"
    file.write_text(text, "utf-8")
    with pytest.raises(InputError, match=r"t\.csv") as caught:
        read_columns(file, [(0, "s"), (1, "1")])
    assert message in str(caught.value)


def test_si_units_in_names_and_empty_entries_at_the_end_are_fine(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text("time [s],force [N]\n0,1,\n1,2\n", "utf-8")
    assert read_columns(file, [(0, "s"), (1, "N")]).values == ([0.0, 1.0], [1.0, 2.0])


DATES = "write dates and times of day as seconds since the first row"


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("time,eta\n2024-06-11T14:00:00,1\n", DATES),
        ("time;eta\n11.06.2024 14:00;1\n", DATES),
        ("time,eta\n14:00:00.5,1\n", DATES),
        ("time,eta\n0,5;1,2\n", "separate the names of the columns as the numbers are"),
        ("# buoy 44, at sea\ntime,eta\n0,1\n", "remove the lines above the names"),
        ("# time,eta\n0,1\n", "remove this mark before the names"),
        ("# time [s],eta [m]\n0,1\n", "remove this mark before the names"),
    ],
)
def test_tables_of_other_forms_are_refused_with_the_remedy(
    tmp_path: Path, text: str, remedy: str
) -> None:
    file = tmp_path / "t.csv"
    file.write_text(text, "utf-8")
    with pytest.raises(InputError) as caught:
        read_columns(file, [("time", "s"), ("eta", "m")])
    assert remedy in str(caught.value)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_other_separators(tmp_path: Path, mark: str) -> None:
    file = tmp_path / "t.csv"
    file.write_text(f"time{mark}force\n0{mark}1\n1{mark}2\n", "utf-8")
    assert read_columns(file, [("time", "s"), ("force", "N")]).values == ([0.0, 1.0], [1.0, 2.0])


def test_a_column_is_asked_for_twice_in_two_units(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text("time,force [kN]\n0,1\n1,2\n", "utf-8")
    found = read_columns(file, [("force", "N"), ("force [kN]", "kN"), ("force", None)])
    assert found.values == ([1000.0, 2000.0], [1.0, 2.0], [1.0, 2.0])
    assert set(found.names) == {"force [kN]"}


@pytest.mark.parametrize("header", ["a,a [m]", "a [m],a [cm]", "a,a"])
def test_columns_of_one_name_are_refused_whatever_their_units(tmp_path: Path, header: str) -> None:
    file = tmp_path / "t.csv"
    file.write_text(f"{header}\n0,1\n", "utf-8")
    with pytest.raises(InputError, match="1:1: two columns are called 'a'"):
        read_columns(file, [("a", "m")])


def test_numbers_that_are_too_large_in_the_unit_asked_for_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text("time,force [kN]\n0,1e306\n", "utf-8")
    assert read_columns(file, [("force", "kN")]).values == ([1e306],)
    with pytest.raises(InputError, match=r"2:1: expected a finite number in column 'force \[kN\]'"):
        read_columns(file, [("force", "kN"), ("force", "N")])


def test_blanks_within_a_name_take_no_time(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text(f"time,a{' ' * 100_000}b\n0,1\n", "utf-8")
    assert read_columns(file, [("time", "s")]).values == ([0.0],)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_decimal_commas(tmp_path: Path, mark: str) -> None:
    """As of a spreadsheet in German: also in names that are numbers, and beside texts."""
    file = tmp_path / "t.csv"
    rows = ("Hs,Tp", "5,5", "note"), ("0,5", "-1,25e3", "a, b"), ("2", "1,250", "")
    file.write_text("\n".join(map(mark.join, rows)), "utf-8")
    assert read_columns(file, [("Hs,Tp", None), ("5.5", None)]).values == (
        [0.5, 2.0],
        [-1250.0, 1.25],
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a;b\n1;1,250\n2;3,000\n", "'1,250' may have a decimal comma, or one between thousands"),
        ("a;b\n1;1,5\n2;3.5\n", "'3.5' has a point"),
    ],
)
def test_commas_that_are_not_clear_are_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "t.csv"
    file.write_text(text, "utf-8")
    with pytest.raises(InputError) as caught:
        read_columns(file, [("a", "1"), ("b", "1")])
    assert message in str(caught.value)
    assert caught.value.problems[0].line == 2


def test_another_encoding_is_named_with_the_remedy(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("time,force\n0,1\n", encoding="utf-16")
    with pytest.raises(InputError, match=r"byte 1 is not valid UTF-8\n +save it as UTF-8"):
        read_columns(file, [(0, "s"), (1, "1")])
