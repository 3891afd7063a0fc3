"""Warnings of values that can hardly be meant: one line each, with both numbers."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.lines_in_waves import ROPE, line_system, mooring_of, started

from m4e_adapters.moordyn import MooringConfig, ready_mooring
from m4e_adapters.moordyn.placement import misplaced
from m4e_adapters.moordyn.rest import too_long
from m4e_adapters.moordyn.statics import Net
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
STILL = [(0.0, 0.0)]


def warnings(text: str) -> list[str]:
    """Those told when the FMU is made, and those of the start."""
    told = list[str]()
    config = Document.parse(text).validate(MooringConfig)
    make(config, name="mooring", folder=Path(), progress=told.append)
    lines = started(mooring_of(text))
    lines.close()
    return [*(line for line in told if line.startswith("warning")), *lines.warnings]


def test_plausible_lines_start_without_a_word() -> None:
    assert warnings(LINES) == []


@pytest.mark.parametrize(
    ("before", "after", "parts"),
    [
        ("depth: 200", "depth: 400", ["anchor a", "z = -200 m, 200 m above the seabed at -400 m"]),
        ("[-610, -200]", "[-610, 20]", ["anchor a is fixed above the water at z = 20 m"]),
        ("length: 150", "length: 0.15", ["1.471 N/m", " 78.95 N/m", "0.1 m"]),
        ("stiffness: 1.0e+9", "stiffness: 1.0e+6", ["% at the start, where it", "1e+06 N"]),
        ("length: 150", "length: 0.15", ["internal steps a second", "MoorDyn makes"]),
        ("stiffness: 1.0e+9", "stiffness: 1.0e+6", ["by its own weight", "44.5 %", "not kN"]),
        ("[-10, -10]", "[-10, 14]", ["fairlead f starts at z = 14 m, above the water"]),
        ("segments: 20", "segments: 1", ["weighs 4.455e+05 N", "pulls 4.455e+05 N", "than 1 "]),
    ],
)
def test_what_can_hardly_be_meant_is_told(before: str, after: str, parts: list[str]) -> None:
    assert before in LINES
    (found,) = (text for text in warnings(LINES.replace(before, after)) if parts[0] in text)
    assert all(part in found for part in parts)


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
BEYOND = "beyond its unstretched length"


@pytest.mark.parametrize(
    ("length", "fairlead", "at", "told"),
    [
        (85, "[f1]", (-100.0, -20.0), ""),
        (85, "[f1]", (-100.0, -60.005), "l1 is 85 m long, 35 m more than there is room for: 0 m"),
        (85, "[f1]", (-100.0, -60.5), "f1 starts at z = -60.5 m, 0.5 m below the seabed at -60 m"),
        (100, "[f1]", (-100.0, -20.0), "10 m more than there is room for: 0 m and 40 m from its"),
        (163, "[f1]", (0.0, 0.0), "f1 starts at (0, 0): if it is not connected, connect it"),
        (85, "{f1: [0, 0]}", (0.0, 0.0), BEYOND),
        (85, "{f1: [-9, 0]}", (0.0, 0.0), BEYOND),
    ],
)
def test_a_start_that_cannot_be_meant_is_told(
    length: float, fairlead: str, at: tuple[float, float], told: str
) -> None:
    text = SINGLE.replace("length: 85", f"length: {length}").replace("[f1]", fairlead)
    lines = line_system(text)
    lines.start([at], STILL)
    lines.close()
    assert len(lines.warnings) == bool(told), lines.warnings
    assert all(told in text for text in lines.warnings)


@pytest.mark.parametrize(
    ("strain", "told"), [(-0.01, False), (0.0015, False), (0.003, True), (0.03, True)]
)
def test_a_line_that_starts_stretched_is_told(strain: float, told: bool) -> None:
    lines = line_system(ROPE)
    lines.start([(0.0, -100.5 * (1 + strain))], STILL)
    lines.close()
    beyond = [text for text in lines.warnings if BEYOND in text]
    assert [f" {100 * strain:.3g} % beyond" in text for text in beyond] == [True] * told


def test_a_line_that_becomes_far_too_long_is_told_once() -> None:
    lines = line_system(ROPE)
    lines.start([(0.0, -101.0)], [(0.0, -1000.0)])
    told = []
    for k in range(4):  # 10 m a step: 120.6 m are a fifth more than 100.5 m
        lines.advance(0.01 * k, 0.01, [(0.0, -101.0 - 10.0 * k)], [(0.0, -1000.0)])
        told.append(lines.overstretched())
    lines.close()
    assert [len(texts) for texts in told] == [0, 1, 0, 0]
    # pull: 1e9 N (121 / 100.5 - 1)
    assert "121 m apart, 20.4 % beyond its unstretched length of 100.5 m" in told[1][0]
    assert "pulls 2.04e+08 N" in told[1][0]


def floating(length: float, *ends: tuple[float, float, float]) -> list[str]:
    """Doubts about a line lighter than water between two places above a bed at -60 m."""
    points = [{"position": place, "force": None} for place in ends]
    line = {"ends": (0, 1), "segments": 2, "length": length, "weight": 70.0, "buoyancy": 80.0}
    line |= {"stiffness": 1e6, "bending": 0.0, "diameter": 0.1}
    return too_long(Net(points, [line], -60.0, 3e6), ["l"])


def test_room_for_a_line_that_floats_is_up_or_down_to_the_surface() -> None:
    (text,) = floating(165.0, (0, 0, -60), (50, 0, -20))
    assert "35 m more than there is room for: 60 m and 20 m from its ends to the surface" in text
    assert floating(50.0, (0, 0, 3), (47, 0, 3)) == []
    (text,) = floating(54.0, (0, 0, 3), (47, 0, 3))
    assert "1 m more than there is room for" in text


DRAWN = [("bow", 30.0, -5.0), ("stern", -30.0, -5.0), ("side", 0.0, -15.0)]
THERE = [(30.0, -5.0), (-30.0, -5.0), (0.0, -15.0)]


@pytest.mark.parametrize(
    ("position", "told"),
    [
        ([(30.009, -5.0), *THERE[1:]], []),
        ([(33.0, -9.0), *THERE[1:]], [("bow", "(33, -9)", "(30, -5)", "5 m away")]),
        # a heave of the whole body by 20 m
        ([(x, z + 20) for x, z in THERE], [(n, "in the file, 20 m away") for n, _, _ in DRAWN]),
        (
            [THERE[1], THERE[2], THERE[0]],
            [("bow starts at (-30, -5) m and is at (30, -5) m", "to be side, bow, stern")],
        ),
        # near the places of the others
        ([(-29.0, -5.0), (31.0, -5.0), (1.0, -15.0)], [("seems to be stern, bow, side",)]),
    ],
)
def test_fairleads_elsewhere_than_in_the_file_are_told(position: list, told: list) -> None:
    texts = misplaced(DRAWN, position, shortest=100.0)
    assert len(texts) == len(told)
    for text, parts in zip(texts, told, strict=True):
        assert all(part in text for part in parts), text


def test_a_buoy_above_the_water_is_told_at_the_start_and_when_it_rises() -> None:
    path = Path(__file__).parents[3] / "data" / "moordyn" / "buoy_between_lines.txt"
    lines = started(ready_mooring(path, fairleads={}))
    (told,) = lines.warnings
    assert "free point 2 is at z = +11.2 m, above the water" in told
    assert "its buoyancy of 4.021e+05 N is not reduced" in told  # 1025 kg/m³ · 9.80665 · 40 m³
    assert lines.surfaced() == []
    lines.start([(100.0, -150.0)], STILL)  # pulled below
    assert not any("above the water" in text for text in lines.warnings)
    for k in range(40):
        lines.advance(0.5 * k, 0.5, [(100.0, -150.0 + 3.5 * k)], [(0.0, 7.0)])
    for k in range(40, 80):
        lines.advance(0.5 * k, 0.5, [(100.0, -10.0)], STILL)
    assert len(lines.surfaced()) == 1
    assert lines.surfaced() == []
    lines.close()
