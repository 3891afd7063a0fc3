"""One line system: forces at the start, saved states, independence, silence, failures."""

import json
import math
import os
import re
import sys

import pytest
from support.lines_in_waves import line_system

from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.moordyn_system import MooringError
from m4e_adapters.moordyn.placement import misplaced
from m4e_adapters.moordyn.rest import left_over, too_long
from m4e_adapters.moordyn.statics import Net
from m4e_fmi.files.document import Document

STIFFNESS, LENGTH = 1e9, 100.5

ROPE = """\
water: {density: 0, depth: 1000}
line_types:
  rope: {diameter: 1.0e-3, mass_per_length: 1.0e-3, axial_stiffness: 1.0e+9, axial_damping: 0,
         drag_coefficient: 0, added_mass_coefficient: 0}
anchors: {top: [0, 0]}
fairleads: [bob]
lines:
  rope: {type: rope, from: top, to: bob, unstretched_length: 100.5, segments: 1}
"""

CHAIN = """\
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1, axial_drag_coefficient: 0.4}
anchors: {left: [-150, -60], right: [150, -60]}
fairleads: [f1, f2]
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
  l2: {type: chain, from: right, to: f2, unstretched_length: 165, segments: 6}
  l3: {type: chain, from: right, to: f2, unstretched_length: 166, segments: 5}
static_equilibrium: AT_REST
"""

SPATIAL = """\
dimensions: 3
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1, axial_drag_coefficient: 0.4}
anchors: {left: [-150, 0, -60]}
fairleads: {f1: [-5, 0, -3]}
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
"""

AT = [(-5.0, -3.0), (5.0, -3.0)]
REST = [(0.0, 0.0), (0.0, 0.0)]


def system(text: str) -> LineSystem:
    made = mooring(Document.parse(text).validate(MooringConfig))
    return LineSystem(
        made.text,
        fairleads=[f.y for f in made.fairleads],
        lines=made.lines,
        time_step=made.time_step,
        net=made.net,
        at_rest=made.at_rest,
        names=[f.name for f in made.fairleads],
        placed=[f.name for f in made.fairleads if f.placed],
        bed=made.bed,
    )


def chain(at_rest: bool = True) -> LineSystem:
    return system(CHAIN.replace("AT_REST", str(at_rest).lower()))


def motion(k: int, h: float) -> tuple[list, list]:
    """Fairleads at k·h and their mean velocity over the step, for a 5 s motion of 1 m."""

    def at(t: float) -> tuple[float, float]:
        return math.sin(1.25 * t), 0.5 * math.sin(1.25 * t)

    (x0, z0), (x1, z1) = at(k * h), at((k + 1) * h)
    return [(x + x0, z + z0) for x, z in AT], [((x1 - x0) / h, (z1 - z0) / h)] * 2


def run(lines: LineSystem, first: int, count: int, h: float = 0.05) -> list:
    found = []
    for k in range(first, first + count):
        lines.advance(k * h, h, *motion(k, h))
        found.append((lines.force, lines.fairlead_tension, lines.anchor_tension))
    return found


def test_force_at_the_start_without_a_static_solution():
    lines = system(ROPE)
    lines.start([(10.0, -100.00216)], [(0.0, 0.0)])
    ((force_x, force_z),) = lines.force
    lines.close()
    length = math.hypot(10.0, 100.00216)
    pull = STIFFNESS / LENGTH * (length - LENGTH)
    half_weight = 1e-3 * LENGTH / 2 * 9.80665
    # rounding of the stretched length, 1e-14 m, times the stiffness of 1e7 N/m, with a margin
    assert force_x == pytest.approx(-pull * 10.0 / length, abs=1e-5)
    assert force_z == pytest.approx(pull * 100.00216 / length - half_weight, abs=1e-5)


def test_force_at_the_end_of_a_step_belongs_to_the_end():
    # the last internal stage of RK2 lies 5 ms before; the pull changes by 1e7 N/m · 1 m/s · 5 ms
    lines = system(ROPE + "solver: {scheme: RK2}\n")
    lines.start([(0.0, -101.0)], [(0.0, -1.0)])
    lines.advance(0.0, 0.01, [(0.0, -101.0)], [(0.0, -1.0)])
    ((_, force_z),) = lines.force
    lines.close()
    pull = STIFFNESS / LENGTH * (101.01 - LENGTH)
    half_weight = 1e-3 * LENGTH / 2 * 9.80665
    # half of the vanishing last part, 5e-12 s, at 1e7 N/s
    assert force_z == pytest.approx(pull - half_weight, abs=1e-4)


