"""The kind `table`: values between rows and at jumps, and what is announced."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from m4e_fmi.cosim import Component, Kind, Simulation, System, prepare, run
from m4e_fmi.errors import RunError
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmus.table import KIND, Config

TIMES = [0.0, 1.0, 1.0, 3.0]
VALUES = [0.5, 1.5, 5.0, 9.0]


def program(folder: Path = Path(), **keys: Any) -> Program:
    if not keys.keys() & {"file", "times"}:
        keys["times"] = TIMES
    keys.setdefault("signals", {"f": {"unit": "kN", "values": VALUES}})
    return KIND.build(Config(**keys), name="wind", folder=folder)


def outputs(table: Program, time: float) -> dict[str, float]:
    found = load_python(table).outputs(time, [], [], [], [])
    return dict(zip([v.name for v in table.outputs], found, strict=True))


def series(table: Program, name: str, times: list[float]) -> list[float]:
    return [outputs(table, t)[name] for t in times]


# a row holds from half a nanosecond before its time on
@pytest.mark.parametrize(
    ("between", "times", "expected", "announced"),
    [
        (
            "linear",
            [0.0, 0.5, 1.0 - 1e-9, 1.0, 2.0, 3.0],
            [0.5, 1.0, 1.5 - 1e-9, 5.0, 7.0, 9.0],
            [1.0, 1.0, 1.0, 1.0],
        ),
        ("held", [0.0, 0.99, 1.0, 2.99, 3.0], [0.5, 0.5, 5.0, 5.0, 9.0], [1.0, 1.0, 3.0, 3.0]),
    ],
)
def test_between_rows_and_at_a_jump(
    between: str, times: list[float], expected: list[float], announced: list[float]
) -> None:
    table = program(between=between)
    assert [(v.name, v.unit, v.local) for v in table.outputs] == [
        ("f", "kN", False),
        ("next_event_time", "s", True),
    ]
    assert series(table, "f", times) == pytest.approx(expected, rel=1e-15)
    assert series(table, "next_event_time", [0.0, 1.0 - 1e-9, 1.0, 2.0]) == announced


def test_beyond_the_rows() -> None:
    assert series(program(beyond="held"), "f", [-1.0, 4.0]) == [0.5, 9.0]
    refused = program()
    assert outputs(refused, 3.0 + 1e-10)["f"] == pytest.approx(9.0)
    for t in (-1e-9, 3.0 + 1e-9):
        with pytest.raises(ArithmeticError):
            outputs(refused, t)


def test_one_signal_jumps_for_all_and_none_without_a_jump() -> None:
    signals = {"calm": {"values": [1, 1, 1, 1]}, "sea.gust": {"values": VALUES}}
    names = [v.name for v in program(signals=signals).outputs]
    assert names == ["calm", "sea.gust", "next_event_time"]
    assert [v.name for v in program(signals={"f": {"values": [1, 2, 2, 3]}}).outputs] == ["f"]


def test_columns_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "wind.csv").write_text("speed,t,dir\n3,0,10\n\n4,2,20\n")
    signals = {"speed": "m/s", "direction": {"unit": "deg", "column": "dir"}}
    table = program(tmp_path, file="wind.csv", time="t", signals=signals)
    assert outputs(table, 1.0) == {"speed": 3.5, "direction": 15.0}
    assert table.outputs[1].unit == "deg"


@pytest.mark.parametrize("native", [True, False])
def test_a_run_beyond_the_rows_ends_with_what_is_known(native: bool, tmp_path: Path) -> None:
    config = Config(times=TIMES, signals={"f": {"values": VALUES}})
    system = System("s", (Component("t", Kind("table", config)),), (), Simulation(5.0, 0.1))
    prepared = prepare(system, build_directory=tmp_path, native=native)
    with pytest.raises(RunError, match=r"3\.1 s.*known from 0 s to 3 s"):
        run(prepared, results=tmp_path / "r.nc")
