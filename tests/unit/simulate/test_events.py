"""Events of simulations, and steps that end at the kinks of tables, against exact solutions."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.model import Body, Joint, JointEffort, JointStop, Model, Table
from m4e_fmi.simulate import Watch, simulate

G, STIFFNESS = 9.81, 1e4
GAP = "load.floor.gap"


def ball() -> Model:
    """1 kg dropped from 1 m onto a spring."""
    joint = Joint("prismatic", "ball", direction=(0.0, 1.0), initial={"q": 1.0})
    return Model(
        "ball",
        {"ball": Body(1.0, 1.0)},
        {"fall": joint},
        loads={"floor": JointStop("fall", STIFFNESS, lower=0.0)},
        gravity=G,
    )


SPEED = np.sqrt(2 * G)
FALL = SPEED / G
# in contact ẍ = −g − ω²x from x = 0 at −SPEED: back at x = 0 after (2π − 2 atan(ω·SPEED/g))/ω
FREQUENCY = np.sqrt(STIFFNESS)
CONTACT = (2 * np.pi - 2 * np.arctan(FREQUENCY * SPEED / G)) / FREQUENCY
PERIOD = 2 * FALL + CONTACT


@pytest.mark.parametrize("method", ["dop853", "rk45", "rodas"])
def test_contacts_of_a_bouncing_ball(method: str) -> None:
    result = simulate(ball(), stop_time=4.0, method=method, tolerance=1e-10, events=[Watch(GAP)])
    exact = [FALL + k * PERIOD + part for k in range(4) for part in (0.0, CONTACT)]
    assert [event.name for event in result.events] == [GAP] * 8
    # steps of 1e-10, across two kinks of the force at each bounce
    assert [event.time for event in result.events] == pytest.approx(exact, abs=1e-6)
    assert [event.states[0] for event in result.events] == pytest.approx([0.0] * 8, abs=1e-6)
    assert result.time[-1] == 4.0


def test_a_terminal_event_ends_the_simulation() -> None:
    events = [Watch("joint.fall.u", 1, terminal=True), Watch(GAP, -1)]
    result = simulate(ball(), stop_time=4.0, tolerance=1e-10, events=events)
    lowest = FALL + CONTACT / 2
    assert [(e.name, e.terminal) for e in result.events] == [(GAP, False), ("joint.fall.u", True)]
    assert result.events[-1].time == pytest.approx(lowest, abs=1e-7)
    assert result.time[-1] == result.events[-1].time
    assert result.time[-2] == pytest.approx(0.46, abs=1e-12)
    assert all(len(values) == len(result.time) for values in result.values.values())
    # the potential energy lost is in the spring: x² ω²/2 = g (1 − x)
    depth = (G + np.sqrt(G * G + 2 * STIFFNESS * G)) / STIFFNESS
    assert result["joint.fall.q"][-1] == pytest.approx(-depth, abs=1e-8)
    assert "watched.joint.fall.u" not in result.values


TIMES = np.arange(0.0, 10.1, 0.25)
FORCES = np.where(np.arange(TIMES.size) % 2, 1.0, -1.0) * np.linspace(1.0, 3.0, TIMES.size)


def driven() -> Model:
    """ẍ = f(t) − 4x, f a zigzag."""
    return Model(
        "driven",
        {"a": Body(1.0, 1.0)},
        {"rail": Joint("prismatic", "a", direction=(1.0, 0.0))},
        loads={"push": JointEffort("rail", "f - 4*joint.rail.q")},
        tables={"f": Table(tuple(TIMES), tuple(FORCES), "N")},
    )


def driven_exactly(times: np.ndarray) -> np.ndarray:
    """x, from row to row of the table: a straight line and a free oscillation at 2 rad/s."""
    x = v = 0.0
    result = np.zeros(times.shape)
    for k in range(TIMES.size - 1):
        start, slope = FORCES[k], (FORCES[k + 1] - FORCES[k]) / (TIMES[k + 1] - TIMES[k])
        cosine, sine = x - start / 4, (v - slope / 4) / 2
        inside = times >= TIMES[k]
        s = times[inside] - TIMES[k]
        line = (start + slope * s) / 4
        result[inside] = cosine * np.cos(2 * s) + sine * np.sin(2 * s) + line
        h = TIMES[k + 1] - TIMES[k]
        x = cosine * np.cos(2 * h) + sine * np.sin(2 * h) + (start + slope * h) / 4
        v = 2 * (sine * np.cos(2 * h) - cosine * np.sin(2 * h)) + slope / 4
    return result


@pytest.mark.parametrize("method", ["dop853", "rk45", "rodas"])
def test_steps_end_at_the_rows_of_tables(method: str) -> None:
    result = simulate(driven(), stop_time=10.0, output_interval=0.7, method=method)
    # each of 40 smooth pieces is off by some 1e-8; across a kink the order would be lost
    assert np.abs(result["joint.rail.q"] - driven_exactly(result.time)).max() < 1e-7
