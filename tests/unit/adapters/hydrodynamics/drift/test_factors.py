"""QTFs as sums of squares."""

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.drift.factors import LEFT_OUT, factorised

OMEGA = np.linspace(0.3, 1.8, 31)


def smooth() -> np.ndarray:
    """Drift that changes its sign, with a phase that grows with the difference of frequencies."""
    mean = 4e4 * np.outer(OMEGA, OMEGA) * np.cos(1.5 * np.add.outer(OMEGA, OMEGA))
    away = np.subtract.outer(OMEGA, OMEGA)
    return mean * np.exp(-(away**2)) * np.exp(0.8j * away)


def test_what_is_left_out_is_small() -> None:
    qtf = smooth()
    found = factorised(qtf)
    assert 3 < len(found.values) < 15
    assert np.linalg.norm(found.matrix - qtf) < 3 * LEFT_OUT * np.linalg.norm(qtf)
    assert np.allclose(factorised(qtf, 1e-12).matrix, qtf, rtol=1e-9, atol=1e-6)


def test_small_rows_count_as_large_ones() -> None:
    """A QTF whose first half is a hundred times smaller keeps its accuracy there."""
    scale = np.where(OMEGA < 1.0, 0.01, 1.0)
    qtf = smooth() * np.outer(scale, scale)
    half = OMEGA < 1.0
    found = factorised(qtf).matrix
    part, own = qtf[np.ix_(half, half)], found[np.ix_(half, half)]
    assert np.linalg.norm(own - part) < 5 * LEFT_OUT * np.linalg.norm(part)


def test_a_geometric_mean_has_one_factor() -> None:
    drift = np.linspace(1.0, 3.0, 31)
    found = factorised(np.sqrt(np.outer(drift, drift)).astype(complex))
    assert len(found.values) == 1
    assert np.real(np.diagonal(found.matrix)) == pytest.approx(drift)


def test_nothing() -> None:
    found = factorised(np.zeros((4, 4), dtype=complex))
    assert len(found.values) == 0
    assert not found.matrix.any()
