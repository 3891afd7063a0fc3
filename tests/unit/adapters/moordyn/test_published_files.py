"""Ready MoorDyn files with the traits of published ones: they run unedited, or say why not."""

from __future__ import annotations

import math
import re
from pathlib import Path

import moordyn
import pytest

from m4e_adapters.moordyn import Mooring, ready_mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.ready_files.sections import tables
from m4e_fmi.cli import main
from m4e_fmi.errors import InputError

FILE = """\
three lines of a body, two of them by buoys
Echo true
------------------------- LINE TYPES --------------------------------------------------
LineType  Diam    MassDenInAir    EA       BA/-zeta    EI    Cd  Ca  CdAx CaAx
(-)       (m)       (kg/m)        (N)      (Pa-s/-)  (n-m^2) (-)   (-)  (-)   (-)

chain\t0.1 60 2e8 -0.8 0 1.2 1.0 0.1 0
---------------------------- BODIES -----------------------------------------------------
ID   Attachment  X0  Y0  Z0  r0  p0  y0  Mass  CG*   I*  Volume   CdA*   Ca
(#)     (-)      (m) (m) (m) (deg) (deg) (deg) (kg) (m) (kg-m^2) (m^3) (m^2)  (-)
1  Vessel   4 1 -6   20 30 -50    0 0|0|-1 0|0|0 0 0 0
---------------------- POINT PROPERTIES -----------------------------------------
ID      Attachment    X      Y     Z            Mass   Volume     CdA     CA
(#)     (word/ID)    (m)    (m)   (m)           (kg)   (m^3)      (m^2)   (-)
1    body1     -3.0  0.5  1.5     0 0 0 0
2    Anchor    -90.0  0  -40.00   0 0 0 0
3    Body1     2.0  -1 0     0 0 0 0
4    Fix       70.0 60   -40.0    0 0 0 0
5    Connect   -30.0 0 -12   500 2.0 1 1
6    Vessel    5 0 -7  0 0 0 0

---------------------- LINES -----------------------------------------------------
ID     LineType  AttachA  AttachB  UnstrLen     NumSegs   LineOutputs
(#)      (-)       (#)      (#)       (m)         (-)       (-)
1        chain     2         5        72          6        tp
2        chain     Point5    P1       30          3        -
3        chain     4         3        105         6        pt
4        chain     4         6        100         6        pt
---------------------- SOLVER OPTIONS-----------------------------------------
0.0005   dt           - time step to use in mooring integration
@
40       WtrDpth      - water depth
5.0      ICDfac       - factor
0.01     ICthresh
100      ICTmax
2        writeLog     - Write a log file
-------------------------- OUTPUTS --------------------------------
FairTen1 FairTen2 Point2px"""  # nothing closes the last section


def published(tmp_path: Path, option: str = "0 WaveKin", step: str = "0.0005 dt") -> Mooring:
    path = tmp_path / "lines.txt"
    path.write_text(FILE.replace("@", option).replace("0.0005   dt", step))
    return ready_mooring(path, fairleads={})


def started(made: Mooring) -> LineSystem:
    lines = LineSystem(
        made.text,
        fairleads=[f.y for f in made.fairleads],
        lines=made.lines,
        time_step=made.time_step,
        net=made.net,
        at_rest=made.at_rest,
        notes=made.notes,
    )
    lines.start([(f.x, f.z) for f in made.fairleads], [(0.0, 0.0)] * len(made.fairleads))
    return lines


def test_points_of_a_coupled_body_are_fairleads_where_moordyn_has_them(tmp_path, capfd):
    made = published(tmp_path)
    assert [f.name for f in made.fairleads] == ["fairlead_1", "fairlead_2", "fairlead_3"]
    # MoorDyn itself, with the same body held
    text = re.sub("^1  Vessel", "1  Fixed", FILE.replace("@", ""), flags=re.MULTILINE)
    text = "\n".join(line for line in text.splitlines() if line.strip()) + "\n--- END ---\n"
    text = text.replace("(n-m^2) (-)   (-)  (-)   (-)\n", "(-)\n").replace("\t", " ")
    (tmp_path / "held.txt").write_text(text)
    system = moordyn.Create(str(tmp_path / "held.txt"))
    moordyn.Init_NoIC(system, [5.0, 0.0, -7.0], [0.0, 0.0, 0.0])
    there = [moordyn.GetPointPos(moordyn.GetPoint(system, k)) for k in (1, 3, 6)]
    moordyn.Close(system)
    capfd.readouterr()
    for fairlead, place in zip(made.fairleads, there, strict=True):
        assert (fairlead.x, fairlead.y, fairlead.z) == pytest.approx(place, abs=1e-9)


