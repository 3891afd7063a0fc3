"""The kind `table`: values between rows and at jumps, what is announced, and every mistake."""

from __future__ import annotations

import re
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import Component, Kind, Simulation, System, prepare, run
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmi.report.text.summaries import run_summary
from m4e_fmus.table import Config, make

TIMES = [0.0, 1.0, 1.0, 3.0]
VALUES = [0.5, 1.5, 5.0, 9.0]


def program(folder: Path = Path(), **keys: Any) -> Program:
    if not keys.keys() & {"file", "times"}:
        keys["times"] = TIMES
    keys.setdefault("signals", {"f": {"unit": "kN", "values": VALUES}})
    return make(Config(**keys), name="wind", folder=folder)


def outputs(table: Program, time: float) -> dict[str, float]:
    found = load_python(table).outputs(time, [], [], [], [])
    return dict(zip([v.name for v in table.outputs], found, strict=True))


def test_straight_between_rows_and_after_the_jump_at_its_time() -> None:
    table = program()
    (f, announced) = table.outputs
    assert (f.unit, announced.unit) == ("kN", "s")
    assert announced.local
    times = [0.0, 0.5, 1.0 - 1e-9, 1.0, 2.0, 3.0]
    # a row holds from half a nanosecond before its time on
    expected = [0.5, 1.0, 1.5 - 1e-9, 5.0, 7.0, 9.0]
    assert [outputs(table, t)["f"] for t in times] == pytest.approx(expected, rel=1e-15)


def test_rows_are_met_to_the_bit() -> None:
    rng = np.random.default_rng(1)
    times, values = np.cumsum(rng.random(50)).round(9), rng.normal(size=50) * 1e3
    table = program(times=times.tolist(), signals={"f": {"values": values.tolist()}})
    assert [outputs(table, t)["f"] for t in times.tolist()] == values.tolist()
    between = (times[:-1] + times[1:]) / 2
    found = [outputs(table, t)["f"] for t in between.tolist()]
    assert found == pytest.approx(np.interp(between, times, values), rel=1e-12)


def test_held_between_rows() -> None:
    table = program(between="held")
    times = [0.0, 0.99, 1.0, 2.99, 3.0]
    assert [outputs(table, t)["f"] for t in times] == [0.5, 0.5, 5.0, 5.0, 9.0]


def test_beyond_the_rows() -> None:
    held = program(beyond="held")
    assert [outputs(held, t)["f"] for t in (-1.0, 4.0)] == [0.5, 9.0]
    refused = program()
    assert outputs(refused, 3.0 + 1e-10)["f"] == pytest.approx(9.0)
    for t in (-1e-9, 3.0 + 1e-9):
        with pytest.raises(ArithmeticError):
            outputs(refused, t)


@pytest.mark.parametrize(
    ("between", "announced"),
    [("linear", [1.0, 1.0, 1.0, 1.0]), ("held", [1.0, 1.0, 3.0, 3.0])],
)
def test_the_next_jump_is_announced(between: str, announced: list[float]) -> None:
    table = program(between=between)
    times = [0.0, 1.0 - 1e-9, 1.0, 2.0]
    assert [outputs(table, t)["next_event_time"] for t in times] == announced


def test_without_a_jump_nothing_is_announced() -> None:
    table = program(signals={"f": {"values": [1, 2, 2, 3]}})
    assert [v.name for v in table.outputs] == ["f"]


def test_one_signal_jumps_for_all() -> None:
    signals = {"calm": {"values": [1, 1, 1, 1]}, "sea.gust": {"values": VALUES}}
    table = program(signals=signals)
    assert [v.name for v in table.outputs] == ["calm", "sea.gust", "next_event_time"]


def test_columns_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "wind.csv").write_text("speed,t,dir\n3,0,10\n\n4,2,20\n")
    signals = {"speed": "m/s", "direction": {"unit": "deg", "column": "dir"}}
    table = program(tmp_path, file="wind.csv", time="t", signals=signals)
    assert outputs(table, 1.0) == {"speed": 3.5, "direction": 15.0}
    assert table.outputs[1].unit == "deg"


WRONG_HERE = {
    "times: [0, 1, 1, 3]": {
        "times: [0, 1, 0.5, 0.2]": "row 3: time 0.5 is before 1; row 4: time 0.2 is before 0.5",
        "times: [1, 1, 1, 3]": "row 3: a third row at time 1",
        "times: [0]": "row 1: expected 2 to 10000 rows, got 1",
        "times: []": "row 1: expected 2 to 10000 rows, got 0",
        "times: [0, .nan, 1, 3]": "finite number",
        "times: [0, 1, 3]": "'f' has 4 values for 3 times",
        "file: f.csv\ntimes: [0, 1, 1, 3]": "numbers both in a file and here",
        "file: f.csv": "numbers both in a file and here",
        "between: held": "a table without numbers",
    },
    "unit: kN": {"unit: kNn": "'kNn' is not a unit known here"},
    "f: {": {
        "f-g: {": "pattern",
        "next_event_time: {": "cannot be called next_event_time",
        "time: {": "cannot be called time",
    },
    "beyond: held": {"beyond: hold": "unknown beyond 'hold'", "beyend: held": "unknown key"},
    "0.5, ": {
        "": "'f' has 3 values for 4 times",
        "x, ": "expected a number, got 'x'",
        ".inf, ": "finite number",
    },
}


def read(text: str) -> Config:
    """The configuration of a component `c` of a system file."""
    return Document.parse("c:\n" + indent(text, "  ")).validate(Config, at=("c",))


GOOD = "times: [0, 1, 1, 3]\nsignals: {f: {unit: kN, values: [0.5, 1.5, 5, 9]}}\nbeyond: held\n"
CASES = [(old, new, text) for old, news in WRONG_HERE.items() for new, text in news.items()]