def test_the_end_of_a_step_does_not_drift_when_positions_jump():
    lines = system(ROPE)
    lines.start([(0.0, -101.0)], [(0.0, 0.0)])
    lines.advance(0.0, 0.01, [(0.3, -101.0)], [(0.0, 0.5)])
    ((force_x, force_z),) = lines.force
    lines.close()
    x, z = 0.3, -101.0 + 0.005
    length = math.hypot(x, z)
    pull = STIFFNESS / LENGTH * (length - LENGTH)
    assert force_x == pytest.approx(-pull * x / length, abs=0.01)
    assert force_z == pytest.approx(-pull * z / length - 1e-3 * LENGTH / 2 * 9.80665, abs=0.01)


def test_static_start_is_at_rest_and_symmetric():
    lines = chain()
    lines.start(AT, REST)
    before = lines.force
    assert lines.warnings == []
    for k in range(20):
        lines.advance(0.05 * k, 0.05, AT, REST)
    # the equilibrium leaves 1e-6 of the largest tension on a node, which 5 inner nodes pass on
    assert lines.force[0][0] == pytest.approx(before[0][0], rel=1e-5)
    assert before[0][0] < 0 < before[1][0]
    assert before[0][1] < 0
    # the tension of the only line at f1 is the force on the body there
    assert lines.fairlead_tension[0] == pytest.approx(math.hypot(*lines.force[0]), rel=1e-12)
    lines.close()


def test_a_line_that_is_far_too_short_is_told():
    lines = chain(at_rest=False)
    lines.start([(60.0, -3.0), (5.0, -3.0)], REST)
    lines.close()
    told = [text for text in lines.warnings if "beyond its unstretched length" in text]
    assert len(told) == 1
    assert re.search(
        r"ends of l1 are 217\.598 m apart, \d+(\.\d)? % beyond its unstretched length of \d+ m, "
        r"and it pulls \S+ N: check the initial positions",
        told[0],
    )
    assert lines.overstretched() == []  # told already


def test_motions_below_the_smallest_number_are_restored_as_none():
    """MoorDyn would restore 1e-310 m/s as −1e301."""
    lines, place = line_system(SPATIAL), (-5.0, 0.0, -3.0)
    lines.start([place], [(0.0, 0.0, 0.0)])
    lines.advance(0.0, 0.1, [place], [(0.1, 1e-310, 0.0)])
    saved = lines.save()
    lines.advance(0.1, 0.1, [(-4.99, 0.0, -3.0)], [(0.1, 0.0, 0.0)])
    expected = lines.force[0]
    lines.restore(saved)
    lines.advance(0.1, 0.1, [(-4.99, 0.0, -3.0)], [(0.1, 0.0, 0.0)])
    lines.close()
    assert lines.force[0][::2] == expected[::2]
    assert abs(lines.force[0][1]) < 1e-200


def test_a_line_that_becomes_far_too_long_is_told_once():
    lines = system(ROPE)
    lines.start([(0.0, -101.0)], [(0.0, -1000.0)])
    assert lines.warnings[1:] == [
        "the ends of rope are 101 m apart, 0.498 % beyond its unstretched length of 100.5 m, and "
        "it pulls 4.98e+06 N: check the initial positions of its fairleads, and its length"
    ]
    told = []
    for k in range(4):  # 10 m a step: 120.6 m are a fifth more than 100.5 m
        lines.advance(0.01 * k, 0.01, [(0.0, -101.0 - 10.0 * k)], [(0.0, -1000.0)])
        told.append(lines.overstretched())
    lines.close()
    assert [len(texts) for texts in told] == [0, 1, 0, 0]
    # pull: 1e9 N (121 / 100.5 - 1)
    assert told[1] == [
        "the ends of rope are 121 m apart, 20.4 % beyond its unstretched length of 100.5 m, and it "
        "pulls 2.04e+08 N: check its length and stiffness, and the forces on the body"
    ]


