"""The energy that a connection exchanges: the scale of what the coupling invents or loses."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from m4e_fmi.cosim import Bond, BondEnergy, Link, Network, Port
from m4e_fmi.cosim.time_loop.energy import EnergyBalance
from m4e_fmi.cosim.wiring.links import BondAxis

A, OMEGA, STIFFNESS, DAMPING = 0.7, 1.3, 2e5, 3e4
PERIOD = 2 * np.pi / OMEGA


def link(source: str, target: str) -> Link:
    return Link(Port("line", source), Port("body", target), 0)


def balance(
    times: np.ndarray, force: np.ndarray, speed: np.ndarray, place: np.ndarray
) -> BondEnergy:
    """The balance of a bond of one direction with these courses; held forces are their means.

    The force follows a course through its values.
    """
    names = ("force_x", "vx", "x")
    links = [link(name, name) for name in names]
    index = {k.source: row for row, k in enumerate(links)}
    network = SimpleNamespace(
        values=np.zeros(3),
        place=links.index,
        index=index.__getitem__,
        to_si=lambda _: 1.0,
    )
    courses = np.column_stack((force, speed, place))
    network.values[:] = courses[0]
    axis = BondAxis(links[0], links[1], links[2])
    energy = EnergyBalance(cast("Network", network), (Bond("b", (axis,)),), np.ones(3))
    for k in range(1, len(times)):
        network.values[:] = courses[k]
        held = np.array([(force[k - 1] + force[k]) / 2, 0.0, 0.0])
        energy.add(held, times[k] - times[k - 1])
    (found,) = energy.result()
    return found


def oscillation(periods: int, steps: int) -> tuple[np.ndarray, ...]:
    """Times, x = A cos(wt) and its rate."""
    times = np.linspace(0.0, periods * PERIOD, periods * steps + 1)
    return times, A * np.cos(OMEGA * times), -A * OMEGA * np.sin(OMEGA * times)


@pytest.mark.parametrize("preload", [0.0, 1e6, -1e8])
@pytest.mark.parametrize("periods", [2, 60])
def test_a_spring_exchanges_its_potential_whatever_the_preload(
    preload: float, periods: int
) -> None:
    times, x, v = oscillation(periods, 400)  # up to 24 blocks of 1024 steps
    found = balance(times, preload - STIFFNESS * x, v, x + 5.0)
    # trapezoids of a harmonic power of angular frequency 2 w: (2 w h)²/12, w h = 2 pi/400
    assert found.exchanged == pytest.approx(STIFFNESS * A**2 / 2, rel=(4 * np.pi / 400) ** 2)


def test_a_body_that_is_towed_takes_the_work_of_the_mean_force() -> None:
    times = np.linspace(0.0, 100.0, 4001)
    found = balance(times, np.full(times.size, 50.0), np.full(times.size, 3.0), 3.0 * times)
    assert found.exchanged == pytest.approx(50.0 * 300.0)


@pytest.mark.parametrize("amplitude", [1e-6, 1.0])
def test_errors_of_a_displacement_count_without_the_preload(amplitude: float) -> None:
    """A velocity that is wrong by 1e-5 is no energy of a preload of 10 kN, however small all is."""
    times, x, v = oscillation(2, 400)
    part = times <= 1.7 * PERIOD
    times, x, v = times[part], amplitude * x[part], amplitude * v[part]
    found = balance(times, 1e4 - STIFFNESS * x, (1 + 1e-5) * v, x)
    assert abs(found.relative) < 3e-5  # that of the spring, and of the trapezoids


def test_rounding_noise_of_a_body_at_rest_has_no_share() -> None:
    times = np.linspace(0.0, 10.0, 101)
    noise = 1e-15 * np.sin(40 * times)
    found = balance(times, 4e6 + 1e5 * noise, noise, noise)
    assert found.is_idle
    assert found.relative == 0.0
    _, x, v = oscillation(2, 100)
    assert not balance(np.linspace(0.0, 2 * PERIOD, x.size), 1e3 - x, 1e-6 * v, 1e-6 * x).is_idle


def test_integrals_are_of_fourth_order() -> None:
    errors = []
    for steps in (20, 40):
        times, x, v = oscillation(1, steps)
        part = times <= 0.8 * PERIOD + 1e-9  # not a whole period, over which trapezoids are exact
        times, x, v = times[part], x[part], v[part]
        found = balance(times, -DAMPING * v, v, x)
        phase = OMEGA * times[-1]
        exact = -DAMPING * A**2 * OMEGA * (phase / 2 - np.sin(2 * phase) / 4)
        errors.append(abs(found.given / exact - 1))
    assert errors[1] < 2e-5  # trapezoids: 5e-4
    assert errors[0] > 10 * errors[1]


def test_a_jump_between_points_that_are_next_to_one_another() -> None:
    """A ball that bounces: the velocity changes its sign within a nanosecond."""
    times = np.concatenate((np.arange(11) * 0.1, 1.0 + 1e-9 + np.arange(11) * 0.1))
    v = np.concatenate((np.full(11, -1.0), np.full(11, 1.0)))
    x = np.cumsum(np.concatenate(([1.0], np.diff(times) * v[1:])))
    found = balance(times, np.full(22, 3.0), v, x)
    assert found.given == pytest.approx(0.0, abs=1e-8)
    assert found.residual == pytest.approx(0.0, abs=1e-8)
