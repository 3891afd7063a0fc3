"""QTFs as sums of squares, and mean drift between directions."""

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.drift.recording import LEFT_OUT, at_direction, factorised, harmonics
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift
from m4e_adapters.hydrodynamics.geometry.motions import SURGE, YAW

KNOTS = np.linspace(0.3, 1.8, 31)


def smooth() -> np.ndarray:
    """Drift that changes its sign, with a phase that grows with the difference of frequencies."""
    mean = 4e4 * np.outer(KNOTS, KNOTS) * np.cos(1.5 * np.add.outer(KNOTS, KNOTS))
    away = np.subtract.outer(KNOTS, KNOTS)
    return mean * np.exp(-(away**2)) * np.exp(0.8j * away)


def test_small_rows_count_as_large_ones() -> None:
    """A QTF whose first half is a hundred times smaller keeps its accuracy there."""
    scale = np.where(KNOTS < 1.0, 0.01, 1.0)
    qtf = smooth() * np.outer(scale, scale)
    half = KNOTS < 1.0
    factors = factorised(qtf)
    found = (factors.shapes * factors.values) @ factors.shapes.conj().T
    part, own = qtf[np.ix_(half, half)], found[np.ix_(half, half)]
    assert np.linalg.norm(own - part) < 5 * LEFT_OUT * np.linalg.norm(part)


OMEGA = np.array([0.5, 1.0])
EVEN, ODD = np.arange(0.0, 360.0, 30.0), np.arange(10.0, 360.0, 40.0)


def table(directions: np.ndarray, values: np.ndarray) -> MeanDrift:
    return MeanDrift("hull.8", OMEGA, directions, (SURGE, YAW), values)


def at(found: np.ndarray, direction: float) -> np.ndarray:
    """Both motions at both frequencies, (2, 2)."""
    flat = found.reshape(len(OMEGA), -1)
    rows = np.concatenate([np.real(flat), np.imag(flat)], axis=1).tolist()
    return np.array(list(at_direction(found, np.radians(direction), np.zeros(2), rows)))


@pytest.mark.parametrize("directions", [EVEN, ODD])
def test_the_values_of_a_table(directions: np.ndarray) -> None:
    """Whatever they are, those that change sign from one direction to the next too."""
    values = np.random.default_rng(1).normal(size=(2, len(directions), 2))
    found = harmonics(table(directions, values))
    assert found is not None
    for k, direction in enumerate(directions.tolist()):
        assert at(found, direction) == pytest.approx(values[:, k], abs=1e-9)
        assert at(found, direction - 360.0) == pytest.approx(values[:, k], abs=1e-9)
