"""Convergence studies of bodies with exact solutions, computed anew.

`pytest --update` writes the tables of tests/data/hydrodynamics/refined.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.refined_cases import CASES, computed, stored, write

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, refinement

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


def test_a_study_from_a_configuration() -> None:
    body = {"shape": {"box": {"length": 8, "width": 6, "draft": 3}}, "panels": 432}
    config = HydrodynamicsConfig.model_validate(
        {
            "bodies": {"float": {**body, "center_of_gravity": [0, -1]}},
            "frequencies": {"minimum": 0.4, "maximum": 1.2, "count": 12},
        }
    )
    told: list[str] = []
    found = refinement(config, folder=Path(), progress=told.append)
    print(found)
    assert found.panels == (48, 192, 432)
    assert [f"mesh of {n} panels" for n in found.panels] == [t for t in told if "mesh of" in t]
    for heave in (found.added_mass, found.added_mass_inf):
        assert 0 < heave.remaining[1, 1] < heave.error[1, 1] < 0.05 * heave.scale[1, 1]
