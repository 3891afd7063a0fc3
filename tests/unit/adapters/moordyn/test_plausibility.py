"""Warnings of values that can hardly be meant: one line each, with both numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_adapters.moordyn import MooringConfig, mooring, ready_mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.rest import longer_search, too_long
from m4e_adapters.moordyn.statics import Net
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmus.mooring import make

LINES = """\
water: {density: 1025, depth: 200}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+9, axial_damping_ratio: 1.0,
    drag_coefficient: 1.2, added_mass_coefficient: 1.0}
anchors: {a: [-610, -200]}
fairleads: {f: [-10, -10]}
lines: {l: {type: chain, from: a, to: f, unstretched_length: 640, segments: 20}}
"""
BUOY = """\
a buoy between two lines
----- LINE TYPES -----
name d m EA BA EI Cd Ca CdAx CaAx
- - - - - - - - - -
main 0.1 150 1e9 -1 0 1.2 1 0 0
----- POINTS -----
id type x y z m v cda ca
- - - - - - - - -
1 Fixed 0 0 -200 0 0 0 0
2 Free 50 0 -20 2000 40 5 0.5
3 Coupled 100 0 -10 0 0 0 0
----- LINES -----
id type a b length n out
- - - - - - -
1 main 1 2 240 20 -
2 main 2 3 80 10 -
----- OPTIONS -----
200 WtrDpth
-----
"""


def warnings(text: str) -> list[str]:
    """Those told when the FMU is made, and those of the start."""
    config = Document.parse(text).validate(MooringConfig)
    told = list[str]()
    make(config, name="mooring", folder=Path(), progress=told.append)
    made = mooring(config)
    lines = LineSystem(
        made.text,
        fairleads=[0.0],
        lines=made.lines,
        time_step=made.time_step,
        net=made.net,
        at_rest=made.at_rest,
        names=[fairlead.name for fairlead in made.fairleads],
        bed=made.bed,
    )
    lines.start([fairlead.place for fairlead in made.fairleads], [(0.0, 0.0)])
    lines.close()
    return [*(line for line in told if line.startswith("warning")), *lines.warnings]


def test_plausible_lines_start_without_a_word():
    assert warnings(LINES) == []


@pytest.mark.parametrize(
    ("before", "after", "parts"),
    [
        ("depth: 200", "depth: 400", ("anchor a", "z = -200 m, 200 m above the seabed at -400 m")),
        ("[-610, -200]", "[-610, 20]", ("anchor a is fixed above the water at z = 20 m",)),
        ("mass_per_length: 150", "mass_per_length: 0.15", ("1.471 N/m", " 78.95 N/m", "0.1 m")),
        (
            "stiffness: 1.0e+9",
            "stiffness: 1.0e+6",
            ("% at the start, where it", "1e+06 N"),
        ),
        (
            "mass_per_length: 150",
            "mass_per_length: 0.15",
            ("internal steps a second", "MoorDyn makes"),
        ),
        ("stiffness: 1.0e+9", "stiffness: 1.0e+6", ("by its own weight", "44.5 %", "not kN")),
        ("[-10, -10]", "[-10, 14]", ("fairlead f starts at z = 14 m, above the water",)),
        ("segments: 20", "segments: 1", ("weighs 4.455e+05 N", "pulls 4.455e+05 N", "than 1 ")),
    ],
)
def test_what_can_hardly_be_meant_is_told(before, after, parts):
    assert before in LINES
    found = [text for text in warnings(LINES.replace(before, after)) if parts[0] in text]
    assert len(found) == 1
    assert all(part in found[0] for part in parts)


def test_a_buoy_above_the_water_is_told_at_the_start_and_when_it_rises(tmp_path):
    path = tmp_path / "lines.txt"
    path.write_text(BUOY)
    made = ready_mooring(path, fairleads={})
    lines = LineSystem(
        made.text, fairleads=[0.0], lines=made.lines, time_step=made.time_step, net=made.net
    )
    lines.start([(100.0, -10.0)], [(0.0, 0.0)])
    (told,) = lines.warnings
    assert "free point 2 is at z = +11.2 m, above the water" in told
    assert "its buoyancy of 4.021e+05 N is not reduced" in told  # 1025 kg/m³ · 9.80665 · 40 m³
    assert lines.surfaced() == []
    lines.start([(100.0, -150.0)], [(0.0, 0.0)])  # pulled below
    assert not any("above the water" in text for text in lines.warnings)
    for k in range(40):
        lines.advance(0.5 * k, 0.5, [(100.0, -150.0 + 3.5 * k)], [(0.0, 7.0)])
    for k in range(40, 80):
        lines.advance(0.5 * k, 0.5, [(100.0, -10.0)], [(0.0, 0.0)])
    assert len(lines.surfaced()) == 1
    assert lines.surfaced() == []
    lines.close()


def test_a_floating_line_between_ends_above_the_water_has_room_to_go_down_to_it():
    points = [{"position": (x, 0, 3), "force": None} for x in (0, 47)]
    hawser = {"ends": (0, 1), "segments": 10, "length": 50.0, "weight": 70.0, "buoyancy": 80.0}
    hawser |= {"stiffness": 1e6, "bending": 0.0, "diameter": 0.1}
    assert too_long(Net(points, [hawser], -60.0, 3e6), ["hawser"]) == []
    (told,) = too_long(Net(points, [{**hawser, "length": 54.0}], -60.0, 3e6), ["hawser"])
    assert "1 m more than there is room for" in told


@pytest.mark.parametrize("wrong", ["[]", "{}", "1"])
def test_a_fairlead_that_is_no_name_is_one_problem(wrong):
    text = LINES.replace("{f: [-10, -10]}", f"[{wrong}]")
    with pytest.raises(InputError) as caught:
        Document.parse(text).validate(MooringConfig)
    assert "a list of fairleads contains names only" in caught.value.problems[0].message


@pytest.mark.parametrize(
    ("options", "advice"),
    [
        ("", "give MoorDyn a smaller threshIC"),
        ("1e-6 threshIC\n100 TmaxIC\n", "give MoorDyn a smaller threshIC"),
        ("1e-6 ICthresh\n1000 TmaxIC\n", "try MoorDyn's other method (1 ICgenDynamic"),
        ("1 ICgenDynamic\n1e-4 threshIC\n", "start the run before"),
    ],
)
def test_a_remedy_that_was_followed_is_not_given_again(options, advice):
    assert longer_search("--- OPTIONS ---\n" + options).startswith(advice)
