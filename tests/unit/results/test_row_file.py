"""Rows on their way to the disk: every write of them may be the last, at any byte."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from netCDF4 import Dataset

from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import FORMAT, FORMAT_NUMBER, Results, load_results, write_netcdf
from m4e_fmi.results.row_file import NOT_ENDED, ResultColumn, RowFile, RowSection
from m4e_fmi.results.series import Recorded

NUMBER = Recorded("Integer", "i4")
SECTIONS = (
    RowSection(
        "buoy", (ResultColumn("z", "m", "heave"), ResultColumn("f[1,2]", "N", "force, über alles"))
    ),
    RowSection("valve", (ResultColumn("count", "1", "", NUMBER),), "i8", {"step_size": "0.1 s"}),
    RowSection("idle", ()),
    RowSection(
        "clock", (ResultColumn("ticks", "1", "a long one", Recorded("Integer", "i8")),), "i8"
    ),
)
ATTRIBUTES = {"title": "rows", "comment": ""}
ROWS = 100


def parts(first: int, last: int, shift: float = 0.0) -> list[np.ndarray]:
    """Rows of all sections: each number tells its row and its column."""
    time = np.arange(first, last, dtype=float)[:, np.newaxis]
    whole = np.arange(first, last)[:, np.newaxis]
    return [time, np.hstack((time + shift, -time)) / 3, whole - 50, time[:, :0], whole << 40]


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
    results = load_results(file.path)
    assert results.attributes == {**ATTRIBUTES, "ended": "at the stop time"}
    assert results["clock.ticks"].values.dtype == np.int64
    write_netcdf(tmp_path / "w.nc", SECTIONS, ATTRIBUTES, ROWS, file.blocks())
    whole = load_results(tmp_path / "w.nc")
    assert list(results.series) == list(whole.series) == [
        "buoy.z", "buoy.f[1,2]", "valve.count", "clock.ticks"
    ]  # fmt: skip
    for name, series in results.series.items():
        assert series.values.dtype == whole[name].values.dtype
        assert series.values.tobytes() == whole[name].values.tobytes()
        assert (series.unit, series.long_name) == (whole[name].unit, whole[name].long_name)


@pytest.fixture
def writes(monkeypatch: pytest.MonkeyPatch) -> list[tuple[RowFile, int, bytes]]:
    """All writes of row files: the file, the place, and the bytes."""
    made: list[tuple[RowFile, int, bytes]] = []
    usual = RowFile._put

    def put(file: RowFile, place: int, data: Any) -> None:
        made.append((file, place, bytes(data)))
        usual(file, place, data)

    monkeypatch.setattr(RowFile, "_put", put)
    return made


def broken(path: Path, writes: list[tuple[RowFile, int, bytes]], last: int, length: int) -> Results:
    """The results of a file whose write `last` broke off after some bytes."""
    _, place, data = writes[last]
    content = bytearray()
    for at, piece in [*((at, piece) for _, at, piece in writes[:last]), (place, data[:length])]:
        content.extend(bytes(max(0, at - len(content))))
        content[at : at + len(piece)] = piece
    path.write_bytes(content)
    return load_results(path)


def test_a_write_that_breaks_off_anywhere_leaves_complete_rows(
    tmp_path: Path, writes: list[tuple[RowFile, int, bytes]]
) -> None:
    """The writes of a file are made again, up to a byte of one of them, and the file is read."""
    file = RowFile(tmp_path / "r.nc", SECTIONS, ATTRIBUTES)
    lowered = 0
    for first, last, shift in ((0, 2, 0), (2, 40, 0), (40, 70, 0), (50, 60, 9), (60, ROWS, 9)):
        lowered = lowered if shift else len(writes) + 2  # the write of the count that gives rows up
        file.append(first, parts(first, last, shift))
    file.end("failed: " + "a long story " * 200)
    generator = random.Random(1)
    whole = parts(0, 70)
    shifted = [*map(np.concatenate, zip(parts(0, 50), parts(50, ROWS, 9), strict=True))]
    seen = set()
    for last in range(1, len(writes)):
        size, expected = len(writes[last][2]), shifted if last > lowered else whole
        for length in {0, 1, size // 2, size - 1, generator.randrange(size)}:
            results = broken(tmp_path / "broken.nc", writes, last, length)
            count = len(results.time)
            assert results.time.tolist() == expected[0][:count, 0].tolist()
            assert results["buoy.z"].values.tolist() == expected[1][:count, 0].tolist()
            assert results["clock.ticks"].values.tolist() == expected[4][:count, 0].tolist()
            seen.add(count)
    assert seen == {0, 2, 40, 50, 60, 70, ROWS}


def test_texts_are_whole_however_many_there_are(
    tmp_path: Path, writes: list[tuple[RowFile, int, bytes]]
) -> None:
    """Their room grows, and a write that breaks off spoils none that a row has."""
    path, words = tmp_path / "r.nc", ["", "a\nb", "ü" * 30, *map(str, range(90))]
    texts = RowSection("pump", (ResultColumn("word", "1", "", Recorded("String", "str")),), "i8")
    file = RowFile(path, [texts], {"title": ""}, room=512)
    for count in range(2, len(words) + 1):
        file.keep_texts(words[:count])
        file.append(file.count, [np.array([[count]]), np.array([[count - 1]])])
        assert load_results(path)["pump.word"].values.tolist() == words[1:count]
    file.end("done")
    assert load_results(path).attributes == {"title": "", "ended": "done"}
    assert len(path.read_bytes()) > 1024
    assert [p.name for p in tmp_path.iterdir()] == ["r.nc"]
    grown = next(k for k, (one, *_) in enumerate(writes) if one is not writes[0][0])
    assert grown > 20
    for last in range(1, grown):
        size = len(writes[last][2])
        for length in range(0, size, 3) if size > 8 else (0,):
            found = broken(tmp_path / "broken.nc", writes, last, length)["pump.word"].values
            assert found.tolist() == words[1 : len(found) + 1]


@pytest.mark.parametrize(
    ("group", "shape", "said"),
    [
        ("", ("time",), r"it has the variable 'T', of shape \(2,\), at its root"),
        ("body", ("time", "wide"), r"it has the variable 'T', of shape \(2, 3\), in 'body'"),
        ("body", ("wide",), r"it has the variable '.', of shape \(3,\), in 'body'"),
        ("body/arm", None, "it has groups in 'body'"),
    ],
)
def test_netcdf_of_others_is_refused(
    group: str, shape: tuple[str, ...] | None, said: str, tmp_path: Path
) -> None:
    with Dataset(tmp_path / "r.nc", "w") as file:
        file.createDimension("time", 2)
        file.createDimension("wide", 3)
        file.createVariable("time", "f8", ("time",))[:] = [0.0, 1.0]
        file.createGroup("body")
        inner = file.createGroup(group) if group else file
        if shape:
            inner.createVariable("T", "f8", shape)
    with pytest.raises(InputError, match=rf"r\.nc: is netCDF, but not results: {said}\n +give"):
        load_results(tmp_path / "r.nc")


@pytest.mark.parametrize("form", ["rows", "netCDF"])
def test_a_newer_format_is_refused(form: str, tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    if form == "rows":
        RowFile(path, SECTIONS, {**ATTRIBUTES, FORMAT: FORMAT_NUMBER + 1}).close()
    else:
        packed(path, 2, FORMAT_NUMBER + 1)
    with pytest.raises(InputError, match=r"r\.nc: is of format 2.* up to 1\n +update m4e_fmi"):
        load_results(path)


def packed(path: Path, count: int, number: int = FORMAT_NUMBER) -> None:
    """A small file of two variables of so many values."""
    with Dataset(path, "w") as file:
        file.setncatts({FORMAT: number})
        file.createDimension("time", count)
        file.createVariable("time", "f8", ("time",), compression="zlib")
        file.createGroup("a").createVariable("x", "f8", ("time",), compression="zlib")


def test_more_values_than_are_read_at_once(tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    packed(path, 10**11)
    message = r"r\.nc: has 100000000000 rows of 2 values; 2,000,000,000 values are read at most\n"
    with pytest.raises(InputError, match=message):
        load_results(path)
