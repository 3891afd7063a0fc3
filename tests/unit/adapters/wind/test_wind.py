"""Wind on points: force by hand, profile, energy."""

from __future__ import annotations

import math

import pytest
from support.programs import Evaluated

from m4e_adapters.wind import WindConfig, wind_program
from m4e_fmi.files.document import Document

SPACE = """\
dimensions: 3
speed: 14
direction: 30
exponent: 0.14
points: {mast: {area: 25, coefficient: 1.1, at: [0, 0, 12]}}
"""


def forces(text: str, **inputs: float) -> list[float]:
    program = wind_program(Document.parse(text).validate(WindConfig), name="wind")
    given = {name.replace("_", ".", 1): value for name, value in inputs.items()}
    return list(Evaluated(program).outputs(given).values())


def test_force_by_hand() -> None:
    speed, beta = 14 * 1.2**0.14, math.radians(30)
    w = [speed * math.cos(beta) - 1.0, speed * math.sin(beta) + 2.0, -0.5]
    size = math.hypot(*w)
    expected = [0.5 * 1.225 * 25 * 1.1 * size * value for value in w]
    assert forces(SPACE, mast_vx=1.0, mast_vy=-2.0, mast_vz=0.5) == pytest.approx(expected)
    low = forces(SPACE, mast_z=-3.0)
    assert math.hypot(*low) == pytest.approx(0.5 * 1.225 * 27.5 * (14 * 0.1**0.14) ** 2)


def test_wind_in_the_plane_blows_where_it_is_said_to() -> None:
    plane = SPACE.replace("3\n", "2\n", 1).replace("30", "180").replace("[0, 0, 12]", "[0, 12]")
    force = forces(plane.replace("exponent: 0.14\n", ""), wind_speed=10.0)
    assert force == pytest.approx([-0.5 * 1.225 * 27.5 * 100, 0.0])
    calm = forces(plane.replace("14", "0", 1), mast_vx=2.0, mast_vz=-1.0)
    assert calm[0] * 2.0 - calm[1] * 1.0 < 0.0  # takes energy
    assert forces(plane.replace("14", "0", 1)) == [0.0, 0.0]
