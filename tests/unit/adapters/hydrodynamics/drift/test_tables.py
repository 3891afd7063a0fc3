"""QTFs as sums of squares, and mean drift between directions."""

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.drift.factors import LEFT_OUT, factorised
from m4e_adapters.hydrodynamics.drift.interpolation import at_direction, harmonics
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift
from m4e_adapters.hydrodynamics.geometry.motions import SURGE, YAW

KNOTS = np.linspace(0.3, 1.8, 31)


def smooth() -> np.ndarray:
    """Drift that changes its sign, with a phase that grows with the difference of frequencies."""
    mean = 4e4 * np.outer(KNOTS, KNOTS) * np.cos(1.5 * np.add.outer(KNOTS, KNOTS))
    away = np.subtract.outer(KNOTS, KNOTS)
    return mean * np.exp(-(away**2)) * np.exp(0.8j * away)


def test_what_is_left_out_is_small() -> None:
    qtf = smooth()
    found = factorised(qtf)
    assert 3 < len(found.values) < 15
    assert np.linalg.norm(found.matrix - qtf) < 3 * LEFT_OUT * np.linalg.norm(qtf)
    assert np.allclose(factorised(qtf, 1e-12).matrix, qtf, rtol=1e-9, atol=1e-6)


def test_small_rows_count_as_large_ones() -> None:
    """A QTF whose first half is a hundred times smaller keeps its accuracy there."""
    scale = np.where(KNOTS < 1.0, 0.01, 1.0)
    qtf = smooth() * np.outer(scale, scale)
    half = KNOTS < 1.0
    found = factorised(qtf).matrix
    part, own = qtf[np.ix_(half, half)], found[np.ix_(half, half)]
    assert np.linalg.norm(own - part) < 5 * LEFT_OUT * np.linalg.norm(part)


def test_a_geometric_mean_has_one_factor() -> None:
    drift = np.linspace(1.0, 3.0, 31)
    found = factorised(np.sqrt(np.outer(drift, drift)).astype(complex))
    assert len(found.values) == 1
    assert np.real(np.diagonal(found.matrix)) == pytest.approx(drift)
    assert len(factorised(np.zeros((4, 4), dtype=complex)).values) == 0


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
