"""Tables of other tools: separators, decimal commas, comments, units, gaps; refusals by line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.files.csv_columns import heading
from m4e_fmi.results.compared_file import read_compared
from m4e_fmi.results.foreign_table import read_foreign_table

PLAIN = "time,heave [m],pitch [deg]\n0,1.5,2\n0.1,-2e-3,3\n0.2,0.25,4\n"
FORMS = {
    "commas": PLAIN,
    "blanks after commas": PLAIN.replace(",", ", "),
    "a separator at the end of rows": PLAIN.replace("\n", ",\n"),
    "semicolons": PLAIN.replace(",", ";"),
    "decimal commas": PLAIN.replace(",", ";").replace(".", ","),
    "tabs": PLAIN.replace(",", "\t"),
    "tabs and decimal commas": PLAIN.replace(",", "\t").replace(".", ","),
    "blanks": "  time   heave(m)  pitch(deg)\n 0.0  1.5 2\n  0.1 -2e-3   3\n  0.2 0.25 4\n",
    "blanks and decimal commas": "time heave pitch\n(s) (m) (deg)\n0 1,5 2\n"
    "0,1 -2E-3 3\n0,2 0,25 4\n",
    "a row of units": "Time\theave\tpitch\n(s)\t(m)\t(deg)\n"
    "0\t1.5\t2\n0.1\t-2e-3\t3\n0.2\t.25\t4\n",
    "comments": "# made by a tool, 1.2\n% on 3 May\ntime,heave [m],pitch [deg]\n"
    + PLAIN.split("\n", 1)[1],
    "names in a comment": "# " + PLAIN,
    "lines above": "Run 7, of 9\n\nTool 1.0; licensed\n" + PLAIN,
    "quotation marks": PLAIN.replace("heave [m]", '"heave [m]"'),
    "a mark of bytes": "\ufeff" + PLAIN,
    "Windows": PLAIN.replace("\n", "\r\n"),
}


def table(folder: Path, text: str) -> Path:
    path = folder / "other.csv"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("form", FORMS)
def test_all_forms_give_the_same(form: str, tmp_path: Path) -> None:
    found = read_compared(table(tmp_path, FORMS[form]))
    assert found.time.tolist() == [0.0, 0.1, 0.2]
    assert {n: (q.unit, q.values.tolist()) for n, q in found.quantities.items()} == {
        "heave": ("m", [1.5, -2e-3, 0.25]),
        "pitch": ("deg", [2.0, 3.0, 4.0]),
    }


def test_notes_say_how_a_table_was_read(tmp_path: Path) -> None:
    assert read_foreign_table(table(tmp_path, PLAIN)).notes == ()
    found = read_foreign_table(table(tmp_path, "a tool\n" + FORMS["decimal commas"])).notes
    assert found == (
        "columns separated by semicolons, decimal commas",
        "1 line above the names left out",
    )


def test_integers_at_the_end_do_not_hide_decimal_commas(tmp_path: Path) -> None:
    text = "t;x\n0,5;1,25\n1;2\n2;3\n3;4\n"
    assert read_compared(table(tmp_path, text)).quantities["x"].values[0] == 1.25


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("heave [m]", "heave", "m"),
        ("Heave (m/s2)", "Heave", "m/s2"),
        ("Fx (global)", "Fx (global)", None),
        ("power [-]", "power", "1"),
        ("count []", "count", "1"),
        ("[m]", "[m]", None),
        ("x [furlong]", "x", "furlong"),
        ("plain", "plain", None),
        ("Tension (kN) at end A", "Tension (kN) at end A", "kN"),
        ("Force [kN] in line (upper)", "Force [kN] in line (upper)", "kN"),
        ("x(t) of node (2) at A", "x(t) of node (2) at A", None),
        ("Force (N) or (kN) here", "Force (N) or (kN) here", None),
    ],
)
def test_headings(text: str, name: str, unit: str | None) -> None:
    assert heading(text) == (name, unit)


def test_gaps_and_rows_at_one_time(tmp_path: Path) -> None:
    found = read_compared(table(tmp_path, "time [ms],x\n0,1\n100,\n100,NaN\n200,3\n200,4\n"))
    assert found.time == pytest.approx([0.0, 0.1, 0.2])
    assert found.quantities["x"].values == pytest.approx([1.0, np.nan, 4.0], nan_ok=True)
    assert found.notes == ("time converted from ms to s", "2 rows at the time of the next left out")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,x\n0,1\n1,two\n2,3\n", "3:1: expected a number, got 'two'"),
        ("time,x\n0,1\n1,2\n2\n3,4\n", "4:1: 1 entries, the names above are 2"),
        ("time,x\n0,1\n1,2\n0.5,3\n", "4:1: time 0.5 s follows 1 s"),
        ("time,x\n0,1\n,2\n3,3\n", "3:1: the time is missing or not finite"),
        ("0,1\n1,2\n", "no names of 2 columns"),
        ("time,x\n0,5,1,5\n1,5,2,5\n", "decimal commas need columns separated by ; or tabs"),
        ("time;x\n0,0;1.234,5\n1,0;1.234,5\n", "leave out marks between thousands"),
        ("when,x\n0,1\n1,2\n", "has no column for the time"),
        ("time [m],x\n0,1\n1,2\n", "'time' is in m, expected a time"),
        ("time,x,x\n0,1,1\n1,2,2\n", "two columns are called 'x'"),
        ("only words\nand more\n", "the last row is not one of numbers"),
        ("Zeit;x\n02.01.26 10:00;1,5\n02.01.26 10:01;2,5\n", "or seconds since the first"),
        ("# nothing\n", "has no rows"),
        ("", "has no rows"),
        ("time,x\n0.5,1_000\n1,2\n", "2:1: names of columns or numbers expected, got both"),
    ],
)
def test_unclear_tables_are_refused(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_compared(table(tmp_path, text))
    assert message in str(caught.value)


def test_parquet_of_another_tool(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")

    columns = {"Time [s]": [0.0, 1.0], "x [mm]": [1, None], "who": ["a", "b"]}
    path = tmp_path / "other.parquet"
    parquet.write_table(pyarrow.table(columns), path)
    found = read_compared(path)
    assert found.quantities["x"].unit == "mm"
    assert found.quantities["x"].values == pytest.approx([1.0, np.nan], nan_ok=True)
    assert found.notes == ("no numbers, not compared: who",)
    path.write_bytes(b"PAR1 and nothing")
    with pytest.raises(InputError, match="cannot be read as Parquet"):
        read_compared(path)


@pytest.mark.parametrize(
    ("encoding", "told"),
    [("latin-1", "Windows-1252"), ("cp1252", "Windows-1252"), ("utf-16", "UTF-16")],
)
def test_encodings_of_other_tools(tmp_path: Path, encoding: str, told: str) -> None:
    text = PLAIN.replace("heave", "Höhe").replace("deg", "°").replace(",", ";")
    path = tmp_path / "other.csv"
    path.write_bytes(text.encode(encoding))
    found = read_foreign_table(path)
    assert [(c.name, c.unit) for c in found.columns[1:]] == [("Höhe", "m"), ("pitch", "°")]
    assert found.columns[1].values.tolist() == [1.5, -2e-3, 0.25]
    assert found.notes[0] == f"taken as {told}"


@pytest.mark.parametrize("content", [b"time,\x81\n0,1\n1,2\n", b"\xff\xfet", b"a\xff\x00,b\n1,2"])
def test_a_table_in_no_such_encoding_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "other.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"not valid|control characters"):
        read_foreign_table(path)
