"""Results with Integers, Booleans, enumerations and Strings: in files, pictures and summaries."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cli import main
from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Simulation,
    System,
    run,
    save_system,
    start,
)
from m4e_fmi.errors import InputError
from m4e_fmi.report import plot_run
from m4e_fmi.report.drawing.figures import _fill
from m4e_fmi.report.panels import by_unit
from m4e_fmi.results.recorded import Recorded
from m4e_fmi.results.results_file import Results, load, write_netcdf
from m4e_fmi.results.row_header import Column, Section

Fmus = Callable[[str], Path]
N = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3]
"""Periods of 0.3 s that have passed, at steps of 0.1 s."""
ITEMS = {"off": 1, "slow": 2, "fast": 3}


@pytest.fixture(scope="module")
def system(c_fmu: Fmus) -> System:
    parts = (
        Component("a", FmuFile(c_fmu("kinds+state")), {"period": 0.3}),
        Component("b", FmuFile(c_fmu("3:kinds+state+through")), {"period": 0.3}),
    )
    links = (
        *(f"a.y_{kind} -> b.u_{kind}" for kind in ("bool", "enum", "text")),
        "a.y_int -> b.u_list[3]",
    )
    return System("types", parts, links, Simulation(1.0, 0.1))


def check(results: Results) -> None:
    def values(name: str) -> list:
        return results[name].values.tolist()

    assert values("a.y_int") == N
    assert values("a.y_bool") == [bool(n % 2) for n in N]
    assert values("a.y_enum") == [n % 3 + 1 for n in N]
    assert values("a.y_text") == [str(n) if n else "" for n in N]
    assert values("b.y_text") == [f"{n}{n}" if n else "" for n in N]
    assert values("b.y_bool") == [False] * len(N)
    assert values("b.y_uint64") == N
    assert results["a.y_enum"].recorded.items == ITEMS
    types = ("Real", "Integer", "Boolean", "Enumeration", "String")
    kinds = ("real", "int", "bool", "enum", "text")
    assert tuple(results[f"a.y_{kind}"].recorded.type for kind in kinds) == types
    widths = [results[f"b.y_{kind}"].values.dtype for kind in ("int8", "uint16", "int64")]
    assert widths == [np.int8, np.uint16, np.int64]


def test_netcdf_has_them_in_their_own_types(system: System, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    results = run(system, results=tmp_path / "r.nc").results()
    check(results)
    with xarray.open_dataset(tmp_path / "r.nc", group="a") as found:
        assert found["y_text"].values.tolist()[-1] == "3"
        assert found["y_bool"].values.tolist() == [n % 2 for n in N]
        flags = found["y_enum"].attrs
        assert flags["flag_meanings"] == "off slow fast"
        assert flags["flag_values"].tolist() == [1, 2, 3]
        assert found["y_bool"].attrs["flag_meanings"] == "false true"


def test_a_run_that_goes_on_can_be_read(system: System, tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    with start(system, results=path) as stepped:
        for point in stepped:
            if point.time > 0.75:
                stepped._master._results.flush()  # pyright: ignore  as after a second
                break
        found = load(path)
        assert found["a.y_text"].values.tolist() == ["", "", "", "1", "1", "1", "2", "2", "2"]
        assert found["a.y_bool"].values.tolist() == [bool(n % 2) for n in N[:9]]
        assert found["a.y_enum"].recorded.items == ITEMS


def test_csv_and_parquet(system: System, tmp_path: Path) -> None:
    run(system, results=tmp_path / "r.csv")
    with (tmp_path / "r.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["a.y_int"] for row in rows] == [str(n) for n in N]
    assert [row["a.y_bool"] for row in rows] == [str(n % 2) for n in N]
    assert rows[-1]["b.y_text"] == "33"
    parquet = pytest.importorskip("pyarrow.parquet")
    run(system, results=tmp_path / "r.parquet")
    table = parquet.read_table(tmp_path / "r.parquet")
    assert table["a.y_bool"].to_pylist() == [bool(n % 2) for n in N]
    assert table["a.y_text"].to_pylist()[-1] == "3"
    assert str(table["b.y_int8"].type) == "int8"


def test_arrays_that_are_connected_are_recorded(
    system: System, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.connections.recorded_variables.LARGEST_ARRAY", 1)
    parts = system.components
    back = System("s", (parts[1], parts[0]), ("b.y_list[3] -> a.u_int",), system.simulation)
    names = run(back, results=tmp_path / "r.nc").results().series
    assert {"b.y_list[1]", "b.y_list[2]", "b.y_list[3]"} <= names.keys()
    assert "b.y_words[1]" not in names
    chosen = run(back, results=tmp_path / "r.nc", variables=["b.y_words", "a.u_int", "*bool"])
    found = chosen.results().series.keys()
    assert found == {"b.y_words[1]", "b.y_words[2]", "a.u_int", "a.y_bool", "b.y_bool"}


def test_pictures_show_them_as_steps(system: System, tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    results = run(system, results=tmp_path / "r.nc").results()
    found = {panel.title: panel for panel in by_unit(results.series)}
    assert found.keys() == {"", "Integer", "Boolean", "Enumeration"}
    assert found["Enumeration"].items == ITEMS
    axis = Figure().subplots()
    _fill(axis, results.time, found["Boolean"])
    assert {line.get_drawstyle() for line in axis.get_lines()} == {"steps-post"}
    with pytest.raises(InputError, match=r"a\.y_text is text"):
        plot_run(tmp_path / "r.nc", tmp_path / "r.png", variables=["a.y_text"])


def test_run_and_info_tell_of_them(
    system: System, c_fmu: Fmus, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    package = str(save_system(system, tmp_path / "s.ssp"))
    assert main(["run", package, "--output-file", str(tmp_path / "r.nc")]) == 0
    told = capsys.readouterr().out
    assert "Boolean: 3 changes, true at the end" in told
    assert "String: 3 changes, '33' at the end" in told
    assert main(["info", package]) == 0
    told = capsys.readouterr().out
    assert "a.y_enum -> b.u_enum  (1 variable, Enumeration)" in told
    assert "held during each step: a change acts from the end of its step" in told
    assert main(["info", str(c_fmu("3:kinds+state"))]) == 0
    told = capsys.readouterr().out
    assert "Enumeration (off, slow, fast)" in told
    assert "y_list[3]" in told
    assert "UInt16" in told


def test_items_keep_their_names(tmp_path: Path) -> None:
    """Blanks become underscores in CF's flags: the true names are kept beside them."""
    items = {"very low pressure": 1, "very_low_pressure": 2, "": 3, "a" * 80: 4}
    one = Recorded("Enumeration", "i4", items)
    section = Section("valve", (Column("mode", "", "", one),), "i8")
    rows = [np.array([[0.0], [1.0]]), np.array([[1], [2]])]
    write_netcdf(tmp_path / "r.nc", [section], {}, 2, [rows])
    found = load(tmp_path / "r.nc")["valve.mode"]
    assert found.recorded == one
    assert found.recorded.told(found[0]) == "very low pressure"
    assert repr(found).startswith("mode: 2 values")
