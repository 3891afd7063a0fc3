"""Values of variables over time: arrays that know their names and units, and datasets of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.results.recorded import REAL, Recorded

if TYPE_CHECKING:
    import xarray

SCENE = "scene"
"""The attribute with what an animation shows, which is for programs only."""


class Series(np.ndarray):
    """Values of one variable over time, with its `name`, its `unit` and what it is (`long_name`).

    They are in the type of what was `recorded`: floats, whole numbers (an enumeration's items by
    their numbers), truth values, or objects that are texts.

    NumPy and matplotlib take it as the array it is. A slice and a copy keep name and unit; the
    results of arithmetic and of NumPy's functions, whose units are others, are plain arrays.
    """

    name: str
    unit: str
    long_name: str
    recorded: Recorded

    def __new__(
        cls, name: str, unit: str, long_name: str, values: ArrayLike, recorded: Recorded = REAL
    ) -> Series:
        made = np.asarray(values).view(cls)
        made.name, made.unit, made.long_name, made.recorded = name, unit, long_name, recorded
        return made

    @property
    def values(self) -> np.ndarray:
        """The values (n,) as a plain array that shares memory, in the series' unit."""
        return self.view(np.ndarray)

    def __array_finalize__(self, source: object) -> None:
        self.name = self.unit = self.long_name = ""
        self.recorded = REAL

    def _named_like(self, other: Series) -> Series:
        self.name, self.unit, self.long_name = other.name, other.unit, other.long_name
        self.recorded = other.recorded
        return self

    def __getitem__(self, index: Any) -> Any:
        part = super().__getitem__(index)
        return part._named_like(self) if isinstance(part, Series) else part

    def copy(self, order: Any = "C") -> Series:
        """A copy with name and unit."""
        return super().copy(order)._named_like(self)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if "out" in options:
            options["out"] = tuple(_plain(one) for one in options["out"])
        return getattr(ufunc, method)(*map(_plain, inputs), **options)

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        result = super().__array_function__(func, types, args, kwargs)
        if isinstance(result, tuple) and not hasattr(result, "_fields"):
            return tuple(map(_plain, result))
        return _plain(result)

    def __reduce__(self) -> tuple[type[Series], tuple[object, ...]]:
        return Series, (self.name, self.unit, self.long_name, self.values, self.recorded)

    def __repr__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        head = f"{self.name}{unit}" if self.name else "Series"
        if self.size < 2 or self.ndim != 1:
            return f"{head}: {self.values!r}"
        shown = np.array2string(self.values, threshold=6, edgeitems=3, precision=6)
        return f"{head}: {self.size} values, {shown}"


def _plain(value: object) -> object:
    return value.view(np.ndarray) if isinstance(value, Series) else value


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
    variables = {}
    for name, one in series.items():
        has_flags = not (one.recorded.is_real or one.values.dtype == bool)
        flags = one.recorded.attributes if has_flags else {}
        of_one = {"units": one.unit, "long_name": one.long_name, **flags}
        variables[name] = ("time", one.values, of_one)
    times = ("time", np.asarray(time), {"units": "s", "long_name": "simulated time"})
    return xarray.Dataset(variables, {"time": times}, told)
