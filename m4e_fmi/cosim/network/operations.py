"""Operations of a macro step as data, which algorithms list and the C library performs.

They are calls of FMUs, and copies and sums of arrays of exchanged values: float64, or int64 where
they are cells. Each call has one class, with the FMI `function`, and one function in the C library;
`schedule` compiles a list for it. Where an operation writes `into` a block (2-D), it fills one of
its rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.wiring.links import Link
from m4e_fmi.fmu.importer.calls import Access

ROUNDING = 1e-9
"""Share of a component's own step that rounding may change it by."""


@dataclass(frozen=True)
class Due:
    """When an operation is performed that is not part of every macro step.

    That is when the step ends at `origin` plus a multiple of `period`, both in nanoseconds.
    """

    origin: int
    period: int

    def at(self, time: float) -> bool:
        """True if it is performed in a step that ends at `time` [s]."""
        return (round(time * NS_PER_SECOND) - self.origin) % self.period == 0


@dataclass(frozen=True, eq=False)
class Get:
    """Reads the Real variables `names` into a vector or a block's row.

    They must be finite, if it is `checked`. One that is for `in_rows` only is left out of a
    `StepLoop`'s steps that end at no row of results.
    """

    function: ClassVar = "fmi2GetReal"
    instance: Instance
    names: tuple[str, ...]
    into: np.ndarray
    due: Due | None = None
    in_rows: bool = False
    checked: bool = True


@dataclass(frozen=True, eq=False)
class Set:
    """Sets the Real variables `names` to `values`, in the FMU's own units."""

    function: ClassVar = "fmi2SetReal"
    instance: Instance
    names: tuple[str, ...]
    values: np.ndarray
    due: Due | None = None


@dataclass(frozen=True, eq=False)
class SetDerivatives:
    """Gives the one Real input of `names` a time derivative of an `order` during the next piece.

    `values` (1,) holds it, in the FMU's own unit per s or s². One derivative of one input in a call
    is what all FMUs accept that accept any.
    """

    function: ClassVar = "fmi2SetRealInputDerivatives"
    instance: Instance
    names: tuple[str, ...]
    values: np.ndarray
    order: int


@dataclass(frozen=True, eq=False)
class DoStep:
    """Steps the component by a piece: `start` and `length` are shares of the macro step.

    If that is the component's `own` step [s] but for rounding, it is this to the last bit. One that
    is `due` at some points only steps by its own step up to there.
    """

    function: ClassVar = "fmi2DoStep"
    instance: Instance
    start: float = 0.0
    length: float = 1.0
    own: float = 0.0
    due: Due | None = None

    def span(self, time: float, size: float) -> tuple[float, float]:
        """Start and length [s] of the piece, in a macro step of `size` [s] from `time` [s]."""
        if self.due:
            return time + size - self.own, self.own
        length = self.length * size
        whole = abs(length - self.own) < ROUNDING * self.own
        return time + self.start * size, self.own if whole else length


@dataclass(frozen=True, eq=False)
class Save:
    """Keeps the FMU's state where `Instance.save_state` does by default."""

    function: ClassVar = "fmi2GetFMUstate"
    instance: Instance


@dataclass(frozen=True, eq=False)
class Restore:
    """Brings the FMU back to the state that `Save` has kept; it may be restored again."""

    function: ClassVar = "fmi2SetFMUstate"
    instance: Instance


@dataclass(frozen=True, eq=False)
class Combine:
    """``into[i] = Σₖ weight[k, i] · source[index[k, i]] + offset[i]``, a vector or a block's row.

    Every product and every sum is rounded, in the order of the terms. `index` is uint32; it and
    `weight` may change from one macro step to the next, in place.
    """

    into: np.ndarray
    source: np.ndarray
    index: np.ndarray
    weight: np.ndarray
    offset: np.ndarray | None = None
    due: Due | None = None


@dataclass(frozen=True, eq=False)
class Gather:
    """``into[i] = source[index[i]]``, a vector or a block's row, Real or cells; uint32 `index`."""

    into: np.ndarray
    source: np.ndarray
    index: np.ndarray
    due: Due | None = None


@dataclass(frozen=True, eq=False)
class Monitor:
    """``into[0]`` = number of values of `source` (n,) that are rough at once: kinks and jumps.

    See the runtime's loop.c. Fourth differences below `gate` (n,) are not counted.
    `past` (6 n + 1) holds the history of earlier steps, in this order: last value, first, second,
    third difference, level, and largest of the fourth differences; steps to wait.
    """

    into: np.ndarray
    source: np.ndarray
    gate: np.ndarray
    past: np.ndarray


