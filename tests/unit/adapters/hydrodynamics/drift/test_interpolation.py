"""Mean drift between directions."""

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.drift.interpolation import at_direction, harmonics
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift
from m4e_adapters.hydrodynamics.geometry.motions import SURGE, YAW

OMEGA = np.array([0.5, 1.0])
EVEN, ODD = np.arange(0.0, 360.0, 30.0), np.arange(10.0, 360.0, 40.0)
UNEVEN = np.array([0.0, 15.0, 45.0, 90.0, 135.0, 180.0, 195.0, 240.0, 285.0, 330.0])


def table(directions: np.ndarray, values: np.ndarray) -> MeanDrift:
    return MeanDrift("hull.8", OMEGA, directions, (SURGE, YAW), values)


def at(found: np.ndarray, direction: float) -> np.ndarray:
    """Both motions at both frequencies, (2, 2)."""
    flat = found.reshape(len(OMEGA), -1)
    rows = np.concatenate([np.real(flat), np.imag(flat)], axis=1).tolist()
    return np.array(list(at_direction(found, np.radians(direction), np.zeros(2), rows)))


@pytest.mark.parametrize("directions", [EVEN, ODD, UNEVEN])
def test_the_values_of_a_table(directions: np.ndarray) -> None:
    """Whatever they are, those that change sign from one direction to the next too."""
    values = np.random.default_rng(1).normal(size=(2, len(directions), 2))
    found = harmonics(table(directions, values))
    assert found is not None
    for k, direction in enumerate(directions.tolist()):
        assert at(found, direction) == pytest.approx(values[:, k], abs=1e-9)
        assert at(found, direction - 360.0) == pytest.approx(values[:, k], abs=1e-9)


def test_between_directions() -> None:
    """Cubic splines over 45 deg are off by h⁴/384 of the fourth derivative: 1.6 % of sin 2β."""

    def smooth(beta: np.ndarray) -> np.ndarray:
        return np.stack([np.cos(beta), np.sin(2.0 * beta)], axis=1)

    values = np.tile(smooth(np.radians(UNEVEN)), (2, 1, 1))
    found = harmonics(table(UNEVEN, values))
    assert found is not None
    for direction in (7.0, 30.0, 60.0, 110.0, 300.0, 345.0):
        expected = np.tile(smooth(np.radians([direction])), (2, 1))
        assert at(found, direction) == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize(
    "directions",
    [np.zeros(1), np.arange(0.0, 181.0, 30.0), np.arange(0.0, 360.0, 60.0), np.append(EVEN, 337.0)],
)
def test_directions_that_are_not_all_around(directions: np.ndarray) -> None:
    assert harmonics(table(directions, np.ones((2, len(directions), 2)))) is None
