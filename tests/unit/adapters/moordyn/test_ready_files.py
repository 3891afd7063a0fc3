"""MoorDyn input files: written without loss, and other people's files accepted or refused."""

import json
import math
from pathlib import Path

import moordyn
import pytest

from m4e_adapters.moordyn import MooringConfig, mooring, ready_mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.ready_files.sections import tables
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmus import mooring as mooring_kind

CASE1 = Path(__file__).parents[3] / "data" / "moordyn" / "moorpy_case1.dat"

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


def test_a_written_file_holds_every_number_exactly():
    config = Document.parse(PRECISE).validate(MooringConfig)
    found = tables(mooring(config).text)
    kind = config.line_types["rope"]
    assert [float(w) for w in found["line types"][0].words[1:]] == [
        kind.diameter,
        kind.mass_per_length,
        kind.axial_stiffness,
        kind.axial_damping,
        kind.bending_stiffness,
        kind.drag_coefficient,
        kind.added_mass_coefficient,
        kind.axial_drag_coefficient,
        kind.axial_added_mass_coefficient,
    ]
    points = [(r.words[1], float(r.words[2]), float(r.words[4])) for r in found["points"]]
    assert points == [
        ("Fixed", -100.1, -200.1),
        ("Fixed", 100.30000000000001, -199.9),
        ("Coupled", 0.1, -3.3),
    ]
    lines = [(*r.words[:4], float(r.words[4]), r.words[5]) for r in found["lines"]]
    assert lines == [
        ("1", "rope", "1", "3", 230.10000000000002, "7"),
        ("2", "rope", "2", "3", 230.3, "3"),
    ]
    options = {r.words[1]: r.words[0] for r in found["options"]}
    numbers = {key: float(options[key]) for key in ("g", "rho", "WtrDpth", "dtM", "kBot", "cBot")}
    assert numbers == {
        "g": 9.812345678901234,
        "rho": 1025.0123456789012,
        "WtrDpth": 200.1,
        "dtM": 0.0012345678901234567,
        "kBot": 1.1e5,
        "cBot": 1.3e3,
    }
    assert options["tScheme"] == "RK2"


def test_lines_of_one_segment_need_no_short_step():
    text = PRECISE.replace("segments: 7", "segments: 1").replace("segments: 3", "segments: 1")
    text = text.replace("solver: {scheme: RK2, time_step: 0.0012345678901234567}\n", "")
    made = mooring(Document.parse(text).validate(MooringConfig))
    assert made.time_step >= 1


def test_a_ready_file_runs_as_it_is():
    made = ready_mooring(CASE1, fairleads={})
    assert [(f.name, f.x, f.y, f.z) for f in made.fairleads] == [("fairlead_1", 0.0, 0.0, 0.0)]
    assert made.lines == ("line_1",)
    assert made.time_step == 0.001
    # shorter, for the time of the test only: 4 instead of 40 segments of a suspended line
    text = made.text.replace("900.00 40", "900.00 4")
    system = LineSystem(text, fairleads=[0.0], lines=made.lines, time_step=made.time_step)
    system.start([(0.0, 0.0)], [(0.0, 0.0)])
    ((force_x, force_z),) = system.force
    system.close()
    assert force_x < 0
    assert force_z < 0


def test_waves_move_the_water_around_a_ready_file():
    """In the depth and gravity of the file."""
    text = f"file: {CASE1}\nwaves: {{spectrum: regular, height: 2, period: 8}}\n"
    made = mooring(Document.parse(text).validate(MooringConfig))
    assert made.sea is not None
    assert (made.sea.depth, made.sea.gravity) == (300.0, 9.80665)
    assert "\n1 WaveKin\n" in made.text
    assert "WaveKin" not in mooring(Document.parse(f"file: {CASE1}").validate(MooringConfig)).text


def test_a_ready_file_keeps_what_is_not_ours():
    before, after = tables(CASE1.read_text()), tables(ready_mooring(CASE1, fairleads={}).text)
    assert [r.words for r in after["line types"]] == [r.words for r in before["line types"]]
    assert [r.words for r in after["points"]] == [r.words for r in before["points"]]
    kept = {r.words[:2] for r in after["options"]}
    assert {("300", "WtrDpth"), ("3.0e6", "kbot"), ("50.0", "TmaxIC")} <= kept
    assert ("0", "writeLog") in kept
    assert after["outputs"] == ()
    assert after["lines"][0].words == (*before["lines"][0].words[:6], "-")


