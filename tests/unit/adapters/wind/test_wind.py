"""Wind on points: force by hand, profile, energy, refusals."""

from __future__ import annotations

import math

import pytest

from m4e_adapters.wind import WindConfig, wind_program
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program.python_form import load_python

SPACE = """\
dimensions: 3
speed: 14
direction: 30
exponent: 0.14
points: {mast: {area: 25, coefficient: 1.1, at: [0, 0, 12]}}
"""


def forces(text: str, **inputs: float) -> list[float]:
    program = wind_program(Document.parse(text).validate(WindConfig), name="wind")
    form, p = load_python(program), [v.start for v in program.parameters]
    u = [inputs.get(v.name.replace(".", "_"), v.start) for v in program.inputs]
    return list(form.outputs(0.0, [], u, p, form.constants(p)))


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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("dimensions: 3", "dimensions: 2"), "leaves the X-Z plane"),
        (("[0, 0, 12]", "[0, 12]"), "2 coordinates, expected"),
        (("mast:", "wind:"), "is the name of the wind"),
        (("speed: 14", "speed: -1"), "speed"),
        (("area: 25, ", ""), "area"),
    ],
)
def test_wrong_winds_are_refused(change: tuple[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Document.parse(SPACE.replace(*change)).validate(WindConfig)
