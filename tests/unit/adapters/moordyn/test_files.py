"""MoorDyn input files: written without loss; those of others run as they are, or say why not."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import moordyn
import pytest
from support.lines_in_waves import lines_of, mooring_of

from m4e_adapters.moordyn import Failure, Mooring, MooringConfig, mooring, ready_mooring
from m4e_adapters.moordyn.ready_files.read_file import Row
from m4e_adapters.moordyn.ready_files.read_file import tables as read_tables
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmus import mooring as mooring_kind

DATA = Path(__file__).parents[3] / "data" / "moordyn"
CASE1 = DATA / "moorpy_case1.dat"
PRECISE = """\
water: {density: 1025.0123456789012, depth: 200.1, gravity: 9.812345678901234}
line_types:
  rope:
    diameter: 0.12345678901234567
    mass_per_length: 33.333333333333336
    axial_stiffness: 1.2345678901234567e+8
    axial_damping: 1234.5678901234567
    bending_stiffness: 0.1
    drag_coefficient: 1.2
    added_mass_coefficient: 0.3
    axial_drag_coefficient: 0.7
    axial_added_mass_coefficient: 0.1
anchors: {a1: [-100.1, -200.1], a2: [100.30000000000001, -199.9]}
fairleads: {f1: [0.1, -3.3]}
lines:
  l1: {type: rope, from: a1, to: f1, unstretched_length: 230.10000000000002, segments: 7}
  l2: {type: rope, from: a2, to: f1, unstretched_length: 230.3, segments: 3}
