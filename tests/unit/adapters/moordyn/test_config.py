"""What a mooring section may say: each mistake is one problem, at its place, with a remedy."""

import pytest

from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_adapters.moordyn.stability import Segment, stable_step
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document

GOOD = """\
water: {density: 1025, depth: 200}
line_types:
  chain:
    diameter: 0.1
    mass_per_length: 150
    axial_stiffness: 1.0e+9
    axial_damping_ratio: 1
    drag_coefficient: 1.2
    added_mass_coefficient: 1
anchors:
  a1: [0, -200]
fairleads: [f1]
lines:
  l1: {type: chain, from: a1, to: f1, unstretched_length: 460, segments: 10}
"""


def problems(text: str) -> list[Problem]:
    with pytest.raises(InputError) as caught:
        mooring(Document.parse(text).validate(MooringConfig))
    return caught.value.problems


def test_a_good_section_is_accepted():
    made = mooring(Document.parse(GOOD).validate(MooringConfig))
    assert [f.name for f in made.fairleads] == ["f1"]
    assert made.lines == ("l1",)


@pytest.mark.parametrize(
    ("before", "after", "line", "message", "remedy"),
    [
        ("type: chain", "type: chian", 14, "no line type 'chian'", "did you mean 'chain'?"),
        ("to: f1", "to: f2", 14, "no fairlead 'f2'", "known fairleads: f1"),
        ("from: a1", "from: a2", 14, "no anchor or fairlead 'a2'", "known points: a1, f1"),
        ("from: a1", "from: f1", 14, "begins and ends at 'f1'", "begin at an anchor"),
        ("segments: 10", "segments: 0", 14, "greater than or equal to 1", ""),
        ("segments: 10", "segments: 2.5", 14, "integer", ""),
        ("length: 460", "length: -1.1", 14, "greater than 0", ""),
        ("length: 460", "length: .inf", 14, "finite", ""),
        ("segments: 10}", "segment: 10}", 14, "unknown key 'segment'", "did you mean 'segments'?"),
        ("diameter: 0.1", "diameter: 0", 4, "greater than 0", ""),
        ("a1: [0, -200]", "a1: [0, -201]", 11, "below the seabed", "z >= -200"),
        ("[f1]", "{f1: [9, -201]}", 12, "'f1' at z = -201 m lies below the seabed", "z >= -200"),
        ("mass_per_length: 150", "mass_per_length: 1e300", 5, "less than or equal to", ""),
        ("mass_per_length: 150", "mass_per_length: 1e-300", 0, "internal steps of 0 s", "SI units"),
        ("a1: [0, -200]", "f1: [0, -200]", 11, "also the name of a fairlead", "another name"),
        ("[f1]", "[f1, f1]", 12, "f1 is listed twice", "its name"),
        ("[f1]", "[f1, f2]", 13, "no line ends at fairlead 'f2'", "remove the fairlead"),
        ("[f1]", "[f 1]", 12, "match pattern", ""),
        (
            "[f1]",
            "[f1]\nwaves: {spectrum: regular, height: 1, period: 8, direction: 90}",
            13,
            "wave direction 90 deg leaves the X-Z plane",
            "dimensions: 3",
        ),
        ("[f1]", "[f1]\nwaves: {spectrum: regular, height: 1}", 13, "missing", ""),
        ("[f1]", "[f1]\nwaves: nothing", 13, "", ""),
        ("axial_damping_ratio: 1", "axial_damping: -1", 7, "greater than or equal to 0", ""),
        (
            "axial_damping_ratio: 1",
            "axial_damping_ratio: 1\n    axial_damping: 1",
            3,
            "damping must be given in one way",
            "drop one of",
        ),
        (
            "    axial_damping_ratio: 1\n",
            "",
            3,
            "damping must be given in one way",
            "axial_damping_ratio: 1.0",
        ),
        ("water: {density: 1025, depth: 200}\n", "", 0, "needs 'water'", "MoorDyn file"),
        ("water:", "file: x.txt\nwater:", 0, "cannot be combined", "without 'file'"),
    ],
)
def test_a_mistake_is_one_problem_with_a_remedy(before, after, line, message, remedy):
    assert before in GOOD
    found = problems(GOOD.replace(before, after))
    matching = [p for p in found if message in p.message]
    assert len(matching) == 1
    assert remedy in matching[0].remedy
    assert matching[0].line == line


def test_all_mistakes_are_told_at_once():
    text = GOOD.replace("type: chain", "type: chian").replace("to: f1", "to: f2")
    messages = " ".join(p.message for p in problems(text))
    assert "'chian'" in messages
    assert "'f2'" in messages


@pytest.mark.parametrize("scheme", ["RK2", "RK4"])
def test_an_unstable_time_step_is_refused_and_the_chosen_one_is_stable(scheme):
    # ω = (2/46 m) √(1e9/150) = 112 rad/s alone would allow 2/ω = 0.018 s with RK2; the seabed's
    # damper, cBot d/m' = 200 1/s, allows about half of that
    found = problems(GOOD + f"solver: {{scheme: {scheme}, time_step: 0.02}}\n")
    assert len(found) == 1
    assert "time step 0.02 s is unstable: l1 allows at most" in found[0].message
    assert "chosen" in found[0].remedy
    section = Document.parse(GOOD + f"solver: {{scheme: {scheme}}}\n").validate(MooringConfig)
    made = mooring(section)
    longest = float(found[0].message.split("at most ")[1].split()[0])
    assert 0.5 * longest < made.time_step < longest


def segment(**changes: float) -> Segment:
    values = {
        "length": 10.0,
        "diameter": 0.1,
        "mass_per_length": 100.0,
        "axial_stiffness": 1e8,
        "damping": 0.0,
        "bending_stiffness": 0.0,
        "seabed_stiffness": 0.0,
        "seabed_damping": 0.0,
    }
    return Segment(**(values | changes))


def test_stability_limits_against_the_known_ones():
    # ω = (2/10) √(1e8/100) = 200 rad/s; RK4 is stable on the negative real axis up to 2.7853, RK2
    # up to 2 (Hairer & Wanner, Solving ODEs II, IV.2). Between the imaginary axis (2√2) and there
    # RK4's boundary comes as near as 2.62, which further damping may reach.
    # The search steps by 1/400 of the mode; the growth it lets pass moves the limits by < 0.5 %.
    critical = 10 * (1e8 * 100) ** 0.5
    assert stable_step(segment(), "RK4") * 200 == pytest.approx(2.62, rel=0.005)
    # slack segments have the damper without the spring: 2ζω = 400 1/s
    assert stable_step(segment(damping=critical), "RK4") * 400 == pytest.approx(2.7853, rel=0.005)
    assert stable_step(segment(damping=critical), "RK2") * 400 == pytest.approx(2.0, rel=0.005)
    # without damping RK2 grows by (ω dt)^4/8 a step: 0.0001 at ω dt = 0.1682, found to 1/400
    assert stable_step(segment(), "RK2") * 200 == pytest.approx(0.1682, abs=1 / 400)
    # a damper of the seabed alone: rate cBot d/m' = 400 1/s, far above its spring's √(kBot d/m')
    seabed = segment(seabed_stiffness=1.0, seabed_damping=4e5)
    assert stable_step(seabed, "RK4") * 400 == pytest.approx(2.7853, rel=0.005)
