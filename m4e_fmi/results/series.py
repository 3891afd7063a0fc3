"""Values of variables over time: arrays that know their names and units, and datasets of them.

How variables of each type lie in netCDF files:

====================  =========================================================================
Real                  f8
Integer               of its own width: i1, i2, i4, i8, u1, u2, u4, u8
Boolean               i1, 0 or 1; flag_values 0 1, flag_meanings "false true"
Enumeration           i4 or i8; flag_values its numbers, flag_meanings its items
String                text of any length
====================  =========================================================================

Flags are those of the CF conventions, section 3.5: blanks in names of items become underscores.
The attribute `items` has the numbers of an enumeration by their true names, as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    import xarray


TRUTH = {"false": 0, "true": 1}
TEXT = "str"
"""The kind of texts, in place of a type of NumPy."""
KINDS = (TEXT, *(f"{sign}{size}" for sign in "iu" for size in (1, 2, 4, 8)), "f4", "f8")
"""All kinds of recorded variables."""
SCENE = "scene"
"""The attribute with what an animation shows, which is for programs only."""


@dataclass(frozen=True)
class Recorded:
    """Type of a recorded variable: `type` in FMI's words, `kind` is how it lies in files.

    `items` are the values of an enumeration by their names.
    """

    type: str = "Real"
    kind: str = "f8"
    items: Mapping[str, int] = field(default_factory=dict)

    @property
    def is_real(self) -> bool:
        """True for Reals."""
        return self.type == "Real"

    @property
    def is_text(self) -> bool:
        """True for Strings."""
        return self.kind == TEXT

    @property
    def named(self) -> Mapping[str, int]:
        """Names of values: of an enumeration and of Booleans."""
        return TRUTH if self.type == "Boolean" else self.items

    def text(self, value: str | float) -> str:
        """A value as text: by its name if it has one."""
        if self.is_text:
            return repr(value)
        names = {number: name for name, number in self.named.items()}
        return names.get(int(value), f"{value:g}" if self.is_real else str(value))

    @property
    def attributes(self) -> dict[str, str | np.ndarray]:
        """Attributes of the values in a file; arrays are `flag_values` (n_items,) [1]."""
        items = self.named
        if not items:
            return {}
        return {
            "flag_values": np.array(list(items.values()), dtype=self.kind),
            "flag_meanings": " ".join("_".join(name.split()) for name in items),
            **({"items": json.dumps(dict(self.items))} if self.items else {}),
        }

    def stored(self, cells: np.ndarray, text_at: Callable[[int], str]) -> np.ndarray:
        """Values (n,) in a netCDF-4 file for `cells` (n,), in the variable's unit.

        Cells are int64, see `fmu.importer.calls.access`, but those of Reals. Texts are found by
        their places.
        """
        if self.is_real:
            return cells
        if not self.is_text:
            return cells.astype(self.kind)
        known = {place: text_at(place) for place in np.unique(cells).tolist()}
        return np.array([known[place] for place in cells.tolist()], dtype=object)

    def values(self, stored: np.ndarray) -> np.ndarray:
        """The values (n,) of `stored` (n,) in their own type, in the variable's unit.

        Booleans become such, texts objects; numbers stay.
        """
        if self.type == "Boolean":
            return stored.astype(bool)
        return stored.astype(object) if self.is_text else stored


REAL = Recorded()


def recorded_as(file_type: type[str] | np.dtype, attributes: Mapping[str, ArrayLike]) -> Recorded:
    """The type of a variable that is a `file_type` (of netCDF4) in a file, with these `attributes`.

    Of `attributes` the arrays are `flag_values` (n_items,) [1].
    """
    if "type" in attributes:  # of a file of rows
        kind, items = str(attributes["kind"]), json.loads(str(attributes["items"]))
        if kind not in KINDS:
            raise ValueError("its header names an unknown type")
        return Recorded(str(attributes["type"]), kind, dict(items))
    if file_type is str:
        return Recorded("String", TEXT)
    kind = np.dtype(file_type).str[1:]
    if kind[0] == "f":
        return Recorded("Real", kind)
    if "items" in attributes:
        return Recorded("Enumeration", kind, json.loads(str(attributes["items"])))
    if "flag_meanings" not in attributes:
        return Recorded("Integer", kind)
    names = str(attributes["flag_meanings"]).split()
    numbers = np.atleast_1d(attributes["flag_values"]).tolist()
    items = dict(zip(names, numbers, strict=False))
    return Recorded("Boolean", kind) if items == TRUTH else Recorded("Enumeration", kind, items)


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
