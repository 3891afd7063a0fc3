"""Start positions of lines against their static equilibrium by another formulation.

Both have the same number of segments: what is judged is the start, not the division of the line
(test_mooring_catenary.py judges that).
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest
from support.lines_in_waves import lines_of
from support.static_lines import Line, random_line, start_error, tension

from m4e_adapters.moordyn import MooringConfig, mooring, ready_mooring
from m4e_fmi.files.document import Document

# MoorDyn's stationary solver leaves it at 2.2 kN
LIGHT = Line(
    span=516.0,
    low=-400.0,
    high=0.0,
    depth=400.0,
    length=696.4,
    diameter=0.137,
    mass=17.0,
    stiffness=1.5e8,
    segments=8,
)

# of so many segments a line laid out straight seemed to be nearly at rest, and was not found
FINE = Line(
    span=20.2,
    low=-78.4,
    high=-1.8,
    depth=78.4,
    length=87.1,
    diameter=0.1113,
    mass=12.23,
    stiffness=7.5e6,
    segments=320,
)


@pytest.mark.verifies(
    "tension of a line of 320 segments at the start",
    independent="complementary energy",
    tolerance="1e-4",
)
def test_a_line_of_many_segments_starts_at_the_tension_of_its_equilibrium():
    error, warned = start_error(FINE)
    # the seabed yields by 20 N/m / (3e6 Pa/m · 0.11 m) = 0.06 mm of 77 m; 1e-6 of the weight of
    # the line may be left over its nodes
    assert abs(error) < 1e-4
    assert not warned


@pytest.mark.verifies(
    "tension of random lines at the start", independent="complementary energy", tolerance="2e-3"
)
def test_lines_start_at_the_tension_of_their_equilibrium():
    rng = np.random.default_rng(7)
    lines = [LIGHT, *(random_line(rng) for _ in range(12))]
    for line in lines:
        error, warned = start_error(line)
        # the reference's seabed is rigid, and all of its line in the water: 1e-3 of LIGHT's top
        # segment is above (its diameter over its length), 17 % of its weight in water
        assert abs(error) < 2e-3, line
        assert not warned


def test_a_line_that_is_not_laid_to_rest_is_told_with_both_tensions():
    text = LIGHT.text + "static_equilibrium: false\n"
    made = mooring(Document.parse(text).validate(MooringConfig))
    lines = lines_of(made)
    lines.start([(516.0, 0.0)], [(0.0, 0.0)])
    lines.close()
    (warning,) = lines.warnings
    now, rest = lines.tensions()[0][0], tension(LIGHT)
    assert f"it pulls {now:.4g} N at its fairlead, {13500:.4g} N in its static" in warning
    assert now < 0.2 * rest
    assert rest == pytest.approx(13500, rel=2e-3)


def test_what_moordyn_leaves_is_told_where_the_equilibrium_is_not_found(monkeypatch):
    monkeypatch.setattr("m4e_adapters.moordyn.statics.Net.settle", lambda _: False)
    made = mooring(Document.parse(LIGHT.text).validate(MooringConfig))
    rest = tension(LIGHT)
    # MoorDyn relaxes it for as long as the file says: this long, and hardly at all
    for text, accuracy in ((made.text, 0.02), (made.text.replace("200.0 tmaxic", "1 tmaxic"), 0.9)):
        lines = lines_of(replace(made, text=text))
        lines.start([(516.0, 0.0)], [(0.0, 0.0)])
        lines.close()
        (told,) = [text for text in lines.warnings if "equilibrium was not found" in text]
        assert lines.tensions()[0][0] == pytest.approx(rest, rel=accuracy)
        assert (f"{lines.tensions()[0][0]:.4g} N" in told) == (accuracy > 0.1)
        assert ("lines start in MoorDyn's own solution" in told) == (accuracy < 0.1)


BUOY = """\
a buoy on a line under water, below a fairlead on a coupled body
----- LINE TYPES -----
name d m EA BA EI Cd Ca CdAx CaAx
- - - - - - - - - -
rope 0.1 20 2e7 -0.8 0 1.2 1 0.1 0
----- BODIES -----
id type x y z r p y m cg i v cda ca
- - - - - - - - - - - - - -
1 Coupled 2 0 -5 0 30 0 0 0 0 0 0 0
----- POINTS -----
id type x y z m v cda ca
- - - - - - - - -
1 Fixed -60 1 -80 0 0 0 0
2 Free -20 1 -12 800 4 0 0
3 Body1 -2 1 0 0 0 0 0
----- LINES -----
id type a b length n out
- - - - - - -
1 rope 1 2 75 8 -
2 rope 2 3 40 6 p
----- OPTIONS -----
80 WtrDpth
1000 rho
10 g
-----
"""


def test_a_ready_file_with_a_buoy_starts_at_rest(tmp_path):
    path = tmp_path / "lines.txt"
    path.write_text(BUOY)
    made = ready_mooring(path, fairleads={})
    (fairlead,) = made.fairleads
    # the body is pitched by 30°: bow down, about +Y, which turns +Z towards +X
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    assert (fairlead.x, fairlead.y, fairlead.z) == pytest.approx((2 - 2 * c, 1, -5 + 2 * s))
    lines = lines_of(made)
    at, rest = [(fairlead.x, fairlead.z)], [(0.0, 0.0)]
    lines.start(at, rest)
    assert lines.warnings == []
    before = [*chain(*lines.tensions())]
    (force,) = lines.force
    # what the buoy lifts, less the weight of both lines, hangs on anchor and fairlead
    weight = 115 * (20 - 1000 * math.pi * 0.01 / 4) * 10
    lift = (4 * 1000 - 800) * 10
    anchor = before[1]
    down = lift - weight - force[1]
    assert anchor**2 == pytest.approx(force[0] ** 2 + down**2, rel=1e-4)
    for k in range(20):
        lines.advance(0.5 * k, 0.5, at, rest)
    after = [*chain(*lines.tensions())]
    lines.close()
    assert after == pytest.approx(before, rel=1e-4)
