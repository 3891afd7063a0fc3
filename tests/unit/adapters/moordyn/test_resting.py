"""Lines at rest: their stiffness is that of differences of equilibria."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from m4e_adapters.moordyn.resting import LinesAtRest

CHAIN = {"length": 310.0, "segments": 20, "stiffness": 1e8, "weight": 1471.0, "buoyancy": 79.0}
ROPE = {"length": 100.0, "segments": 12, "stiffness": 2e6, "weight": 60.0, "buoyancy": 50.0}
CABLE = {**ROPE, "bending": 2e4, "stiffness": 1e7, "weight": 300.0}
BUOY = {"position": (40.0, 5.0, -20.0), "force": (0.0, 0.0, 2e4)}
LOW, HIGH = (0.0, 0.0, -50.0), (280.0, 30.0, -4.0)


def line(ends: tuple[int, int], **values: float) -> dict[str, Any]:
    return {"ends": ends, "bending": 0.0, "diameter": 0.1, **values}


def mooring(lines: list[dict[str, Any]], *held: tuple[float, ...], free: Any = None) -> Any:
    points = [{"position": place, "force": None} for place in held] + ([free] if free else [])
    moved = {"position": (0.0, 0.0, 0.0), "force": None}
    fairleads = [len(points), len(points) + 1]
    bed = {"bed": -50.0, "bed_stiffness": 3e6}
    return {"points": [*points, moved, moved], "fairleads": fairleads, "lines": lines, **bed}


CASES = {
    "chains on the bed": (
        mooring([line((0, 2), **CHAIN), line((1, 3), **CHAIN)], LOW, (560.0, 0.0, -50.0)),
        [HIGH, (285.0, 25.0, -4.0)],
    ),
    "many segments": (
        mooring([line((0, 1), **{**CHAIN, "segments": 90}), line((1, 2), **ROPE)], LOW),
        [HIGH, (350.0, 30.0, -30.0)],
    ),
    "taut ropes": (
        mooring([line((0, 1), **ROPE), line((0, 2), **ROPE)], LOW),
        [(90.0, 20.0, -3.0), (90.0, -20.0, -3.0)],
    ),
    "bending, through the surface": (
        mooring([line((0, 1), **CABLE), line((1, 2), **CABLE)], LOW),
        [(70.0, 0.0, 6.0), (110.0, 40.0, 5.0)],
    ),
    "a buoy": (
        mooring(
            [line((0, 1), **ROPE), line((1, 2), **{**ROPE, "length": 60.0}), line((1, 3), **ROPE)],
            LOW,
            free=BUOY,
        ),
        [(80.0, 0.0, -5.0), (80.0, 60.0, -5.0)],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_stiffness_is_that_of_differences(case: str) -> None:
    """Of central differences over 1 cm, whose error is of second order, some 1e-6."""
    described, places = CASES[case]
    lines, here = LinesAtRest(described), np.array(places)
    found = lines.at(here)
    assert found is not None
    for column in range(6):
        step = np.zeros(6)
        step[column] = 0.01
        ahead, behind = (lines.at(here + s * step.reshape(2, 3)) for s in (1.0, -1.0))
        assert ahead is not None
        assert behind is not None
        for name in ("force", "ends"):
            slopes = getattr(found, f"{name}_slopes" if name == "force" else "end_slopes")
            seen = (getattr(ahead, name) - getattr(behind, name)) / 0.02
            assert slopes[..., column] == pytest.approx(seen, abs=1e-4 * abs(slopes).max())
        for k, slopes in enumerate(found.node_slopes):
            seen = (ahead.nodes[k] - behind.nodes[k]) / 0.02
            assert slopes[..., column] == pytest.approx(seen, abs=1e-4)
    if case == "chains on the bed":
        stiffness = found.force_slopes.reshape(6, 6)
        assert stiffness == pytest.approx(stiffness.T, abs=1e-6 * abs(stiffness).max())
