"""Currents: profiles in numbers and recorded, and refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Current, current_problems
from m4e_adapters.hydrodynamics.seas.water.current import current_velocity, record_current
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Recorder, Variable, evaluated

DEPTH = 30.0
HEIGHTS = [5.0, 0.0, -3.0, -12.0, -29.0, -30.0, -31.0]
PROFILES = {
    "uniform": "{speed: 1.2, direction: 30}",
    "power": "{speed: 1.2, direction: 30, profile: 0.143}",
    "table": "{direction: 30, profile: [[0, 1.2], [-10, 0.7], [-25, -0.1]]}",
}


def current(text: str) -> Current:
    return Document.parse(text).validate(Current)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_recorded_current_is_that_in_numbers(profile: str) -> None:
    given = current(PROFILES[profile])
    recorder = Recorder("water", "a current")
    z = recorder.input(Variable("z", "m", "height"))
    recorded = record_current(recorder, given, depth=DEPTH, in_space=True)
    for axis, value in zip("xy", recorded.velocity(z), strict=True):
        recorder.output(Variable(axis, "m/s", "speed"), value)
    program = recorder.program()
    start = {v.name: v.start for v in program.parameters}
    for height in HEIGHTS:
        found = evaluated(program.tape, list(program.results), {**start, "z": height, "time": 0.0})
        expected = current_velocity(given, height, depth=DEPTH)
        assert [found[k] for k in program.results] == pytest.approx(expected[:2], rel=1e-12)


def test_profiles_by_hand() -> None:
    beta = math.radians(30)
    along = np.array([math.cos(beta), math.sin(beta), 0.0])
    found = current_velocity(current(PROFILES["power"]), [3.0, -15.0], depth=DEPTH)
    assert found == pytest.approx(np.outer([1.2, 1.2 * 0.5**0.143], along))
    found = current_velocity(current(PROFILES["table"]), [-4.0, -28.0], depth=DEPTH)
    assert found == pytest.approx(np.outer([1.0, -0.1], along))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{direction: 30}", "needs a 'speed'"),
        ("{speed: 1, profile: [[0, 1], [-5, 0]]}", "'speed' has no effect"),
        ("{profile: [[0, 1], [0, 2]]}", "two speeds at one z"),
        ("{profile: [[0, 1]]}", "a table of 1 rows"),
        ("{speed: -1}", "speed"),
        ("{speed: 1, profile: shear}", "profile"),
        ("{speed: 1, profile: 2}", "profile"),
    ],
)
def test_wrong_currents_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        current(text)


def test_what_does_not_suit_the_water_is_told() -> None:
    def told(text: str, depth: float, dimensions: int) -> list[str]:
        found = current_problems(current(text), depth=depth, dimensions=dimensions)
        return [message for _, message, _ in found]

    assert "leaves the X-Z plane" in told(PROFILES["uniform"], DEPTH, 2)[0]
    assert "needs a depth" in told(PROFILES["power"], math.inf, 3)[0]
    assert "5 m below the sea bed" in told(PROFILES["table"], 20.0, 3)[0]
    assert told(PROFILES["table"], DEPTH, 3) == []
