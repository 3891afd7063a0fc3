"""Moorings at rest beside published values and catenaries: stiffness, offsets, broken lines."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.catenaries import suspended, touching

import m4e_fmi
from m4e_fmi.analysis.mooring_data import MooringData

EXAMPLE = Path(__file__).parents[2] / "examples" / "oc3_hywind" / "system.yaml"
LINES = """\
name: spread
components:
  lines:
    kind: mooring
    dimensions: 3
    water: {density: 1025, depth: 200}
    line_types:
      chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+9, axial_damping_ratio: 1,
              drag_coefficient: 1.2, added_mass_coefficient: 1}
    anchors: {west: [-700, 0, -200], east: [700, 0, -200]}
    fairleads: {left: [-10, 0, 0], right: [10, 0, 0]}
    lines:
      l: {type: chain, from: west, to: left, unstretched_length: 750, segments: 60}
      r: {type: chain, from: east, to: right, unstretched_length: 750, segments: 60}
connections: []
simulation: {stop_time: 1, step_size: 0.1}
"""


@pytest.fixture(scope="module")
def oc3(tmp_path_factory: pytest.TempPathFactory) -> MooringData:
    folder = tmp_path_factory.mktemp("oc3")
    text = EXAMPLE.read_text("utf-8")
    text = text.replace("fairleads: [f1, f2, f3]", "fairleads: {f1: [5.2, 0, -70], "
                        "f2: [-2.6, 4.50333, -70], f3: [-2.6, -4.50333, -70]}")  # fmt: skip
    lines = text[text.index("  mooring:\n") : text.index("connections:")]
    end = "simulation: {stop_time: 1, step_size: 0.2}\n"
    path = folder / "system.yaml"
    path.write_text(f"name: oc3\ncomponents:\n{lines}connections: []\n{end}", encoding="utf-8")
    return m4e_fmi.mooring(path, about=(0, 0, 0))


@pytest.mark.verifies(
    "stiffness of a mooring about a point",
    published="J. Jonkman, NREL/TP-500-47535 (2010), Eq. 5-2, 5-3",
    tolerance="1 % of the diagonal",
)
def test_force_and_stiffness_of_oc3(oc3: MooringData) -> None:
    """About the middle of the waterplane; 20 segments a line, the publication has catenaries."""
    published = np.diag([41180.0, 41180.0, 11940.0, 311.1e6, 311.1e6, 11.56e6])
    published[[0, 4, 1, 3], [4, 0, 3, 1]] = -2.821e6, -2.816e6, 2.821e6, 2.816e6
    scale = np.sqrt(np.outer(published.diagonal(), published.diagonal()))
    assert (np.abs(oc3.stiffness - published) / scale).max() < 0.01
    assert oc3.force[:3] == pytest.approx([0.0, 0.0, -1607e3], rel=1e-3, abs=100.0)
    assert [line.on_bed for line in oc3.lines] == pytest.approx([135.3] * 3, abs=902.2 / 20)


def test_offsets_of_oc3_follow_its_stiffness(oc3: MooringData) -> None:
    """A node that touches down changes the stiffness by what one of 20 segments weighs in it."""
    for curve in oc3.curves:
        slope = curve.pull[1] / curve.offsets[1]
        assert slope == pytest.approx(oc3.stiffness[0, 0], rel=1 / 20)
        assert curve.limit == "taut"
        assert (np.diff(curve.tensions.max(axis=1)) > 0.0).all()


def test_without_a_line_two_others_hang_opposite_each_other(oc3: MooringData) -> None:
    """The pull of three cancels; two cancel where fairleads are in the middle between anchors."""
    one, *_ = oc3.broken
    assert one.drift == pytest.approx([-426.935 + 2.6, 0.0], abs=1.0)
    assert one.tensions[0] == 0.0
    assert one.tensions[1] == pytest.approx(one.tensions[2], rel=1e-3)


@pytest.mark.verifies(
    "pull of a mooring by its offset", published="Irvine (1981); Jonkman (2007), Eq. 2-37",
    tolerance="1e-3",
)  # fmt: skip
def test_offsets_are_those_of_catenaries(tmp_path: Path) -> None:
    """60 segments: an error of second order, (12.5 m)² over 24 times the radius of curvature²."""
    path = tmp_path / "spread.yaml"
    path.write_text(LINES, encoding="utf-8")
    data = m4e_fmi.mooring(path, directions=[0.0])
    (curve,) = data.curves
    for offset, pull in list(zip(curve.offsets, curve.pull, strict=True))[:20:4]:
        (left, _), (right, _) = (touching(690.0 + s * offset, 750.0) for s in (1.0, -1.0))
        largest = touching(690.0 + offset, 750.0)
        assert pull == pytest.approx(left - right, abs=1e-3 * math.hypot(*largest))


@pytest.mark.verifies(
    "stiffness of a mooring of suspended lines",
    published="Irvine (1981); Jonkman (2007), Eq. 2-35",
    tolerance="1e-3",
)
def test_stiffness_of_suspended_lines_is_that_of_catenaries(tmp_path: Path) -> None:
    """60 segments of 7.7 m; where nodes touch down, stiffness is of first order in their length."""
    path = tmp_path / "spread.yaml"
    path.write_text(LINES.replace("700", "410").replace("750", "460"), encoding="utf-8")
    data, h = m4e_fmi.mooring(path, directions=[0.0]), 0.01
    ahead, behind = (np.array(suspended(400.0 + s * h, 460.0)) for s in (1.0, -1.0))
    (pull, _), (slope, _) = (ahead + behind) / 2, (ahead - behind) / (2 * h)
    assert data.stiffness[0, 0] == pytest.approx(2 * slope, rel=1e-3)
    assert data.stiffness[1, 1] == pytest.approx(2 * pull / 400.0, rel=1e-3)