def test_it_starts_at_rest_and_runs(tmp_path):
    made = published(tmp_path)
    lines = started(made)
    assert lines.warnings == []
    before = list(lines.fairlead_tension)
    at = [(f.x, f.z) for f in made.fairleads]
    for k in range(40):
        lines.advance(0.25 * k, 0.25, at, [(0.0, 0.0)] * 3)
    after = list(lines.fairlead_tension)
    lines.close()
    assert after == pytest.approx(before, rel=1e-4)


@pytest.mark.parametrize(
    ("option", "note"),
    [
        ("1 WaveKin", "WaveKin 1 of the file: nothing gives water kinematics, lines are in still"),
        ("midpoint5 tScheme", "time scheme midpoint5 of the file is replaced by RK4"),
        ("lines.ic fileIC", "initial state lines.ic of the file is not used: lines start at rest"),
    ],
)
def test_what_is_taken_otherwise_is_told_at_the_start(tmp_path, option, note):
    made = published(tmp_path, option)
    lines = started(made)
    lines.close()
    (warning,) = lines.warnings
    assert note in warning
    options = {row.words[1].lower(): row.words[0] for row in tables(made.text)["options"]}
    assert options["tscheme"] in ("RK2", "RK4")
    assert "wavekin" not in options
    assert "fileic" not in options


def test_a_step_for_another_scheme_is_shortened_where_rk4_needs_it(tmp_path):
    made = published(tmp_path, "midpoint5 tScheme", "0.1 dtM")
    assert made.time_step < 0.02
    assert made.notes[0] == "the time scheme midpoint5 of the file is replaced by RK4"
    assert f"0.1 dtM of the file would be 0.1 s: steps are of {made.time_step:.3g} s" in made.notes


def test_a_step_by_cfl_is_shortened_where_it_is_unstable(tmp_path):
    path = tmp_path / "lines.txt"
    path.write_text(FILE.replace("@", "0.5 CFL").replace("0.0005   dt ", "0 WaveKin"))
    made = ready_mooring(path, fairleads={})
    (note,) = made.notes
    assert re.fullmatch(r"0\.5 CFL of the file would be \S+ s: steps are of \S+ s", note)
    assert f"{made.time_step:.3g} s" in note


def test_a_file_that_asks_for_no_static_solution_starts_as_drawn_and_tells(tmp_path):
    path = tmp_path / "lines.txt"
    path.write_text(FILE.replace("@", "").replace("100      ICTmax", "0 TmaxIC"))
    lines = started(ready_mooring(path, fairleads={}))
    lines.close()
    assert any("does not start at rest" in text for text in lines.warnings)
    assert all("TmaxIC 0" in text for text in lines.warnings if "not start at rest" in text)


ROD = "--- ROD TYPES ---\nx\nx\ncan 1 100 1 1 1 1\n--- RODS ---\nx\nx\n1 can {} 0 0 2 0 0 5 2 -\n"


@pytest.mark.parametrize("kind", ["Body1", "Coupled", "VesselPinned"])
def test_rods_that_a_body_would_carry_are_refused_with_reason(tmp_path, kind):
    title = "---------------------- POINT PROPERTIES"
    path = tmp_path / "lines.txt"
    path.write_text(FILE.replace("@", "").replace(title, ROD.format(kind) + title))
    with pytest.raises(InputError) as caught:
        ready_mooring(path, fairleads={})
    (problem,) = caught.value.problems
    assert "their weight and moments would be lost" in problem.message
    assert problem.line == 19
    assert "points of the body" in problem.remedy


