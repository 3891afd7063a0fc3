"""Results with Integers, Booleans, enumerations and Strings: in all files, and in pictures."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus
from support.small_systems import system as coupled

from m4e_fmi.cosim import System, run, start
from m4e_fmi.errors import InputError
from m4e_fmi.report import plot_run
from m4e_fmi.report.panels import by_unit
from m4e_fmi.results.results_file import load_results, write_netcdf
from m4e_fmi.results.row_file import ResultColumn, RowSection
from m4e_fmi.results.series import Recorded

N = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3]
"""Periods of 0.3 s that have passed, at steps of 0.1 s."""
ITEMS = {"off": 1, "slow": 2, "fast": 3}
TYPES = {"real": "Real", "int": "Integer", "bool": "Boolean", "enum": "Enumeration"}


@pytest.fixture(scope="module")
def system(c_fmu: Fmus) -> System:
    links = (
        *(f"a.y_{kind} -> b.u_{kind}" for kind in ("bool", "enum", "text")),
        "a.y_int -> b.u_list[3]",
    )
    names = {"a": "kinds+state", "b": "3:kinds+state+through"}
    return coupled(c_fmu, names, *links, start={name: {"period": 0.3} for name in "ab"})


def test_netcdf_has_them_in_their_own_types(system: System, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    results = run(system, results=tmp_path / "r.nc").results()
    expected = {
        "a.y_int": N,
        "a.y_bool": [bool(n % 2) for n in N],
        "a.y_enum": [n % 3 + 1 for n in N],
        "a.y_text": [str(n) if n else "" for n in N],
        "b.y_text": [f"{n}{n}" if n else "" for n in N],
        "b.y_bool": [False] * len(N),
        "b.y_uint64": N,
    }
    assert {name: results[name].values.tolist() for name in expected} == expected
    assert results["a.y_enum"].recorded.items == ITEMS
    types = TYPES | {"text": "String"}
    assert {kind: results[f"a.y_{kind}"].recorded.type for kind in types} == types
    widths = [results[f"b.y_{kind}"].values.dtype for kind in ("int8", "uint16", "int64")]
    assert widths == [np.int8, np.uint16, np.int64]
    with xarray.open_dataset(tmp_path / "r.nc", group="a") as found:
        assert found["y_text"].values.tolist()[-1] == "3"
        assert found["y_bool"].values.tolist() == [n % 2 for n in N]
        flags = found["y_enum"].attrs
        assert flags["flag_meanings"] == "off slow fast"
        assert flags["flag_values"].tolist() == [1, 2, 3]
        assert found["y_bool"].attrs["flag_meanings"] == "false true"
    assert {panel.title for panel in by_unit(results.series)} == {"", *TYPES.values()} - {"Real"}
    with pytest.raises(InputError, match=r"a\.y_text is text"):
        plot_run(tmp_path / "r.nc", tmp_path / "r.png", variables=["a.y_text"])


def test_a_run_that_goes_on_can_be_read(
    system: System, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 0.0)
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.SHARE", 1e9)
    with start(system, results=tmp_path / "r.nc") as stepped:
        for _ in range(8):
            stepped.step()
        found = load_results(tmp_path / "r.nc")
        count = len(found.time)
        assert count >= 8
        assert found["a.y_text"].values.tolist() == [str(n) if n else "" for n in N[:count]]
        assert found["a.y_bool"].values.tolist() == [bool(n % 2) for n in N[:count]]
        assert found["a.y_enum"].recorded.items == ITEMS


def test_csv(system: System, tmp_path: Path) -> None:
    run(system, results=tmp_path / "r.csv")
    with (tmp_path / "r.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["a.y_int"] for row in rows] == [str(n) for n in N]
    assert [row["a.y_bool"] for row in rows] == [str(n % 2) for n in N]
    assert rows[-1]["b.y_text"] == "33"


def test_arrays_that_are_connected_are_recorded(
    system: System, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.wiring.prepared.LARGEST_ARRAY", 1)
    back = System("s", system.components[::-1], ("b.y_list[3] -> a.u_int",), system.simulation)
    names = run(back, results=tmp_path / "r.nc").results().series
    assert {"b.y_list[1]", "b.y_list[2]", "b.y_list[3]"} <= names.keys()
    assert "b.y_words[1]" not in names
    chosen = run(back, results=tmp_path / "r.nc", variables=["b.y_words", "a.u_int", "*bool"])
    found = chosen.results().series.keys()
    assert found == {"b.y_words[1]", "b.y_words[2]", "a.u_int", "a.y_bool", "b.y_bool"}


def test_items_keep_their_names(tmp_path: Path) -> None:
    """Blanks become underscores in CF's flags: the true names are kept beside them."""
    items = {"very low pressure": 1, "very_low_pressure": 2, "": 3, "a" * 80: 4}
    one = Recorded("Enumeration", "i4", items)
    section = RowSection("valve", (ResultColumn("mode", "", "", one),), "i8")
    rows = [np.array([[0.0], [1.0]]), np.array([[1], [2]])]
    write_netcdf(tmp_path / "r.nc", [section], {}, 2, [rows])
    found = load_results(tmp_path / "r.nc")["valve.mode"]
    assert found.recorded == one
    assert found.recorded.text(found[0]) == "very low pressure"
