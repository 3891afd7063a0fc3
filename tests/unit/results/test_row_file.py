"""Rows on their way to the disk: every write of them may be the last, at any byte."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from netCDF4 import Dataset

from m4e_fmi.errors import InputError
from m4e_fmi.results.recorded import Recorded
from m4e_fmi.results.results_file import FORMAT, FORMAT_NUMBER, load, write_netcdf
from m4e_fmi.results.row_file import RowFile
from m4e_fmi.results.row_header import NOT_ENDED, Column, Section

NUMBER = Recorded("Integer", "i4")
SECTIONS = (
    Section("buoy", (Column("z", "m", "heave"), Column("f[1,2]", "N", "force, über alles"))),
    Section("valve", (Column("count", "1", "", NUMBER),), "i8", {"step_size": "0.1 s"}),
    Section("idle", ()),
    Section("clock", (Column("ticks", "1", "a long one", Recorded("Integer", "i8")),), "i8"),
)
ATTRIBUTES = {"title": "rows", "comment": ""}
ROWS = 100


def parts(first: int, last: int, shift: float = 0.0) -> list[np.ndarray]:
    """Rows of all sections: each number tells its row and its column."""
    time = np.arange(first, last, dtype=float)[:, np.newaxis]
    whole = np.arange(first, last)[:, np.newaxis]
    return [time, np.hstack((time + shift, -time)) / 3, whole - 50, time[:, :0], whole << 40]


def names() -> list[str]:
    return ["buoy.z", "buoy.f[1,2]", "valve.count", "clock.ticks"]


def test_any_reader_of_netcdf_sees_the_rows(tmp_path: Path) -> None:
    file = RowFile(tmp_path / "r.nc", SECTIONS, ATTRIBUTES)
    file.append(0, parts(0, 60))
    file.append(60, parts(60, ROWS))
    with Dataset(file.path) as read:
        assert read.title == "rows"
        assert read.ended.rstrip() == NOT_ENDED
        time, expected = read["time"][:], parts(0, ROWS)
        assert time.tolist() == expected[0][:, 0].tolist()
        assert read["buoy.f[1,2]"][:].tolist() == expected[1][:, 1].tolist()
        assert read["buoy.f[1,2]"].long_name == "force, über alles"
        assert read["valve.count"][:].tolist() == expected[2][:, 0].tolist()
        assert read["valve.count"].step_size == "0.1 s"
        assert read["clock.ticks"][:].tolist() == expected[4][:, 0].tolist()
    file.end("at the stop time")
    file.close()
    results = load(file.path)
    assert results.attributes == {**ATTRIBUTES, "ended": "at the stop time"}
    assert list(results.series) == names()
    assert results["clock.ticks"].values.dtype == np.int64


def test_both_forms_of_a_file_are_read_alike(tmp_path: Path) -> None:
    file = RowFile(tmp_path / "r.nc", SECTIONS, ATTRIBUTES)
    file.append(0, parts(0, ROWS))
    write_netcdf(tmp_path / "w.nc", SECTIONS, ATTRIBUTES, ROWS, file.blocks())
    rows, whole = load(file.path), load(tmp_path / "w.nc")
    assert whole.attributes[FORMAT] == str(FORMAT_NUMBER)
    assert list(rows.series) == list(whole.series) == names()
    for name, series in rows.series.items():
        assert series.values.dtype == whole[name].values.dtype
        assert series.values.tobytes() == whole[name].values.tobytes()
        assert (series.unit, series.long_name) == (whole[name].unit, whole[name].long_name)


def test_a_write_that_breaks_off_anywhere_leaves_complete_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The writes of a file are made again, up to a byte of one of them, and the file is read."""
    made: list[tuple[int, bytes]] = []
    usual = RowFile._put

    def put(file: RowFile, place: int, data: Any) -> None:
        made.append((place, bytes(data)))
        usual(file, place, data)

    monkeypatch.setattr(RowFile, "_put", put)
    file = RowFile(tmp_path / "r.nc", SECTIONS, ATTRIBUTES)
    lowered = 0
    for first, last, shift in ((0, 2, 0), (2, 40, 0), (40, 70, 0), (50, 60, 9), (60, ROWS, 9)):
        lowered = lowered if shift else len(made) + 2  # the write of the count that gives rows up
        file.append(first, parts(first, last, shift))
    file.end("failed: " + "a long story " * 200)
    generator = random.Random(1)
    seen = set()
    for broken in range(1, len(made)):
        place, data = made[broken]
        for length in {0, 1, len(data) // 2, len(data) - 1, generator.randrange(len(data))}:
            path = tmp_path / "broken.nc"
            content = bytearray()
            for at, piece in [*made[:broken], (place, data[:length])]:
                content.extend(bytes(max(0, at - len(content))))
                content[at : at + len(piece)] = piece
            path.write_bytes(content)
            results = load(path)
            count = len(results.time)
            given_up = broken > lowered
            whole = parts(0, 50) if given_up else parts(0, 70)
            shifted = [*map(np.concatenate, zip(whole, parts(50, ROWS, 9), strict=True))]
            expected = shifted if given_up else whole
            assert results.time.tolist() == expected[0][:count, 0].tolist()
            assert results["buoy.z"].values.tolist() == expected[1][:count, 0].tolist()
            assert results["clock.ticks"].values.tolist() == expected[4][:count, 0].tolist()
            seen.add(count)
    assert seen == {0, 2, 40, 50, 60, 70, ROWS}


def old_file(path: Path, times: Sequence[float] = (0.0, 1.0), **attributes: Any) -> None:
    """As m4e_fmi wrote them before they had a number."""
    with Dataset(path, "w") as file:
        file.setncatts({"title": "old", **attributes})
        file.createDimension("time", None)
        file.createVariable("time", "f8", ("time",))[:] = times
        variable = file.createGroup("body").createVariable("x", "f8", ("time",))
        variable.setncatts({"units": "m", "long_name": ""})
        variable[:] = [2.0, 3.0]


def test_older_files_are_read(tmp_path: Path) -> None:
    old_file(tmp_path / "r.nc")
    assert load(tmp_path / "r.nc")["body.x"].values.tolist() == [2.0, 3.0]


def variable_at_the_root(file: Dataset) -> None:
    file.createVariable("T", "f8", ("time",))[:] = [1.0, 2.0]


def wider_variable(file: Dataset) -> None:
    file.createDimension("point", 3)
    file["body"].createVariable("T", "f8", ("time", "point"))


def other_times(file: Dataset) -> None:
    file["body"].createDimension("time", 3)
    file["body"].createVariable("T", "f8", ("time",))


def group_in_a_group(file: Dataset) -> None:
    file["body"].createGroup("arm")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (variable_at_the_root, r"it has the variable 'T', of shape \(2,\), at its root"),
        (wider_variable, r"it has the variable 'T', of shape \(2, 3\), in 'body'"),
        (other_times, r"it has the variable '.', of shape \(3,\), in 'body'"),
        (group_in_a_group, "it has groups in 'body'"),
    ],
)
def test_netcdf_of_others_is_refused(
    change: Callable[[Dataset], None], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "r.nc"
    old_file(path)
    with Dataset(path, "a") as file:
        change(file)
    with pytest.raises(InputError, match=rf"r\.nc: is netCDF, but not results: {message}\n +give"):
        load(path)


@pytest.mark.parametrize("times", [(1.0, 1.0), (1.0, 0.0), (0.0, np.nan), (0.0, np.inf)])
@pytest.mark.parametrize("form", ["netcdf", "rows"])
def test_times_that_do_not_increase_are_refused(
    form: str, times: tuple[float, float], tmp_path: Path
) -> None:
    path = tmp_path / "r.nc"
    if form == "netcdf":
        old_file(path, times)
    else:
        file = RowFile(path, (), {})
        file.append(0, [np.array(times)[:, np.newaxis]])
        file.close()
    with pytest.raises(InputError, match=r"damaged: its times do not increase, or are not finite"):
        load(path)


def packed(path: Path, count: int) -> None:
    """A small file of two variables of so many values."""
    with Dataset(path, "w") as file:
        file.setncatts({FORMAT: FORMAT_NUMBER})
        file.createDimension("time", count)
        file.createVariable("time", "f8", ("time",), compression="zlib")
        file.createGroup("a").createVariable("x", "f8", ("time",), compression="zlib")


def test_more_values_than_are_read_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "r.nc"
    packed(path, 10**11)
    message = r"r\.nc: has 100000000000 rows of 2 values; 2,000,000,000 values are read at most\n"
    with pytest.raises(InputError, match=message):
        load(path)
    rows_of(path)
    monkeypatch.setattr("m4e_fmi.results.row_file.MOST_RESULTS", 10)
    with pytest.raises(InputError, match=r"rows of \d values; 10 values are read at most\n"):
        load(path)


SMALL_MEMORY = """
import resource, sys
from m4e_fmi import load
resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))
try:
    load(sys.argv[1])
except Exception as error:
    print(type(error).__name__, error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory")
def test_more_values_than_there_is_memory(tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    packed(path, 999_000_000)
    command = [sys.executable, "-c", SMALL_MEMORY, str(path)]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert told.startswith(f"InputError {path}: takes more memory than there is\n      read parts")


def rows_of(path: Path, **attributes: int) -> None:
    file = RowFile(path, SECTIONS, {**ATTRIBUTES, **attributes})
    file.append(0, parts(0, ROWS))
    file.close()


@pytest.mark.parametrize("write", [old_file, rows_of])
def test_a_newer_format_is_refused(write, tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    write(path, **{FORMAT: FORMAT_NUMBER + 1})
    with pytest.raises(InputError, match=r"r\.nc: is of format 2.* up to 1\n +update m4e_fmi"):
        load(path)


def cut(path: Path, part: float) -> None:
    path.write_bytes(path.read_bytes()[: int(part * path.stat().st_size)])


def test_files_that_are_no_results(tmp_path: Path) -> None:
    whole, rows, text, empty, other, foreign = (tmp_path / f"{name}.nc" for name in "wrteof")
    old_file(whole)
    cut(whole, 0.7)
    rows_of(rows)
    cut(rows, 0.9)
    text.write_text("time,x\n")
    empty.touch()
    table, alone, fmu, noise = (tmp_path / name for name in ("r.csv", "a.csv", "x.fmu", "x.bin"))
    table.write_text("time [s],x\n" + "0,1\n" * 5000)
    alone.write_text("time\n", encoding="utf-8-sig")
    fmu.write_bytes(b"PK\x03\x04 and more")
    noise.write_bytes(b"\xff\x00\x01")
    with Dataset(other, "w") as file:
        file.createDimension("time", 3)
    with Dataset(foreign, "w") as file:
        file.createDimension("time", 3)
        file.createVariable("time", "f8", ("time",))[:] = [0.0, 1.0, 2.0]
    for path, message in (
        (whole, r"w\.nc: is cut off or damaged: .*\n +copy it again"),
        (rows, r"r\.nc: is cut off: it has \d+ bytes of \d+\n +copy it again"),
        (
            text,
            r"t\.nc: is not a file of results \(netCDF\), but a table \(CSV\) with the first line "
            r"'time,x'\n +give what `m4e-fmi run`",
        ),
        (table, r"r\.csv: .* a table \(CSV\) .* 'time \[s\],x'\n +load r\.nc, which is beside it"),
        (alone, r"a\.csv: .* text with .*\n +load the \.nc file that was written with it; pandas"),
        (fmu, r"x\.fmu: .* but a ZIP archive, as an FMU"),
        (noise, r"x\.bin: .* but data of a kind that is not known here"),
        (empty, r"e\.nc: is empty"),
        (other, r"o\.nc: is netCDF, but not results: it has no variable `time`"),
        (foreign, r"f\.nc: is netCDF, .*: it has no attribute `m4e_fmi_format`, and no groups"),
        (tmp_path / "none.nc", r"none\.nc: no such file"),
        (tmp_path, "is a folder, not a file of results"),
    ):
        with pytest.raises(InputError, match=message) as caught:
            load(path)
        assert len(caught.value.problems) == 1
    rows_of(rows)
    cut(rows, 0.05)  # in the header
    with pytest.raises(InputError, match="is cut off"):
        load(rows)


TEXTS = Section("pump", (Column("word", "1", "", Recorded("String", "str")),), "i8")


def test_texts_are_whole_however_many_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their room grows, and a write that breaks off spoils none that a row has."""
    path, words = tmp_path / "r.nc", ["", "a\nb", "ü" * 30, *map(str, range(90))]
    made: list[tuple[RowFile, int, bytes]] = []
    usual = RowFile._put

    def put(file: RowFile, place: int, data: Any) -> None:
        made.append((file, place, bytes(data)))
        usual(file, place, data)

    monkeypatch.setattr(RowFile, "_put", put)
    file = RowFile(path, [TEXTS], {"title": ""}, room=512)
    for count in range(2, len(words) + 1):
        file.keep_texts(words[:count])
        file.append(file.count, [np.array([[count]]), np.array([[count - 1]])])
        assert load(path)["pump.word"].values.tolist() == words[1:count]
    file.end("done")
    assert load(path).attributes == {"title": "", "ended": "done"}
    assert len(Path(path).read_bytes()) > 1024
    assert [p.name for p in tmp_path.iterdir()] == ["r.nc"]
    grown = [one for one, *_ in made].index(next(one for one, *_ in made if one is not file))
    assert grown > 20
    for broken in range(1, grown):
        _, place, data = made[broken]
        for length in range(0, len(data), 3) if len(data) > 8 else (0,):
            content = bytearray()
            for at, piece in [(at, p) for _, at, p in made[:broken]] + [(place, data[:length])]:
                content.extend(bytes(max(0, at - len(content))))
                content[at : at + len(piece)] = piece
            (tmp_path / "broken.nc").write_bytes(content)
            found = load(tmp_path / "broken.nc")["pump.word"].values.tolist()
            assert found == words[1 : len(found) + 1]