def test_fairleads_of_a_ready_file_get_the_names_that_are_given(tmp_path):
    text = CASE1.read_text().replace("Coupled   0.0   0.0     0.0", "Coupled   1.0   2.0  -3.0")
    (tmp_path / "lines.txt").write_text(text)
    config = Document.parse("file: lines.txt\nfairleads: [bow]\n").validate(MooringConfig)
    (bow,) = mooring(config, folder=tmp_path).fairleads
    assert (bow.name, bow.x, bow.y, bow.z) == ("bow", 1.0, 2.0, -3.0)
    config = Document.parse("file: lines.txt\nfairleads: {bow: [4, -5]}\n").validate(MooringConfig)
    (bow,) = mooring(config, folder=tmp_path).fairleads
    assert (bow.x, bow.y, bow.z) == (4.0, 2.0, -5.0)
    source = mooring_kind.make(config, name="lines", folder=tmp_path)
    layout = json.loads(source.data["mooring.json"])
    del layout["nodes"]  # which of them the FMU shows
    assert layout["drawn"] == [["bow", 1.0, -3.0]]
    layout["net"]["lines"][0] |= {"length": 860, "segments": 2}
    lines = LineSystem(source.data["lines.txt"].decode().replace("900.00 40", "860 2"), **layout)
    lines.start([(100.0, -3.0)], [(0.0, 0.0)])
    lines.close()
    assert len(lines.warnings) == 2
    assert "starts at (100, -3) m and is at (1, -3) m in the file, 99 m away" in lines.warnings[0]
    strain = math.dist((-800, 0, -300), (100, 2, -3)) / 860 - 1
    assert f" m apart, {100 * strain:.3g} % beyond its unstretched length" in lines.warnings[1]
    config = Document.parse("file: lines.txt\nfairleads: [a, b]\n").validate(MooringConfig)
    with pytest.raises(InputError, match="1 coupled points, but 2 names"):
        mooring(config, folder=tmp_path)
    config = Document.parse("file: missing.txt\n").validate(MooringConfig)
    with pytest.raises(InputError, match="no such MoorDyn file"):
        mooring(config, folder=tmp_path)


FREE_POINT = "3 Free 0 0 -5 1 0 0 0\n"
MAIN = "main 0.1 100 1e9 -1 0 1 1 0 0\n"
ROD = "--- ROD TYPES ---\nx\nx\ncan 1 1 1 1 1 1\n--- RODS ---\nx\nx\n"
ROD += "1 cna Free 0 0 -9 0 0 -5 1 -\n"
PINNED = "------ BODIES ------\nx\nx\n1 CoupledPinned 0 0 0 0 0 0 1e3 0 1e3 1 0 0\n"