seabed: {stiffness: 1.1e+5, damping: 1.3e+3}
solver: {scheme: RK2, time_step: 0.0012345678901234567}
"""


def tables(text: str) -> dict[str, tuple[Row, ...]]:
    return read_tables(text)[0]


def ready(folder: Path, text: str) -> Mooring:
    (folder / "lines.txt").write_text(text)
    return ready_mooring(folder / "lines.txt", fairleads={})


def options(made: Mooring) -> dict[str, str]:
    return {row.words[1]: row.words[0] for row in tables(made.text)["options"]}


def test_a_written_file_holds_every_number_exactly() -> None:
    made = mooring_of(PRECISE)
    found = tables(made.text)
    assert [float(w) for w in found["line types"][0].words[1:]] == [
        0.12345678901234567, 33.333333333333336, 1.2345678901234567e8, 1234.5678901234567,
        0.1, 1.2, 0.3, 0.7, 0.1,
    ]  # fmt: skip
    points = [(r.words[1], float(r.words[2]), float(r.words[4])) for r in found["points"]]
    ends = [("Fixed", -100.1, -200.1), ("Fixed", 100.30000000000001, -199.9)]
    assert points == [*ends, ("Coupled", 0.1, -3.3)]
    lines = [(*r.words[:4], float(r.words[4]), r.words[5]) for r in found["lines"]]
    assert lines == [
        ("1", "rope", "1", "3", 230.10000000000002, "7"),
        ("2", "rope", "2", "3", 230.3, "3"),
    ]
    given = options(made)
    numbers = {key: float(given[key]) for key in ("g", "rho", "wtrdpth", "dtM", "kbot", "cbot")}
    assert numbers == {
        "g": 9.812345678901234, "rho": 1025.0123456789012, "wtrdpth": 200.1,
        "dtM": 0.0012345678901234567, "kbot": 1.1e5, "cbot": 1.3e3,
    }  # fmt: skip
    assert given["tScheme"] == "RK2"


def test_a_ready_file_runs_as_it_is_and_keeps_what_is_not_ours() -> None:
    made = ready_mooring(CASE1, fairleads={})
    assert [(f.name, f.x, f.y, f.z) for f in made.fairleads] == [("fairlead_1", 0.0, 0.0, 0.0)]
    assert made.lines == ("line_1",)
    assert made.time_step == 0.001
    before, after = tables(CASE1.read_text()), tables(made.text)
    for kind in ("line types", "points"):
        assert [r.words for r in after[kind]] == [r.words for r in before[kind]]
    kept = {(r.words[0], r.words[1].lower()) for r in after["options"]}
    assert {("300", "wtrdpth"), ("3.0e6", "kbot"), ("50.0", "tmaxic"), ("0", "writelog")} <= kept
    assert after["outputs"] == ()
    assert after["lines"][0].words == (*before["lines"][0].words[:6], "-")
    # shorter, for the time of the test only: 4 instead of 40 segments of a suspended line
    text = made.text.replace("900.00 40", "900.00 4")
    system = lines_of(replace(made, text=text), net=None)
    system.start([(0.0, 0.0)], [(0.0, 0.0)])
    (force,) = system.force
    system.close()
    assert max(force) < 0


def test_waves_move_the_water_around_a_ready_file() -> None:
    """In the depth and gravity of the file."""
    made = mooring_of(f"file: {CASE1}\nwaves: {{spectrum: regular, height: 2, period: 8}}\n")
    assert made.sea is not None
    assert (made.sea.depth, made.sea.gravity) == (300.0, 9.80665)
    assert "\n1 WaveKin\n" in made.text
    assert "WaveKin" not in mooring_of(f"file: {CASE1}").text


def test_fairleads_of_a_ready_file_get_names_and_places(tmp_path: Path) -> None:
    text = CASE1.read_text().replace("Coupled   0.0   0.0     0.0", "Coupled   1.0   2.0  -3.0")
    (tmp_path / "lines.txt").write_text(text)
    for given, place in (("[bow]", (1.0, 2.0, -3.0)), ("{bow: [4, -5]}", (4.0, 2.0, -5.0))):
        config = Document.parse(f"file: lines.txt\nfairleads: {given}\n").validate(MooringConfig)
        (bow,) = mooring(config, folder=tmp_path).fairleads
        assert (bow.name, bow.x, bow.y, bow.z) == ("bow", *place)
    source = mooring_kind.KIND.build(config, name="lines", folder=tmp_path)
    assert json.loads(source.data["mooring.json"])["drawn"] == [["bow", 1.0, -3.0]]


CAN = (DATA / "free_body_with_rod.txt").read_text("utf-8")


def test_numbers_are_written_as_moordyn_reads_them(tmp_path: Path) -> None:
    """It reads 30e-1 segments as 30, and takes the last of two steps."""
    made = ready(tmp_path, CAN)
    assert tables(made.text)["rods"][0].words[9:] == ("3", "-")
    assert tables(made.text)["bodies"][0].words == tables(CAN)["bodies"][0].words
    steps = [row.words for row in tables(made.text)["options"] if row.words[1] in ("dtM", "DT")]
    assert (made.time_step, steps) == (0.0005, [("0.0005", "dtM")])


PUBLISHED = (DATA / "lines_of_a_vessel.txt").read_text("utf-8")


def published(folder: Path, option: str = "0 WaveKin", step: str = "0.0005 dt") -> Mooring:
    return ready(folder, PUBLISHED.replace("@", option).replace("0.0005   dt", step))


def test_points_of_a_coupled_body_are_fairleads_where_moordyn_has_them(
    tmp_path: Path, capfd
) -> None:
    made = published(tmp_path)
    assert [f.name for f in made.fairleads] == ["fairlead_1", "fairlead_2", "fairlead_3"]
    # MoorDyn itself, with the same body held
    text = re.sub("^1  Vessel", "1  Fixed", PUBLISHED.replace("@", ""), flags=re.MULTILINE)
    text = text.replace("10 20 30 1 1", "1 1").replace("\t", " ")
    text = "\n".join(line for line in text.splitlines() if line.strip()) + "\n--- END ---\n"
    text = text.replace("(n-m^2) (-)   (-)  (-)   (-)\n", "(-)\n")
    (tmp_path / "held.txt").write_text(text)
    system = moordyn.Create(str(tmp_path / "held.txt"))
    moordyn.Init_NoIC(system, [5.0, 0.0, -7.0], [0.0, 0.0, 0.0])
    there = [moordyn.GetPointPos(moordyn.GetPoint(system, k)) for k in (1, 3, 6)]
    moordyn.Close(system)
    capfd.readouterr()
    for fairlead, place in zip(made.fairleads, there, strict=True):
        assert (fairlead.x, fairlead.y, fairlead.z) == pytest.approx(place, abs=1e-9)


OF_OPENFAST = """\
--- LINE TYPES ---
name d m EA BA EI Cd Ca CdAx CaAx (m³)
-
rope 0.1 20 2e7 -0.8 0 1.2 1 0.1 0
--- ROD TYPES ---
-
-
can 2.5 900 0.6 1.1 1.3 1.4
--- BODIES ---
-
-
1 Coupled 0 0 -4 0 0 90 1e5 0 0 0 0 0
--- RODS ---
-
-
1 can Body1 1 0 0 1 2 0 2 -
--- POINTS ---
-
-
1 Fixed -60 0 -40 0 0 0 0
2 Body1 1 0 0 3 0 0 0
3 Free -30 0 -30 0 0 0 0
--- LINES ---
-
-
1 rope 1 3 35 4 -
2 rope 3 2 40 4 -
--- FAILURE ---
-
-
1 Point3 1,2 0 5e4
2 3 2 7 0
--- OPTIONS ---
0 outSwitch
"w.dat" WaterKin
0.3 MU_KT
0.3 MU_KA
60 CV
9.81 g
"""


def test_a_file_of_openfast_gets_its_water_and_says_what_has_no_effect(tmp_path: Path) -> None:
    path = tmp_path / "moordyn.dat"
    path.write_bytes(
        OF_OPENFAST.replace("--- FAILURE", "--- CONTROL ---\n--- FAILURE").encode("latin-1")
    )
    with pytest.raises(InputError, match="WtrDpth, is missing"):
        ready_mooring(path, fairleads={})
    with pytest.raises(InputError, match="of the component gives"):
        ready_mooring(path, fairleads={}, water={"depth": 40.0, "gravity": 9.8})
    with pytest.raises(InputError, match="lines of coupled rods"):
        ready_mooring(path, fairleads={}, water={"depth": 40.0})


def test_rods_and_failures_of_a_file_of_openfast(tmp_path: Path) -> None:
    path = tmp_path / "moordyn.dat"
    without = OF_OPENFAST.replace("1 can Body1", "1 can Fixed")
    path.write_text(without)
    made = ready_mooring(path, fairleads={}, water={"depth": 40.0, "density": 1000.0})
    assert made.failures == (Failure(((0, 1), (1, 0)), tension=5e4), Failure(((1, 0),), time=7.0))
    given = options(made)
    assert {key: given[key] for key in ("wtrdpth", "rho", "frictioncoefficient", "fricdamp")} == {
        "wtrdpth": "40.0", "rho": "1000.0", "frictioncoefficient": "0.3", "fricdamp": "60",
    }  # fmt: skip
    assert "FAILURE" not in made.text
    (elsewhere,) = [note for note in made.notes if "MoorDyn-F" in note]
    assert "outSwitch 0, WaterKin" in elsewhere
    assert any("leaves out the mass of coupled body 1" in note for note in made.notes)
    assert any("mass of coupled point 2 only weighs" in note for note in made.notes)
    # the body is turned by 90° about Z
    path.write_text(OF_OPENFAST.split("--- FAILURE")[0] + "--- OPTIONS ---\n40 WtrDpth\n")
    made = ready_mooring(path, fairleads={})
    names = ["fairlead_1_a", "fairlead_1_b", "fairlead_2"]
    assert [fairlead.name for fairlead in made.fairleads] == names
    places = [(0, 1, -4), (-2, 1, -4), (0, 1, -4)]
    for fairlead, place in zip(made.fairleads, places, strict=True):
        assert (fairlead.x, fairlead.y, fairlead.z) == pytest.approx(place, abs=1e-9)
    assert (made.ends, made.inert) == ((2, 1), True)
    assert made.axes[0] == pytest.approx((-1, 0, 0), abs=1e-9)


def test_files_of_curves_get_names_of_their_own(tmp_path: Path) -> None:
    """Also where two are called alike, and as MoorDyn's input."""
    curve = "x\nx\nx\n0 0\n0.1 2e6\n0.2 5e6\n\n"
    for folder, content in (("a", curve), ("b", curve.replace("5e6", "6e6"))):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "lines.txt").write_text(content)
    (tmp_path / "syrope.dat").write_text("b/lines.txt OWC\nLINEAR WCType\n0.2 k1\n1 k2\n")
    text = CASE1.read_text()
    first = next(
        row for row in text.splitlines() if row.startswith(tables(text)["line types"][0].words[0])
    )
    words = first.split()
    more = [words[0] + "2", *words[1:3], "SYROPE:syrope.dat|1e8|1", "1e8|1e6", *words[5:]]
    words[3] = "a/lines.txt"
    (tmp_path / "file.txt").write_text(text.replace(first, " ".join(words) + "\n" + " ".join(more)))
    made = ready_mooring(tmp_path / "file.txt", fairleads={})
    assert {*made.files} == {"_lines.txt", "__lines.txt", "syrope.dat"}
    assert made.files["syrope.dat"].startswith(b"__lines.txt OWC")
    rows = [row.words[3] for row in tables(made.text)["line types"]]
    assert rows == ["_lines.txt", "SYROPE:syrope.dat|1e8|1"]
    assert made.net is None
    assert "Syrope" in made.no_way_back
