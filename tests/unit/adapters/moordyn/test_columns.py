"""Rods, bodies, options and headings of ready MoorDyn files: each mistake is told at its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_adapters.moordyn import ready_mooring
from m4e_adapters.moordyn.ready_files.sections import tables
from m4e_fmi.errors import InputError, Problem

FILE = """\
a free body with a rod, a buoy between two lines
----- LINE TYPES -----
name d m EA BA EI Cd Ca CdAx CaAx
- - - - - - - - - -
rope 0.1 20 2e7 -0.8 0 1.2 1 0.1 0
----- ROD TYPES -----
name d m Cd Ca CdEnd CaEnd
- - - - - - -
can 2.5 900 0.6 1.1 1.3 1.4
----- BODIES -----
id type x y z r p y m cg i v cda ca
- - - - - - - - - - - - - -
1 Free 3 0.5 -4 10 20 30 5e3 0|0|-1 7e4|8e4|9e4 6 11|12 1.5
----- RODS -----
id type to xa ya za xb yb zb n out
- - - - - - - - - - -
1 can Body1 0.1 0.2 -2.2 0.3 0.4 2.1 3 p
2 can Free -20 0 -30 -20 0 -25 4 -
----- POINTS -----
id type x y z m v cda ca
- - - - - - - - -
1 Fixed -60 1 -80 0 0 0 0
2 Coupled 9 1 -12 0 0 0 0
3 Body1 1 2 -1 0 0 0 0
----- LINES -----
id type a b length n out
- - - - - - -
1 rope 1 R2A 75 8 -
2 rope R2B 2 40 6 p
3 rope 1 3 99 7 p
----- OPTIONS -----
80 WtrDpth
1000 rho
5e-4 dtM
-----
"""
BODY = 13  # lines in the file
ROD_TYPE, ROD, FREE_ROD = 9, 17, 18


def problems(folder: Path, text: str) -> list[Problem]:
    path = folder / "lines.txt"
    path.write_text(text)
    try:
        ready_mooring(path, fairleads={})
    except InputError as error:
        return error.problems
    return []


def test_the_file_is_accepted_and_numbers_of_segments_are_written_out(tmp_path):
    path = tmp_path / "lines.txt"
    path.write_text(FILE.replace("2.1 3 p", "2.1 3e0 p"))
    written = tables(ready_mooring(path, fairleads={}).text)
    assert written["rods"][0].words[9:] == ("3", "-")  # MoorDyn reads 30e-1 as 30
    assert written["bodies"][0].words == tables(FILE)["bodies"][0].words


@pytest.mark.parametrize(
    ("line", "before", "after", "message", "remedy"),
    [
        (ROD_TYPE, "can 2.5", "can -2.5", "diameter must not be negative, got -2.5", "sign"),
        (ROD_TYPE, "2.5 900", "2.5 nan", "mass per length: 'nan' is not a number", "as a number"),
        (ROD_TYPE, "900 0.6", "900 1e9", "drag coefficient Cd 1e9 cannot be meant", "and 1000"),
        (ROD_TYPE, "0.6 1.1", "0.6 Ca", "'Ca' is not a number", "added mass coefficient Ca"),
        (ROD_TYPE, "1.1 1.3", "1.1 -1.3", "drag coefficient of the ends CdEnd must not", "sign"),
        (ROD_TYPE, "1.3 1.4", "1.3 inf", "coefficient of the ends CaEnd: 'inf' is not", ""),
        (ROD_TYPE, " 1.4\n", "\n", "7 values are needed here, 6 are given", "version 2"),
        (BODY, "1 Free 3", "1 Fere 3", "there is no type of body 'Fere'", "'Free'"),
        (BODY, "Free 3", "Free 1e9", "coordinate 1e9 cannot be meant", "1e+07"),
        (BODY, "-4 10", "-4 1e5", "angle 1e5 cannot be meant", "360 and 360, in degrees"),
        (BODY, "30 5e3", "30 -5e3", "mass must not be negative, got -5e3", "sign"),
        (BODY, "0|0|-1", "0|-1", "centre of gravity: '0|-1' has 2 values", "give 1 or 3"),
        (BODY, "0|0|-1", "0|x|-1", "centre of gravity: 'x' is not a number", "as a number"),
        (BODY, "7e4|8e4", "7e4|-8e4", "moment of inertia must not be negative, got -8e4", "sign"),
        (BODY, "9e4 6", "9e4 nan", "volume: 'nan' is not a number", "as a number"),
        (BODY, "11|12", "1|2|3|4", "'1|2|3|4' has 4 values", "give 1, 2, 3 or 6"),
        (BODY, "11|12", "11|12|13", "the first of '11|12|13' for 0", "one value, or two"),
        (BODY, "11|12", "11|-12", "drag area CdA must not be negative, got -12", "sign"),
        (BODY, "11|12 1.5", "11|12 -1.5", "coefficient Ca must not be negative", "sign"),
        (BODY, " 1.5\n", "\n", "14 values are needed here, 13 are given", ""),
        (ROD, "Body1 0.1", "Body1 nan", "coordinate: 'nan' is not a number", "as a number"),
        (ROD, "2.1 3 p", "2.1 -3 p", "segments must not be negative, got -3", "between 0 and 1000"),
        (ROD, "2.1 3 p", "2.1 2.5 p", "segments: 2.5 is not a whole number", "whole number"),
        (ROD, "2.1 3 p", "2.1 3", "11 values are needed here, 10 are given", ""),
        (ROD, "1 can", "1 cna", "there is no rod type 'cna'", "'can'"),
        (ROD, "can Body1", "can Body7", "there is no body for 'Body7'", "'Body1'"),
        (FREE_ROD, "can Free", "can Fre", "there is no type of rod 'Fre'", "'Free'"),
        (FREE_ROD, "-20 0 -25", "-20 0 -30", "both ends of rod 2 are at one place", "0 segments"),
        (FREE_ROD, "-20 0 -30", "-20 0 -90", "rod 2 at z = -90 m is below the seabed", "raise it"),
        (0, "can 2.5", "can 1 1 1 1 1 1\ncan 2.5", "rod type 'can' is given twice", "rename"),
    ],
)
def test_a_mistake_in_a_rod_or_a_body_is_one_problem(
    tmp_path, line, before, after, message, remedy
):
    assert FILE.count(before) == 1
    (problem,) = problems(tmp_path, FILE.replace(before, after))
    assert message in problem.message
    assert remedy in problem.remedy
    assert problem.line == line or not line
    assert problem.source == (tmp_path / "lines.txt").read_text().splitlines()[problem.line - 1]


def test_mistakes_of_rods_and_bodies_are_told_at_once_with_those_of_kinds(tmp_path):
    text = FILE.replace("can 2.5", "can -2.5").replace("30 5e3", "30 heavy")
    text = text.replace("can Free", "can Fre").replace("1 Fixed", "1 Fixde")
    assert [p.line for p in problems(tmp_path, text)] == [ROD_TYPE, BODY, FREE_ROD, 22]


@pytest.mark.parametrize(
    ("before", "after", "message", "remedy"),
    [
        ("2e7 -0.8", "5.83D8 -0.8", "EA: '5.83D8' is not a number", "read 5.83: write 5.83E8"),
        ("2e7 -0.8", "2_0e6 -0.8", "EA: '2_0e6' is not a number", "as a number"),
        ("1000 rho", "1.0D3 rho", "rho: '1.0D3' is not a number", "write 1.0E3"),
        ("5e-4 dtM", "DEFAULT dtM", "dtM: 'DEFAULT' is not", "remove the line: without it, a st"),
        ("1000 rho", "default rho", "'default' is not a number", "MoorDyn takes its own default"),
        ("75 8 -", "75 0 -", "segments must be positive, got 0", "whole number between 1 and 1000"),
        ("75 8 -", "75 1e9 -", "segments 1e9 cannot be meant", "whole number between 1 and 1000"),
        ("5e-4 dtM", "5e-4 dtM\n1e-3 DT", "DT 1e-3: line 34 gives dtM 5e-4", "takes the last one"),
        ("1000 rho", "1000 rho\n1025 rho", "rho 1025: line 33 gives rho 1000", "remove one"),
        ("80 WtrDpth\n", "", "depth of the water, WtrDpth, is missing", "'200 WtrDpth'"),
        ("1000 rho", "1000 rho\n1e3 rho", "", ""),  # the same value
    ],
)
def test_numbers_and_options_that_moordyn_reads_otherwise(tmp_path, before, after, message, remedy):
    assert FILE.count(before) == 1
    found = problems(tmp_path, FILE.replace(before, after))
    assert len(found) == bool(message)
    assert all(message in p.message and remedy in p.remedy for p in found)


@pytest.mark.parametrize(
    ("lost", "row"),
    [
        ("id type x y z m v cda ca\n", "1 Fixed"),
        ("name d m EA BA EI Cd Ca CdAx CaAx\n", "rope 0.1"),
        ("id type a b length n out\n- - - - - - -\n", "1 rope"),
        ("id type x y z r p y m cg i v cda ca\n", "1 Free"),
        ("id type to xa ya za xb yb zb n out\n", "1 can"),
    ],
)
def test_a_lost_heading_is_told_once(tmp_path, lost, row):
    assert lost in FILE
    (problem,) = problems(tmp_path, FILE.replace(lost, ""))
    assert "one of two lines above the rows of" in problem.message
    assert problem.source.startswith(row)
    assert "MoorDyn would leave this row out" in problem.remedy


def test_a_lost_heading_is_told_beside_other_mistakes(tmp_path):
    text = FILE.replace("id type x y z m v cda ca\n", "").replace("can Free", "can Fre")
    found = problems(tmp_path, text.replace("1 Fixed", "1 Fixde"))
    assert [problem.line for problem in found] == [18, 21, 21]
    assert any("above the rows of POINTS, names and units" in problem.message for problem in found)


def test_what_stands_behind_a_number_sign_is_no_value(tmp_path):
    text = FILE.replace("1 Fixed -60 1 -80 0 0 0 0", "1 Fixed -60 1 -80 # 0 0 0 0")
    (problem,) = problems(tmp_path, text)
    assert problem.message == "9 values are needed here, 5 are given"


VERSION_1 = """\
MoorDyn v1 sample input file
True Echo echo the input file data (flag)
----- LINE TYPES -----
LineType Diam MassDen EA BA/-zeta Can Cat Cdn Cdt
(-) (m) (kg/m) (N) (Pa-s/-) (-) (-) (-) (-)
nylon 0.124 13.76 2515288.0 -0.8 1.0 0.0 1.6 0.05
----- CONNECTION PROPERTIES -----
Node Type X Y Z M V FX FY FZ CdA CA
(-) (-) (m) (m) (m) (kg) (m^3) (kN) (kN) (kN) (m^2) (-)
1 Vessel 0.0 0 -10.00 0 0 0 0 0 0 0
2 Fixed 267.0 0 -70.00 0 0 0 0 0 0 0
----- LINE PROPERTIES -----
Line LineType UnstrLen NumSegs NodeAnch NodeFair Flags/Outputs
(-) (-) (m) (-) (-) (-) (-)
1 nylon 300.0 50 2 1 p
----- SOLVER OPTIONS -----
0.001 dtM
1025 rhoW
0 ICTmax
----- OUTPUTS -----
"""


def test_a_file_of_version_1_is_named_as_such(tmp_path):
    types, lines = problems(tmp_path, VERSION_1)
    assert (types.line, lines.line) == (6, 15)
    assert "a line type of MoorDyn version 1" in types.message
    assert "'Name Diam MassDen EA BA EI Cd Ca CdAx CaAx'" in types.remedy
    assert "a line of MoorDyn version 1: length and segments stand before" in lines.message
    assert "'ID LineType AttachA AttachB UnstrLen NumSegs Outputs'" in lines.remedy
    only = VERSION_1.replace("-0.8 1.0 0.0 1.6 0.05", "-0.8 0 1.6 1.0 0.05 0.0")
    (lines,) = problems(tmp_path, only)
    assert lines.line == 15
    only = VERSION_1.replace("300.0 50 2 1 p", "2 1 300.0 50 p")
    (types,) = problems(tmp_path, only)
    assert types.line == 6


def test_a_missing_column_alone_is_no_file_of_version_1(tmp_path):
    (problem,) = problems(tmp_path, FILE.replace("1.2 1 0.1 0\n", "1.2 1 0.1\n"))
    assert problem.message == "10 values are needed here, 9 are given"


@pytest.mark.parametrize(
    ("before", "after", "mark"),
    [
        ("2e7 -0.8 0 1.2", "0 -0.8 0 1.2", "rope 0.1 20 ^"),  # not the 0 of 0.1
        ("rope 0.1 20", "rope 0.1 0", "rope 0.1 ^"),
        ("3 rope 1 3 99", "3 rope 9 3 99", "3 rope ^"),
        ("2 rope R2B 2", "2 rope 7 2", "2 rope ^"),
    ],
)
def test_the_mark_stands_below_the_wrong_word(tmp_path, before, after, mark):
    (problem,) = problems(tmp_path, FILE.replace(before, after))
    assert problem.column == mark.index("^") + 1
