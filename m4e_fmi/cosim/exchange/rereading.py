"""Outputs that are read twice: straight after a step, and when new inputs are set.

So are those of FMUs not built here that depend on connected inputs. Some FMUs lose outputs when
anything is set, until the next step. No trial before the run can tell which do, as the loss may
begin at any time. So straight after the step the outputs are read, their inputs are set to the
values that they have, and the outputs are read again: one that has changed is lost (`Choose`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.exchange.operations import Choose, Gather, Get, GetTyped, gather

ROWS = 6
"""Readings of an output: see `Choose`."""
Reading = Get | GetTyped
Read = Callable[[str, Sequence[str], np.ndarray], Reading]
"""Component, names, place (n_names,) → the operation that reads these, in their units or cells."""


@dataclass(frozen=True)
class Rereading:
    """Outputs `names` of a component, with their readings in `block` (6, n), in their units.

    `kept` keeps what was read last, `first` then reads all straight after a step, and `second` when
    inputs are set to the values that they have.
    """

    names: tuple[str, ...]
    block: np.ndarray
    kept: Gather
    first: Reading
    second: Reading

    def new(
        self, reading: Reading, changed: np.ndarray | None = None
    ) -> tuple[Reading | Choose, ...]:
        """A `reading` of consecutive ones with new inputs, and the choice of what counts instead.

        `changed` (1,) [1] is that of `Choose`.
        """
        block = self.part(reading.names)
        made = reading.instance, reading.names, reading.into, block, changed, reading.due
        if isinstance(reading, GetTyped):
            return replace(reading, into=block[3]), Choose(*made)
        return replace(reading, into=block[3], checked=False), Choose(*made, reading.checked)

    def part(self, names: Sequence[str]) -> np.ndarray:
        """The readings (6, n_names) of consecutive ones, in their units."""
        start = self.names.index(names[0])
        return self.block[:, start : start + len(names)]

    @property
    def lost(self) -> list[str]:
        """The outputs that were lost in at least one step."""
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
            kept = gather(block[2], block[3], range(len(own)))
            both = (read(component, own, row) for row in block[:2])
            found[component] = Rereading(own, block, kept, *both)
    return found
