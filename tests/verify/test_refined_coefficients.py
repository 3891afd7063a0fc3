"""Convergence studies of bodies with exact solutions, computed anew.

`pytest --update` writes the tables of tests/data/hydrodynamics/refined.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.refined_cases import CASES, computed, stored, write

pytestmark = pytest.mark.verify
ROUNDING = 1e-5  # of tables with 8 digits, and of other machines' sums, over the largest value


@pytest.mark.parametrize("name", CASES)
def test_stored_tables_are_what_is_computed(name: str, request: pytest.FixtureRequest) -> None:
    found = computed(name)
    print(found)
    if request.config.getoption("--update"):
        write(name, found)
    kept = stored(name)
    assert found.panels == kept.panels
    for quantity in ("added_mass", "radiation_damping", "added_mass_inf", "excitation"):
        new, old = getattr(found.limit, quantity), getattr(kept.limit, quantity)
        np.testing.assert_allclose(new, old, atol=ROUNDING * np.abs(old).max())
