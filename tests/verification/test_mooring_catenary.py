"""End forces of a hanging line against the analytic elastic catenary.

Source: Irvine, Cable Structures (1981), chapter 2, in the form of Jonkman, NREL/TP-500-41958
(2007), equations 2-35 (suspended) and 2-37 (part on a frictionless seabed).
"""

import math

import pytest
from support.catenaries import WEIGHT, suspended, touching
from support.lines_in_waves import lines_of

from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_fmi.files.document import Document

TEXT = """\
water: {{density: 1025, depth: 200}}
line_types:
  chain: {{diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+9, axial_damping_ratio: 1,
           drag_coefficient: 1.2, added_mass_coefficient: 1, axial_drag_coefficient: 0.4}}
anchors: {{a: [0, -200]}}
fairleads: {{f: [{span}, 0]}}
lines:
  l: {{type: chain, from: a, to: f, unstretched_length: {length}, segments: {segments}}}
"""


def computed(span: float, length: float, segments: int) -> LineSystem:
    text = TEXT.format(span=span, length=length, segments=segments)
    made = mooring(Document.parse(text).validate(MooringConfig))
    lines = lines_of(made)
    lines.start([(span, 0.0)], [(0.0, 0.0)])
    lines.close()
    return lines


@pytest.mark.verifies(
    "end forces of a suspended line",
    published="Irvine (1981); Jonkman (2007), Eq. 2-35",
    tolerance="2e-3",
)
def test_a_suspended_line_converges_with_second_order():
    h, v = suspended(400.0, 460.0)
    errors = []
    for segments in (5, 10, 20):
        lines = computed(400.0, 460.0, segments)
        ((x, z),) = lines.force
        anchor = math.hypot(h, v - WEIGHT * 460.0)
        errors.append(
            (
                -x / h - 1,
                -z / v - 1,
                lines.tensions()[0][0] / math.hypot(h, v) - 1,
                lines.tensions()[0][1] / anchor - 1,
            )
        )
    coarse, middle, fine = errors
    for a, b, c in zip(coarse, middle, fine, strict=True):
        # second order: 4 per doubling; what the static solution leaves and the fourth-order term,
        # (1/5)² of the error or less, move the ratio by less than 5 %
        assert a / b == pytest.approx(4, rel=0.05)
        assert b / c == pytest.approx(4, rel=0.05)
    # a chain of 20 links of length L/20 in place of the curve: (π/20)²/24 = 0.1 % for half a wave
    assert max(map(abs, fine)) < 2e-3


@pytest.mark.verifies(
    "end forces of a line partly on the seabed",
    published="Jonkman (2007), Eq. 2-37",
    tolerance="4e-3",
)
def test_a_line_on_the_seabed():
    h, v = touching(800.0, 850.0)
    ((x, z),) = computed(800.0, 850.0, 20).force
    # the touch-down point lies anywhere within one of 20 segments: error of the order of the
    # suspended line's with the same segment length, 850/20 m: (42.5/23)² · 0.12 % = 0.4 %
    assert -x == pytest.approx(h, rel=4e-3)
    assert -z == pytest.approx(v, rel=4e-3)
    assert v < WEIGHT * 850.0  # part of it lies on the seabed