@pytest.mark.parametrize(
    ("before", "after", "word", "message"),
    [
        ("0 0|0|-1", "1e5 0|0|-1", "1e5", "the mass 1e5 of coupled body 1 would be lost"),
        ("0|0|0 0", "0|1e3|0 0", "0|1e3|0", "the moment of inertia 0|1e3|0 of coupled body 1"),
        ("0|0|0 0", "0|0|0 5e2", "5e2", "the volume 5e2 of coupled body 1 would be lost"),
        ("0|0|0 0 0", "0|0|0 0 5", "5", "the drag area 5 of coupled body 1 would be lost"),
        ("-7  0 0", "-7  5e5 0", "5e5", "the inertia of coupled point 6 would be lost: its mass"),
        ("-7  0 0 0 0", "-7  0 4 0 .5", ".5", "added mass of coupled point 6, CA .5 of 4 m³"),
        ("1.5     0", "1.5     5e5", "5e5", "the inertia of coupled point 1 would be lost"),
    ],
)
def test_what_a_moved_body_or_point_would_lose_is_refused(tmp_path, before, after, word, message):
    path, text = tmp_path / "lines.txt", FILE.replace("@", "")
    assert text.count(before) == 1
    path.write_text(text.replace(before, after))
    with pytest.raises(InputError) as caught:
        ready_mooring(path, fairleads={})
    (problem,) = caught.value.problems
    assert message in problem.message
    assert "in the model that moves" in problem.remedy
    assert problem.source == path.read_text().splitlines()[problem.line - 1]
    assert problem.source[problem.column - 1 :].split()[0] == word
    assert after in problem.source


def test_a_free_rod_is_left_to_moordyn(tmp_path):
    title = "---------------------- POINT PROPERTIES"
    path = tmp_path / "lines.txt"
    text = FILE.replace("@", "").replace(title, ROD.format("Free") + title)
    path.write_text(
        text.replace("100      ICTmax", "5 ICTmax").replace("0 0 2 0 0 5", "9 9 -9 9 9 -6")
    )
    made = ready_mooring(path, fairleads={})
    assert made.net is None
    lines = started(made)
    lines.close()
    told, *_ = [text for text in lines.warnings if "equilibrium was not found" in text]
    assert "give MoorDyn a smaller threshIC (1e-6) and more time (TmaxIC 1000), or" in told
    assert "1 ICgenDynamic" in told


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "it is empty"),
        (b" \n\n", "it is empty"),
        (b"\xff\xfe\x00", "byte 1 is not valid UTF-8"),
        (b"name: buoy\n", "section LINE TYPES is missing"),
    ],
)
def test_a_file_that_is_none_ends_with_exit_code_2(tmp_path, capsys, content, message):
    (tmp_path / "lines.txt").write_bytes(content)
    (tmp_path / "system.yaml").write_text(
        "name: s\ncomponents: {m: {kind: mooring, file: lines.txt}}\n"
        "simulation: {stop_time: 1, step_size: 0.1}\n"
    )
    assert main(["build", str(tmp_path / "system.yaml")]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert str(tmp_path / "lines.txt") in told


def test_all_that_is_wrong_with_a_file_is_told_at_once(tmp_path):
    text = FILE.replace("@", "1e300 rho\nfloor.txt seafloorFile\n0 dtMM")
    text = text.replace("chain\t0.1 60", "chain\tnan 1e9").replace("Connect", "Conect")
    path = tmp_path / "lines.txt"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        ready_mooring(path, fairleads={})
    told = [(problem.line, problem.message) for problem in caught.value.problems]
    assert [line for line, _ in told] == [7, 7, 19, 31, 32, 33]
    assert all(problem.remedy and problem.source for problem in caught.value.problems)


def test_the_position_of_a_fairlead_follows_its_body(tmp_path):
    made = published(tmp_path)
    first, second, _ = made.fairleads
    # whatever the body's angles, its points keep their distance
    assert math.dist((first.x, first.y, first.z), (second.x, second.y, second.z)) == pytest.approx(
        math.dist((-3.0, 0.5, 1.5), (2.0, -1.0, 0.0))
    )


@pytest.mark.parametrize(
    ("behind", "said"),
    [
        ("1 1 # the free buoy, of steel", ""),
        ("10 20 30 1 1", ""),
        ("-5 1", "drag area CdA"),
        ("1 nan", "'nan' is not a number"),
        ("abc 1", "'abc' is not a number"),
        ("10 20 30 -1 1", "drag area CdA"),
    ],
)
def test_what_stands_behind_a_points_volume(tmp_path: Path, behind: str, said: str) -> None:
    path = tmp_path / "lines.txt"
    row = "5    Connect   -30.0 0 -12   500 2.0 "
    path.write_text(FILE.replace("@", "0 WaveKin").replace(f"{row}1 1", f"{row}{behind}"))
    if not said:
        assert ready_mooring(path, fairleads={}).lines
        return
    with pytest.raises(InputError, match=said) as caught:
        ready_mooring(path, fairleads={})
    (problem,) = caught.value.problems
    assert problem.line == path.read_text().splitlines().index(f"{row}{behind}") + 1
