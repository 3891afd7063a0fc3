"""Kept runs: what is there stays, to the bit; failures and damage are told. What is counted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.errors import RunError
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.record import Record, Store, records_of

RECORD = Record(
    values={"a": 0.1 + 0.2, "b": float("nan")},
    time=np.array([0.0, 0.1]),
    series={"x": np.array([1.0, np.nan])},
    warnings=("odd",),
)


@pytest.fixture
def store(tmp_path: Path):
    with Store(tmp_path / "s.sqlite") as store:
        store.keep({"k": RECORD})
        yield store


def test_records_come_back_to_the_bit_and_are_replaced_on_demand_only(
    store: Store, tmp_path: Path
) -> None:
    other = Record(values={"a": 1.0})
    with Store(tmp_path / "s.sqlite") as second:
        second.keep({"k": other, "failed": Record(failure="it broke")})
        found = second.found(["k", "other", "failed"])
        assert list(found) == ["k"]
        assert found["k"].head() == RECORD.head()
        assert found["k"].block() == RECORD.block()
        second.keep({"k": other}, again=True)
    assert store.found(["k"])["k"].values["a"] == 1.0


def test_another_file_is_no_store(tmp_path: Path) -> None:
    (tmp_path / "s.sqlite").write_bytes(b"this is no database" * 100)
    for name, said in (("s.sqlite", "kept runs"), ("s.sqlite/s", "cannot be written")):
        with pytest.raises(RunError, match=said):
            Store(tmp_path / name).__enter__()


def test_a_full_disk_is_told_and_what_is_kept_stays(store: Store) -> None:
    """Nobody is told to remove the file; SQLite has ended the transaction itself by then."""
    large = Record(time=np.zeros(5000), series={"x": np.zeros(5000)})
    store._base.execute("PRAGMA max_page_count = 4")
    with pytest.raises(RunError, match="cannot be written: database or disk is full") as caught:
        store.keep({str(k): large for k in range(50)})
    assert "remove" not in str(caught.value)
    assert store.found(["k"])["k"].head() == RECORD.head()


def test_the_row_at_the_end_of_the_start_up_counts() -> None:
    """The maximum of a falling record is its first row that counts."""
    time = np.arange(5.0)
    (found,) = records_of([Wanted("top", "x", "maximum")], (), time, {"x": -time[None]}, 2.0)
    assert found.values == {"top": -2.0}
