"""Series over time as a dataset of xarray."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.results.series import Series

if TYPE_CHECKING:
    import xarray

SCENE = "scene"
"""The attribute with what an animation shows, which is for programs only."""


def as_dataset(
    time: np.ndarray, series: Mapping[str, Series], attributes: Mapping[str, str]
) -> xarray.Dataset:
    """A dataset with one variable for each of `series`, over the coordinate `time` (n,) [s].

    The variables have `units` and `long_name`, those of whole numbers with names also
    `flag_values` and `flag_meanings` (CF conventions). They share memory with the series.
    Attributes go along, but for the SCENE.
    """
    import xarray

    told = {name: one for name, one in attributes.items() if name != SCENE}
    variables = {name: ("time", one.values, _attributes(one)) for name, one in series.items()}
    plain = np.asarray(time)
    times = ("time", plain, {"units": "s", "long_name": "simulated time"})
    return xarray.Dataset(variables, {"time": times}, told)


def _attributes(one: Series) -> dict[str, object]:
    flags = {} if one.recorded.is_real or one.values.dtype == bool else one.recorded.attributes
    return {"units": one.unit, "long_name": one.long_name, **flags}
