"""Changes of a mean that something holds at rest."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.analysis.response.linear_equations import Held
from m4e_fmi.errors import RunError

SPRING = np.array([[0.0, 1.0, 0.0, 0.0], [-4.0, -0.3, 0.0, 0.0], [0, 0, 0, 1.0], [0, 0, 0, -0.2]])
"""Place and velocity of a body on a spring, and of one that nothing holds in place."""


def test_a_mean_moves_where_it_is_held_only() -> None:
    step = Held.by(SPRING).step(SPRING, np.array([0.0, 2.0, 0.0, 0.0]))
    np.testing.assert_allclose(step, [0.5, 0.0, 0.0, 0.0], atol=1e-15)


def test_a_mean_that_a_sea_sets_free_is_told() -> None:
    """Its step is not zero: the mean would pass for settled."""
    free = SPRING.copy()
    free[1, 0] = 0.0
    with pytest.raises(RunError, match="does not hold it in this sea"):
        Held.by(SPRING).step(free, np.array([0.0, 2.0, 0.0, 0.0]))
