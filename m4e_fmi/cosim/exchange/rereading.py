"""Outputs that are read twice: straight after a step, and when new inputs are set.

So are those of FMUs not built here that depend on connected inputs. Some FMUs lose outputs when
anything is set, until the next step; whether one does, no trial before the run can tell, as it may
begin at any time. So straight after the step the outputs are read, their inputs are set to the
values that they have, and the outputs are read again: one that has changed is lost (`choose`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.exchange.operations import Choose, Get, GetTyped

ROWS = 6
"""Readings of an output: see `choose`."""
Reading = Get | GetTyped
Read = Callable[[str, Sequence[str], np.ndarray], Reading]
"""Component, names, place (n_names,) → the operation that reads these, in their units or cells."""


@dataclass(frozen=True)
class Rereading:
    """Outputs `names` of a component, with their readings in `block` (6, n), in their units.

    `first` reads all straight after a step, `second` when inputs are set to the values that they
    have.
    """

    names: tuple[str, ...]
    block: np.ndarray
    first: Reading
    second: Reading

    def new(
        self, reading: Reading, *, keeps: bool, changed: np.ndarray | None = None
    ) -> tuple[Reading | Choose, ...]:
        """A `reading` of consecutive ones with new inputs, and the choice of what counts instead.

        `keeps` is true at a communication point; `changed` (1,) [1] as of `Choose`.
        """
        block = self.part(reading.names)
        chosen = Choose(block, reading.into, changed, keeps, reading.due)
        return replace(reading, into=block[3]), chosen

    def part(self, names: Sequence[str]) -> np.ndarray:
        """The readings (6, n_names) of consecutive ones, in their units."""
        start = self.names.index(names[0])
        return self.block[:, start : start + len(names)]

    @property
    def lost(self) -> list[str]:
        """The outputs that have been lost so far."""
        return [name for name, lost in zip(self.names, self.block[-1], strict=True) if lost]


def rereadings(
    names: Mapping[str, tuple[str, ...]], room: np.ndarray, read: Read
) -> dict[str, Rereading]:
    """Those of each component that has outputs among `names`.

    Their readings are in `room` (6*n_names,), in the outputs' units; `read` makes operations that
    read some (n,) of them, in these units.
    """
    found: dict[str, Rereading] = {}
    for component, own in names.items():
        if own:
            block, room = np.split(room, [ROWS * len(own)])
            block = block.reshape(ROWS, -1)
            both = (read(component, own, row) for row in block[:2])
            found[component] = Rereading(own, block, *both)
    return found