@pytest.mark.parametrize(("old", "new", "message"), CASES)
def test_mistakes_in_the_system_file(old: str, new: str, message: str) -> None:
    assert GOOD.count(old) == 1
    read(GOOD)
    with pytest.raises(InputError) as caught:
        read(GOOD.replace(old, new))
    (problem,) = caught.value.problems
    assert message in problem.message
    assert problem.line > 0


def test_all_mistakes_at_once() -> None:
    wrong = GOOD.replace("0, 1, 1, 3", "0, 2, 1, 3").replace("kN", "kNn").replace("held", "hold")
    with pytest.raises(InputError) as caught:
        read(wrong)
    assert len(caught.value.problems) == 3


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        (None, 0, "no such file"),
        ("", 0, "has no two columns"),
        ("time,f\n", 0, "has no rows below its first"),
        ("time,f\n0,1\n", 2, "expected 2 to 10000 rows, got 1"),
        ("time,g\n0,1\n1,2\n", 1, "no column 'f'"),
        ("time,f,f\n0,1,1\n1,2,2\n", 1, "two columns are called 'f'"),
        ("time,f\n0,1\n\n1,nan\n", 4, "expected a finite number in column 'f', got 'nan'"),
        ("time,f\n0,1\n1\n", 3, "expected a finite number in column 'f', got nothing"),
        ("time,f\n0,1\n1,1\n2,one\n", 4, "expected a finite number in column 'f', got 'one'"),
        ("time,f\n0,1\n2,1\n1,2\n", 4, "time 1 is before 2"),
        ("time,f\n0,1\n2,1\n2,2\n2,3\n", 5, "a third row at time 2"),
        ('time,f\n0,"1\n', 0, "cannot be read"),
        (b"\xff\xfe\x00", 0, "cannot be read"),
    ],
)
def test_mistakes_in_a_file(
    content: str | bytes | None, line: int, message: str, tmp_path: Path
) -> None:
    if content is not None:
        data = content.encode() if isinstance(content, str) else content
        (tmp_path / "wind.csv").write_bytes(data)
    with pytest.raises(InputError) as caught:
        program(tmp_path, file="wind.csv", signals={"f": "N"})
    (problem,) = caught.value.problems
    assert message in problem.message
    assert (problem.file, problem.line) == (str(tmp_path / "wind.csv"), line)


def test_powers_in_other_units_than_watts_have_means(tmp_path: Path) -> None:
    units = {"a": "kW", "b": "MW", "c": "N.m/s", "d": "N.m.rad/s", "e": "W", "f": "J", "g": "1"}
    signals = {name: {"unit": unit, "values": [1.0, 3.0]} for name, unit in units.items()}
    config = Config(times=(0.0, 1.0), signals=signals)  # pyright: ignore
    system = System("s", (Component("t", Kind("table", config)),), (), Simulation(1.0, 0.1))
    outcome = run(system, results=tmp_path / "s.nc", build_directory=tmp_path)
    told = re.findall(r"mean power (\S+ \S+) over 1 s \(t\.(\w)\)", run_summary(outcome))
    expected = {"a": "2.000 kW", "b": "2.000 MW", "c": "2.000 W", "d": "2.000 W", "e": "2.000 W"}
    assert {name: power for power, name in told} == expected


def test_a_name_that_differs_is_told_with_the_file_that_has_it(tmp_path: Path) -> None:
    (tmp_path / "wind.csv").write_text("t,forze,g\n0,1,1\n1,2,2\n")
    signals = {"force": "N", "other": {"column": "h"}}
    with pytest.raises(InputError) as caught:
        program(tmp_path, file="wind.csv", time="time", signals=signals)
    time, force, other = caught.value.problems
    assert force.message == (
        "no column 'force' in this file, which the system file asks for as the signal 'force'"
    )
    assert force.remedy == (
        "mend the name in one of the two, or give 'force' its 'column' in the system file; "
        "did you mean 'forze'?"
    )
    assert "no column 'h' in this file, which the system file asks for as the signal 'other'" in (
        other.message
    )
    assert "which the system file asks for under 'time'" in time.message


def test_all_mistakes_of_all_files_at_once(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,f\n0,x\n1,nan\n2,\n")
    (tmp_path / "b.csv").write_text("time,f\n" + "0,x\n" * 30)
    parts = [
        Component(n, Kind("table", Config(file=f"{n}.csv", signals={"f": "N"})))  # pyright: ignore
        for n in "ab"
    ]
    system = System("s", tuple(parts), (), Simulation(1.0, 0.1), folder=tmp_path)
    with pytest.raises(InputError) as caught:
        prepare(system, build_directory=tmp_path)
    of_a = [p for p in caught.value.problems if p.file.endswith("a.csv")]
    of_b = [p for p in caught.value.problems if p.file.endswith("b.csv")]
    assert [p.line for p in of_a] == [2, 3, 4]
    assert len(of_b) == 11
    assert "20 more problems" in of_b[0].message


@pytest.mark.parametrize("native", [True, False])
def test_a_run_beyond_the_rows_ends_with_what_is_known(native: bool, tmp_path: Path) -> None:
    config = Config(times=TIMES, signals={"f": {"values": VALUES}})  # pyright: ignore
    gain = Config(times=[0, 9], signals={"g": {"values": [0, 1]}})  # pyright: ignore
    parts = (Component("t", Kind("table", config)), Component("u", Kind("table", gain)))
    system = System("s", parts, (), Simulation(5.0, 0.1))
    prepared = prepare(system, build_directory=tmp_path, native=native)
    with pytest.raises(RunError, match=r"3\.1 s.*known from 0 s to 3 s"):
        run(prepared, results=tmp_path / "r.nc")