@pytest.mark.parametrize(
    ("before", "after", "message", "remedy"),
    [
        ("900.00    40 ", "900.00    0 ", "segments must be positive, got 0", "and 1000"),
        ("900.00    40 ", "900.00    4.5 ", "segments: 4.5 is not a whole", "whole number"),
        ("900.00    40 ", "900.00    1e9 ", "segments 1e9 cannot be meant", "and 1000"),
        ("900.00    40 ", "-1.1    40 ", "length must not be negative, got -1.1", "sign"),
        ("1     main      1", "1     mian      1", "no line type 'mian'", "'main'"),
        ("main      1         2 ", "main      1         7 ", "no point 7", "points"),
        ("2   Coupled", "2   Free   ", "no coupled point", "type 'Coupled'"),
        ("  0     1    0.27", "  0    -1    0.27", "drag coefficient Cd must not be", "sign"),
        ("  0     1    0.27", " -1     1    0.27", "bending stiffness EI must not be", "sign"),
        ("3.0e6    kbot", "-1    kbot", "kbot must not be negative", "sign"),
        ("main  0.2  500.00", "main  0.2  heavy", "'heavy' is not a number", "as a number"),
        ("main  0.2  500.00", "main  0.2  nan", "'nan' is not a number", "as a number"),
        ("main  0.2  500.00", "main  0.2  1e9", "mass per length 1e9 cannot be meant", "1e+06"),
        ("main  0.2  500.00", "main  1e300 500", "diameter 1e300 cannot be meant", "SI"),
        ("main  0.2  500.00", "main  0  500", "diameter must be positive", "SI"),
        ("2.0E+09", "curve.txt", "'curve.txt' is not a number", "tables"),
        ("2.0E+09", "1e9|2e9", "'1e9|2e9' is not a number", "tables"),
        ("2.0E+09", "1e-300", "stiffness EA 1e-300 cannot be meant", "SI"),
        ("0.001    dtM", "0.1    dtM", "time step 0.1 s is unstable", "RK4"),
        ("0.001    dtM", "1e-300    dtM", "dtM 1e-300 cannot be meant", "between 1e-06"),
        ("0.001    dtM", "nan    dtM", "'nan' is not a number", "constant"),
        ("1.0      dtIC", "1e11      dtIC", "dtIC 1e11 cannot be meant", "10000"),
        ("50.0     TmaxIC", "1e300     TmaxIC", "TmaxIC 1e300 cannot be meant", "100000"),
        ("0.001    dtM", "RK5 tScheme", "no time scheme 'RK5'", "RK2 or RK4"),
        ("0.001    dtM", "0.001 dtN", "unknown option 'dtN'", "'dtm'"),
        (
            "0.001    threshIC  - threshold for IC convergence (-)",
            "0.001",
            "needs a value and a name",
            "dtM",
        ),
        ("0.001    dtM", "floor.txt seafloorFile", "sea floor from a file", "WtrDpth"),
        ("0.001    dtM", "2 Currents", "currents", "set Currents to 0"),
        ("0.001    dtM", "7 WaveKin", "water kinematics", "set WaveKin to 0"),
        ("0.001    dtM", "floor.txt SeafloorFile", "sea floor from a file", "WtrDpth"),
        (
            "-300.0    0    0",
            "-301.0    0    0",
            "below the seabed at -300 m",
            "WtrDpth at least 301",
        ),
        ("Coupled   0.0   0.0     0.0 ", "Coupled   0.0   0.0  -310 ", "below the seabed", "raise"),
        (
            "2   Coupled   0.0   0.0     0.0 ",
            "2 Coupled -800 0 -300 ",
            "ends of line 1",
            "move one",
        ),
        ("2   Coupled", "2   Cuopled", "no type of point 'Cuopled'", "'Coupled'"),
        ("2   Coupled", "2   Body1", "no body for 'Body1'", ""),
        ("2   Coupled", "1   Coupled", "number 1 where 2 is expected", "1, 2, 3"),
        ("1     main      1", "2     main      1", "number 2 where 1 is expected", "1, 2, 3"),
        ("main      1         2 ", "main      2         2 ", "begins and ends at 2", "another"),
        (
            "---------------------- LINES",
            FREE_POINT + "--- LINES",
            "no line ends at point 3",
            "rem",
        ),
        ("main  0.2", MAIN + "main  0.2", "line type 'main' is given twice", "rename"),
        (
            "---------------------- SOLVER",
            "--- SYROPE IC ---\n--- SOLVER",
            "this section",
            "remove",
        ),
        ("---------------------- SOLVER", "--- FAILURE ---\nx\nx\n1 2 1 9 9\n--- ", "failures", ""),
        ("0.001    dtM", "0.1 DT", "time step 0.1 s is unstable", "RK4"),
        ("300      WtrDpth", "bath.txt WtrDpth", "'bath.txt' is not a number", "constant"),
        ("- POINTS -", "- PONITS -", "section POINTS is missing", "add it"),
        ("---------------------- POINTS", ROD + "--- POINTS", "no rod type 'cna'", "'can'"),
        ("---------------------- POINTS", PINNED + "--- POINTS", "pinned bodies", "'Coupled'"),
    ],
)
def test_what_is_not_supported_is_refused(tmp_path, before, after, message, remedy):
    text = CASE1.read_text()
    assert before in text
    path = tmp_path / "lines.txt"
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(InputError) as caught:
        ready_mooring(path, fairleads={})
    matching = [p for p in caught.value.problems if message in p.message]
    assert len(matching) == 1
    assert remedy in matching[0].remedy
    assert matching[0].file == str(path)


def test_the_step_of_a_ready_file_has_one_name(tmp_path):
    """MoorDyn takes the last of dtM and DT: two that differ are refused, elsewhere."""
    path = tmp_path / "lines.txt"
    path.write_text(CASE1.read_text().replace("0.001    dtM", "1e-3 dtM\n0.001 DT"))
    made = ready_mooring(path, fairleads={})
    steps = [row.words for row in tables(made.text)["options"] if row.words[1] in ("dtM", "DT")]
    assert (made.time_step, steps) == (0.001, [("0.001", "dtM")])


def test_a_ready_file_without_a_step_gets_a_stable_one(tmp_path):
    path = tmp_path / "lines.txt"
    path.write_text(CASE1.read_text().replace("0.001    dtM", "0 WaveKin"))
    made = ready_mooring(path, fairleads={})
    # l/2 √(m'/EA) = 5.6 ms is 1/ω; RK2 with ζ = 1 is stable up to 2/ω
    assert 0.3 * 2 * 0.005625 < made.time_step < 2 * 0.005625


def test_moordyn_reads_the_written_file_as_it_was_meant(tmp_path, capfd):
    path = tmp_path / "lines.txt"
    path.write_text(mooring(Document.parse(PRECISE).validate(MooringConfig)).text)
    system = moordyn.Create(str(path))
    capfd.readouterr()
    try:
        lines = [moordyn.GetLine(system, k) for k in (1, 2)]
        assert moordyn.NCoupledDOF(system) == 3
        assert [moordyn.GetLineN(line) for line in lines] == [7, 3]
        lengths = [moordyn.GetLineUnstretchedLength(line) for line in lines]
        assert json.dumps(lengths) == "[230.10000000000002, 230.3]"
    finally:
        moordyn.Close(system)