@pytest.mark.parametrize(
    ("strain", "told"), [(-0.01, False), (0.0, False), (0.0015, False), (0.003, True), (0.03, True)]
)
def test_a_line_that_starts_stretched_is_told(strain: float, told: bool):
    lines = system(ROPE)
    lines.start([(0.0, -LENGTH * (1 + strain))], [(0.0, 0.0)])
    lines.close()
    beyond = [text for text in lines.warnings if "beyond its unstretched length" in text]
    assert [f" {100 * strain:.3g} % beyond" in text for text in beyond] == [True] * told


SINGLE = """\
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
anchors: {left: [-150, -60]}
fairleads: [f1]
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 85, segments: 6}
"""


@pytest.mark.parametrize(
    ("before", "after", "at", "told"),
    [
        ("", "", (-100.0, -20.0), ""),
        ("", "", (-100.0, -60.005), "l1 is 85 m long, 35 m more than there is room for: 0 m and 0"),
        (
            "",
            "",
            (-100.0, -60.5),
            "f1 starts at z = -60.5 m, 0.5 m below the seabed at -60 m: check the connection, the",
        ),
        (
            "length: 85",
            "length: 100",
            (-100.0, -20.0),
            "l1 is 100 m long, 10 m more than there is room for: 0 m and 40 m from its ends to the "
            "seabed at z = -60 m, and 50 m along it; the rest lies in loops: check its length",
        ),
        (
            "length: 85",
            "length: 163",
            (0.0, 0.0),
            "f1 starts at (0, 0): if it is not connected, connect it",
        ),
        ("[f1]", "{f1: [0, 0]}", (0.0, 0.0), "beyond its unstretched length"),
        ("[f1]", "{f1: [-9, 0]}", (0.0, 0.0), "beyond its unstretched length"),
    ],
)
def test_a_start_that_cannot_be_meant_is_told(before, after, at, told):
    lines = system(SINGLE.replace(before, after))
    lines.start([at], REST[:1])
    lines.close()
    assert len(lines.warnings) == bool(told), lines.warnings
    assert all(told in text for text in lines.warnings)


def test_room_for_a_line_that_floats_is_below_the_surface():
    points = [{"position": place, "force": None} for place in ((0, 0, -60), (50, 0, -20))]
    light = {"ends": (0, 1), "segments": 2, "length": 165.0, "weight": 70.0, "buoyancy": 80.0}
    light |= {"stiffness": 1e6, "bending": 0.0, "diameter": 0.1}
    (text,) = too_long(Net(points, [light], -60.0, 3e6), ["l"])
    assert "35 m more than there is room for: 60 m and 20 m from its ends to the surface" in text


def test_less_may_be_left_on_the_nodes_of_a_finer_line():
    # 1 % of the tension at 20 segments; a node of 1000 segments that is not held leaves less
    assert left_over(["l"], [0.9], [(50.0, 100.0)], [20], "r") == []
    (text,) = left_over(["l"], [0.9], [(50.0, 100.0)], [1000], "start later")
    assert "0.9 N are left on a node while it pulls 100 N" in text
    assert text.endswith(": start later")


DRAWN = [("bow", 30.0, -5.0), ("stern", -30.0, -5.0), ("side", 0.0, -15.0)]
THERE = [(30.0, -5.0), (-30.0, -5.0), (0.0, -15.0)]


@pytest.mark.parametrize(
    ("position", "told"),
    [
        (THERE, []),
        ([(30.009, -5.0), *THERE[1:]], []),
        ([(33.0, -9.0), *THERE[1:]], [("bow", "(33, -9)", "(30, -5)", "5 m away")]),
        # a heave of the whole body by 20 m
        (
            [(x, z + 20) for x, z in THERE],
            [(name, "in the file, 20 m away") for name, _, _ in DRAWN],
        ),
        (
            [THERE[1], THERE[2], THERE[0]],
            [("bow starts at (-30, -5) m and is at (30, -5) m", "to be side, bow, stern")],
        ),
        # near the places of the others
        (
            [(-29.0, -5.0), (31.0, -5.0), (1.0, -15.0)],
            [("order of its coupled points, which seems to be stern, bow, side",)],
        ),
    ],
)
def test_fairleads_elsewhere_than_in_the_file_are_told(position, told):
    texts = misplaced(DRAWN, position, shortest=100.0)
    assert len(texts) == len(told)
    for text, parts in zip(texts, told, strict=True):
        assert all(part in text for part in parts), text


