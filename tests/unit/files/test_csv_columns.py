"""Columns of CSV files in the forms of other programs.

Mistakes are in tests/corpus/csv_file.yaml.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.files.csv_columns import read_columns


def test_si_units_in_names_and_empty_entries_at_the_end_are_fine(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text("time [s],force [N]\n0,1,\n1,2\n", "utf-8")
    assert read_columns(file, [(0, "s"), (1, "N")]).values == ([0.0, 1.0], [1.0, 2.0])


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


def test_blanks_within_a_name_take_no_time(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text(f"time,a{' ' * 100_000}b\n0,1\n", "utf-8")
    assert read_columns(file, [("time", "s")]).values == ([0.0],)
