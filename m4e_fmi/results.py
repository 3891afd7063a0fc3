"""Results files in memory: what runs and simulations have written (netCDF-4).

The dimension and the variable `time` are at the root; each group holds the variables of one
component, or of the one model that was simulated.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Series:
    """One recorded variable: `values` over `Results.time`, its unit and what it is."""

    name: str
    unit: str
    long_name: str
    values: np.ndarray


@dataclass(frozen=True)
class Results:
    """A results file in memory: `time` [s], `components[component][variable]`, the attributes."""

    path: Path
    time: np.ndarray
    components: dict[str, dict[str, Series]]
    attributes: dict[str, str]

    def __getitem__(self, name: str) -> Series:
        """The series ``component.variable``; KeyError if there is none."""
        component, _, variable = name.partition(".")
        return self.components[component][variable]


def load(path: str | Path) -> Results:
    """The results in a file that a run has written."""
    from netCDF4 import Dataset

    with Dataset(Path(path)) as file:
        file.set_auto_mask(False)
        components = {
            component: {
                name: Series(name, variable.units, variable.long_name, variable[:])
                for name, variable in group.variables.items()
            }
            for component, group in file.groups.items()
        }
        attributes = {name: str(file.getncattr(name)) for name in file.ncattrs()}
        return Results(Path(path), file["time"][:], components, attributes)