def test_what_moordyn_warns_of_at_the_start_is_told():
    made = mooring(Document.parse(ROPE).validate(MooringConfig))
    text = made.text.replace(" tScheme", " tScheme\n1 unknown\n")
    lines = LineSystem(text, fairleads=[0.0], lines=made.lines, time_step=made.time_step)
    lines.start([(0.0, -100.5)], [(0.0, 0.0)])
    lines.close()
    assert lines.warnings == ["MoorDyn: Warning: Unrecognized option 'unknown'"]


def test_a_saved_state_replays_bitwise_here_and_elsewhere():
    lines = chain()
    lines.start(AT, REST)
    run(lines, 0, 10)
    saved = lines.save()
    expected = run(lines, 10, 15)
    lines.restore(saved)
    assert lines.force == saved["force"]
    assert run(lines, 10, 15) == expected
    other = chain()
    other.restore(saved)
    assert run(other, 10, 15) == expected
    other.close()
    lines.close()


def test_a_state_of_other_lines_is_refused():
    lines = chain(at_rest=False)
    lines.start(AT, REST)
    saved = lines.save()
    with pytest.raises(MooringError, match="not one of these lines"):
        lines.restore(saved | {"system": saved["system"][:-8]})
    lines.close()


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="None is immortal since Python 3.12")
def test_restoring_does_not_consume_none():
    lines = system(ROPE)
    lines.start([(0.0, -101.0)], [(0.0, 0.0)])
    saved = lines.save()
    before = sys.getrefcount(None)
    for _ in range(200):
        lines.restore(saved)
    lost = before - sys.getrefcount(None)
    lines.close()
    assert abs(lost) < 20  # other code holds and drops None too; each call lost one


def test_two_systems_in_one_process_do_not_disturb_each_other():
    alone = chain()
    alone.start(AT, REST)
    expected = run(alone, 0, 10)
    alone.close()
    first, second = chain(), chain()
    first.start(AT, REST)
    second.start([(x + 3, z) for x, z in AT], REST)
    found = []
    for k in range(10):
        second.advance(0.05 * k, 0.05, [(x + 3, z) for x, z in AT], [(0.1, 0.2)] * 2)
        found += run(first, k, 1)
    first.close()
    second.close()
    assert found == expected


def test_nothing_is_written_to_the_console_or_left_on_disk(capfd, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    print("before", flush=True)
    lines = chain()
    lines.start(AT, REST)
    run(lines, 0, 2)
    assert len(list(tmp_path.iterdir())) == (os.name != "posix")  # Windows removes no open file
    lines.start(AT, REST)
    with pytest.raises(MooringError):
        lines.advance(0.0, 0.05, [(math.nan, 0.0)] * 2, REST)
    lines.close()
    print("after", flush=True)
    assert capfd.readouterr() == ("before\nafter\n", "")
    assert list(tmp_path.iterdir()) == []


def test_failures_say_what_when_and_what_to_do():
    lines = chain(at_rest=False)
    lines.start(AT, REST)
    with pytest.raises(MooringError, match=r"t = 0\.5\d* s .*smaller communication step"):
        lines.advance(0.5, 0.05, [(1e9, 0.0), AT[1]], REST)
    lines.close()
    made = mooring(Document.parse(ROPE).validate(MooringConfig))
    wrong = LineSystem(
        made.text.replace("1 rope 1 2", "1 rode 1 2"), fairleads=[0.0], lines=["l"], time_step=1.0
    )
    with pytest.raises(MooringError, match="fairleads at \\(1, -101\\) m") as caught:
        wrong.start([(1.0, -101.0)], [(0.0, 0.0)])
    assert "Unrecognized line type rode" in str(caught.value)
    assert not wrong.running


def test_a_saved_state_is_json_and_bytes():
    lines = chain(at_rest=False)
    lines.start(AT, REST)
    saved = lines.save()
    lines.close()
    assert isinstance(saved.pop("system"), bytes)
    assert json.loads(json.dumps(saved))["motion"]["position"] == [list(p) for p in AT]
