"""Tables of other tools: separators, decimal commas, units, gaps, encodings, dates and times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.files.csv_columns import heading
from m4e_fmi.results.compared_file import ComparedFile, read_compared

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


def read(folder: Path, text: str, encoding: str = "utf-8") -> ComparedFile:
    path = folder / "other.csv"
    path.write_bytes(text.encode(encoding))
    return read_compared(path)


@pytest.mark.parametrize("form", FORMS)
def test_all_forms_give_the_same(form: str, tmp_path: Path) -> None:
    found = read(tmp_path, FORMS[form])
    assert found.time.tolist() == [0.0, 0.1, 0.2]
    assert {n: (q.unit, q.values.tolist()) for n, q in found.quantities.items()} == {
        "heave": ("m", [1.5, -2e-3, 0.25]),
        "pitch": ("deg", [2.0, 3.0, 4.0]),
    }


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
    found = read(tmp_path, "time [ms],x\n0,1\n100,\n100,NaN\n200,3\n200,4\n")
    assert found.time == pytest.approx([0.0, 0.1, 0.2])
    assert found.quantities["x"].values == pytest.approx([1.0, np.nan, 4.0], nan_ok=True)
    assert found.notes == ("time converted from ms to s", "2 rows at the time of the next left out")


@pytest.mark.parametrize(
    ("encoding", "said"),
    [("latin-1", "Windows-1252"), ("cp1252", "Windows-1252"), ("utf-16", "UTF-16")],
)
def test_encodings_of_other_tools(tmp_path: Path, encoding: str, said: str) -> None:
    text = PLAIN.replace("heave", "Höhe").replace("deg", "°").replace(",", ";")
    found = read(tmp_path, text, encoding)
    assert {n: q.unit for n, q in found.quantities.items()} == {"Höhe": "m", "pitch": "°"}
    assert found.quantities["Höhe"].values.tolist() == [1.5, -2e-3, 0.25]
    assert found.notes[0] == f"taken as {said}"
