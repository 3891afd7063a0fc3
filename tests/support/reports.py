"""Results made in memory, of a run that never was."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from m4e_fmi.cosim import Results, Series


def results_of(
    time: np.ndarray,
    values: Mapping[str, np.ndarray],
    *,
    units: Mapping[str, str] | None = None,
    attributes: Mapping[str, str] | None = None,
    path: str = "made.nc",
) -> Results:
    """Results with `values` (n,) by ``component.variable`` at `time` (n,) [s], 1 without a unit."""
    components: dict[str, dict[str, Series]] = {}
    for name, one in values.items():
        component, _, variable = name.partition(".")
        unit = (units or {}).get(name, "")
        components.setdefault(component, {})[variable] = Series(
            variable, unit, f"{name}, made", one
        )
    return Results(Path(path), time, components, {"title": "made", **(attributes or {})})
