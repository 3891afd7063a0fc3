"""Frequencies of the coefficients, and panels that are coarse for their waves."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from support.hulls import checked_program, configured, hulls

from m4e_adapters.hydrodynamics.build import frequency_table
from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.flow.bem import resolved_frequency, warn_of_coarse_panels
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.panels import grid
from m4e_fmi.errors import InputError, Problem

FLOAT = """\
water: {density: 1025, depth: 50}
bodies:
  float:
    shape: {cylinder: {radius: 4.0, draft: 3.0}}
    center_of_gravity: [0, -1.2]
"""


def frequencies(waves: str, text: str = FLOAT) -> list[float]:
    config = configured(f"{text}waves: {waves}\n")
    return frequency_table(config, hulls(config)).tolist()


def jonswap(period: float) -> str:
    return f"{{spectrum: jonswap, significant_height: 2.0, peak_period: {period}}}"


REGULAR = "{spectrum: regular, height: 1, period: 1.8}"


def test_frequencies_reach_the_waves_and_the_memory() -> None:
    """The memory decides (the disc of the waterplane has the radius 4 m, k a = 4.5); a sea of short
    waves, 2.5 peak frequencies, adds others after these, and changes none."""
    table = frequencies(jonswap(7.0))
    assert table[-1] == pytest.approx(math.sqrt(4.5 * 9.81 / 4.0), rel=1e-9)
    assert frequencies(jonswap(9.0)) == table
    longer = frequencies(jonswap(4.0))
    assert longer[: len(table)] == table
    step = longer[-1] - longer[-2]
    assert step == pytest.approx(2 * (table[1] - table[0]), rel=1e-9)
    assert longer[-1] - step < 2.5 * 2 * math.pi / 4.0 <= longer[-1]
    one = frequencies(REGULAR)
    assert one[: len(longer)] == longer[: len(one)]
    assert one[-1] >= 2 * math.pi / 1.8
    # above k a = 4.5 the force falls as it does for short waves: a table may end before these
    short = f"{jonswap(3.0)}\nfrequencies: {{maximum: 3.4}}"
    assert frequencies(short)[-1] == 3.4


def counted(count: int, **more: float) -> Problem | None:
    """The problem of a cylinder of 60 panels, coarse above 2.03 rad/s, with so many frequencies."""
    shape = {"cylinder": {"radius": 4, "draft": 4}}
    body = {"shape": shape, "center_of_gravity": [0, -0.1], "panels": 60}
    try:
        checked_program({"bodies": {"a": body}, "frequencies": {"count": count, **more}})
    except InputError as error:
        (problem,) = error.problems
        return problem
    return None


@pytest.mark.parametrize("more", [{}, {"maximum": 8.0}, {"minimum": 0.3}])
def test_too_few_frequencies_are_told_with_a_number_that_works(more: dict[str, float]) -> None:
    problem = counted(12, **more)
    assert problem is not None
    assert ("where the panels resolve the waves" in problem.message) == ("maximum" not in more)
    assert ("use more panels" in problem.remedy) == ("maximum" not in more)
    enough = int(re.findall(r"frequencies.count of (\d+)", problem.remedy)[0])
    others = {key: value for key, value in more.items() if key != "minimum"}
    assert counted(enough, **others) is None
    assert counted(enough - 1, **others) is not None


def coarse(needed: float) -> list[str]:
    """Warnings of a barge of 100 m beside a buoy of 1 m, with waves up to `needed` [rad/s]."""
    shapes: dict[str, tuple[float, dict[str, Any]]] = {
        "barge": (0.0, {"box": {"length": 100.0, "width": 60.0, "draft": 20.0}}),
        "buoy": (60.0, {"sphere": {"radius": 1.0, "center_x": 60.0}}),
    }
    bodies = {
        name: {"shape": shape, "center_of_gravity": [x, -0.3], "panels": 400}
        for name, (x, shape) in shapes.items()
    }
    config = configured({"bodies": bodies, "water": {"depth": 300.0}})
    told: list[str] = []
    warn_of_coarse_panels(
        hulls(config), water=config.water, highest=6.6, needed=needed, progress=told.append
    )
    return [text for text in told if "barge" in text]


def test_panels_are_compared_with_the_waves_that_matter_to_their_body() -> None:
    """The barge radiates up to 1.07 rad/s, the buoy to 6.6: that asked for 510,000 panels."""
    assert coarse(0.0) == []
    (text,) = coarse(1.4)
    assert "that matter to it are of 1.4:" in text
    panels = int(re.findall(r"about (\d+)", text)[0])
    assert 300 < panels < 2000
    # of the panels at the limit, w² = g k and 8 radii in a wave: a barge's are alike
    radius, limit = (float(re.findall(rf"{word} ([\d.]+)", text)[0]) for word in ("to", "above"))
    assert radius == pytest.approx(2 * np.pi / 8 * 9.80665 / limit**2, rel=0.01)
    (text,) = coarse(6.6)
    assert "use more panels or a lower frequencies.maximum" in text


@pytest.mark.parametrize(("top", "height"), [(-2.0, 2.0), (-8.0, 0.5)])
def test_tall_panels_far_below_need_not_resolve_short_waves(top: float, height: float) -> None:
    """A ring of panels of 2 m below rings of 0.5 m: in 8 m it feels no wave that it is coarse for.

    Of those that matter the waves are at least eight radii long.
    """
    rings = [top - 2.0, *np.arange(top, 0.1, 0.5)]
    angles = np.linspace(0.0, 2 * math.pi, 25)
    panels = grid(np.array([[[math.cos(a), math.sin(a), z] for z in rings] for a in angles]))
    made = Hull("float", panels, None, (0.0, -1.0), hydrostatics_of(panels))
    shortest = 2 * math.pi * 9.81 / resolved_frequency(made, Water()) ** 2
    width = 2 * math.sin(math.pi / 24)
    assert shortest == pytest.approx(8 * 0.5 * math.hypot(width, height), rel=1e-9)
