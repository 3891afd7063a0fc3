"""The static solver by itself: bending, free points, the surface."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_adapters.moordyn.node_forces import submerged
from m4e_adapters.moordyn.statics import Net


def line(**changes: float | tuple[int, int]) -> dict:
    values = {"segments": 10, "length": 100.0, "stiffness": 1e7, "bending": 0.0, "weight": 500.0}
    return {"ends": (0, 1), "buoyancy": 100.0, "diameter": 0.1, **values, **changes}


def held(*places: tuple[float, float, float]) -> list[dict]:
    return [{"position": place, "force": None} for place in places]


def net_of(points: list[dict], lines: list[dict]) -> Net:
    bed = {"bed": -200.0, "bed_stiffness": 3e6}
    return Net({"points": points, "lines": lines, "fairleads": [], **bed})


def test_forces_balance_and_ends_carry_the_weight():
    net = net_of(held((0, 0, -50), (80, 10, -5)), [line()])
    assert net.settle()
    total = net.end_forces()[0].sum(axis=0)
    # 1e-6 of the largest force may be left on each of 9 nodes
    assert total == pytest.approx([0, 0, -(500 - 100) * 100.0], abs=9e-6 * 4e4)


def test_a_stiff_line_sags_as_a_beam():
    # simply supported: 5 q L⁴/(384 EI); 20 segments and a slope of 0.6 % make errors < 1 %
    length, bending, load = 10.0, 1e6, 384 * 1e6 / 5 / 10**4 * 0.02
    stiff = line(
        segments=20, length=length, bending=bending, weight=load, buoyancy=0.0, stiffness=1e6
    )
    net = net_of(held((0, 0, -50), (length, 0, -50)), [stiff])
    assert net.settle()
    sag = -50 - net.position[net.nodes[0][10], 2]
    assert sag == pytest.approx(0.02, rel=0.02)


def test_fine_lines_at_a_free_point_start_from_coarse_ones():
    points = [*held((-50, 0, -10), (50, 0, -10)), {"position": (9, 5, -30), "force": (0, 0, -2e3)}]
    tensions = []
    for segments in (12, 96):
        values = {"length": 70.0, "segments": segments}
        lines = [line(ends=(0, 2), **values), line(ends=(2, 1), **values)]
        net = net_of(points, lines)
        assert net.settle()
        assert net.position[2][:2] == pytest.approx((0, 0), abs=1e-3)
        tensions.append(np.linalg.norm(net.end_forces(), axis=2))
    # second order: (70/12 m)² over the radius of curvature squared, some 100 m, by 24
    assert tensions[0] == pytest.approx(tensions[1], rel=1e-3)
    assert points[2]["position"] == (9, 5, -30)


@pytest.mark.parametrize(
    ("a", "b", "share"),
    [
        (-1.0, -2.0, 1.0),
        (0.0, -2.0, 1.0),
        (1.0, 2.0, 0.0),
        (-1.0, 1.0, 0.5),
        # upright, 3 m of 4 under water; level, with a radius of 0.1 m, MoorDyn tilts the ends
        (-3.0, 1.0, 0.75),
    ],
)
def test_submerged_shares(a: float, b: float, share: float):
    assert submerged(np.array([[0, 0, a], [0, 0, b]]), 0.1) == pytest.approx(share)