@dataclass(frozen=True, eq=False)
class GetTyped:
    """Reads variables that are not Real into cells (int64), a vector or a block's row."""

    instance: Instance
    access: Access
    into: np.ndarray
    due: Due | None = None
    in_rows: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        return self.access.names


@dataclass(frozen=True, eq=False)
class SetTyped:
    """Sets variables from the `cells` of others that are not Real."""

    instance: Instance
    access: Access
    cells: np.ndarray
    due: Due | None = None


@dataclass(frozen=True, eq=False)
class Choose:
    """``into[i]`` = the reading of output `names[i]` that counts.

    The rows of `readings` (6, n) are, in the outputs' units: the first, straight after the step;
    the second, when inputs were set to the values that they had; the last before the step; that
    with new inputs; the largest first one; and 1 for each output that has been lost [1]. They and
    `into` (n,) are Real, or cells (int64). An output is lost if setting unchanged inputs changes
    it, so that the second is not the first; then the first counts. (Where an FMU's own noise made
    the difference, the first is off by no more than 1/`LOST` of this.) An output that the step has
    left as it was read last is not lost: its FMU shows the step when inputs are set.
    `changed` (1,) [1] becomes 0 where a cell changes. The values that count must be finite, if they
    are `checked`.
    """

    instance: Instance
    names: tuple[str, ...]
    into: np.ndarray
    readings: np.ndarray
    changed: np.ndarray | None = None
    due: Due | None = None
    checked: bool = True


LOST = 0.01
"""An output is lost if setting inputs to the values that they have changes it by more than this
share of what their new values change it by, and 1e-9 of its largest size so far; as in loop.c."""

Reals = Get | Set | SetDerivatives
"""Operations on the Real variables `names` of an FMU."""
Transferring = Get | Set | Combine | Gather | GetTyped | SetTyped | Choose
"""Operations that carry values over at a communication point."""
Operation = (
    Reals | DoStep | Save | Restore | GetTyped | SetTyped | Choose | Combine | Gather | Monitor
)


def gather(into: np.ndarray, source: np.ndarray, places: Sequence[int] | np.ndarray) -> Gather:
    """``into[i] = source[places[i]]``.

    `into` is (n,), or (n_rows, n) of which one row is filled, in the units of `source` (m,), or
    cells of it; `places` (n,) are indices.
    """
    return Gather(into, source, np.array(places, dtype=np.uint32))


def setting(
    instance: Instance, links: Sequence[Link], values: np.ndarray
) -> tuple[Combine | Set, ...]:
    """Sets an instance's inputs from `values` (n_links,) of the links to them, in sources' units.

    Where several links lead to an input, it gets the sum of what they carry.
    """
    factor, offset = instance.scales.of([link.ends for link in links]) or (None, None)
    combined, names, own = _carried(links, values, factor, offset)
    return *combined, Set(instance, names, own)


def setting_derivatives(
    instance: Instance, links: Sequence[Link], values: np.ndarray, order: int
) -> tuple[Combine | SetDerivatives, ...]:
    """Gives inputs the derivatives `values` (n_links,), in their sources' units per s or s²."""
    factor = instance.scales.of_derivatives([link.ends for link in links])
    combined, names, own = _carried(links, values, factor, None)
    each = zip(names, np.split(own, len(names)), strict=True)
    return *combined, *(SetDerivatives(instance, (name,), value, order) for name, value in each)


def _carried(
    links: Sequence[Link],
    values: np.ndarray,
    factor: np.ndarray | None,
    offset: np.ndarray | None,
) -> tuple[list[Combine], tuple[str, ...], np.ndarray]:
    """Scales `values` (n_links,) of links, in sources' units, and adds up those of one input.

    `factor` and `offset` (n_links,) are in the inputs' over the sources' units; None: 1 and 0.
    Returns the operations, the inputs' names, and their values (n_names,).
    """
    found: list[Combine] = []
    if factor is not None:
        index = np.arange(len(links), dtype=np.uint32)[None, :]
        found.append(Combine(np.zeros(len(links)), values, index, factor[None, :], offset))
        values = found[-1].into
    places: dict[str, list[int]] = {}
    for k, link in enumerate(links):
        places.setdefault(link.target.variable, []).append(k)
    if len(places) < len(links):
        shape = max(map(len, places.values())), len(places)
        index, weight = np.zeros(shape, dtype=np.uint32), np.zeros(shape)
        for column, terms in enumerate(places.values()):
            index[:, column] = terms[0]
            index[: len(terms), column] = terms
            weight[: len(terms), column] = 1.0
        found.append(Combine(np.zeros(len(places)), values, index, weight))
        values = found[-1].into
    return found, tuple(places), values
