"""Outputs that are read twice: straight after a step, and when new inputs are set.

So are those of FMUs not built here that depend on connected inputs. Some FMUs lose outputs when
anything is set, until the next step; whether one does, no trial before the run can tell, as it may
begin at any time. So straight after the step the outputs are read, their inputs are set to the
values that they have, and the outputs are read again: one that has changed is lost (`choose`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.exchange.operations import Choose, Get, GetTyped

ROWS = 6
"""Readings of an output: see `choose`."""
Reader = Callable[[Sequence[str], np.ndarray], Get | GetTyped]
"""The operation that reads variables of an instance into a vector (n,), in their units or cells."""


@dataclass(frozen=True)
class Rereading:
    """Outputs `names` of a component, with their readings in `block` (6, n), in their units.

    `get` reads some of them.
    """

    names: tuple[str, ...]
    block: np.ndarray
    get: Reader

    def first(self) -> Get | GetTyped:
        """Reads all straight after a step."""
        return self.get(self.names, self.block[0])

    def second(self) -> Get | GetTyped:
        """Reads all again, when inputs are set to the values that they have."""
        return self.get(self.names, self.block[1])

    def new(
        self,
        names: Sequence[str],
        into: np.ndarray,
        *,
        keeps: bool,
        changed: np.ndarray | None = None,
    ) -> tuple[Get | GetTyped | Choose, ...]:
        """Reads consecutive ones with new inputs, and chooses what counts `into` (n_names,).

        These are in the outputs' units; `keeps` is true at a communication point; `changed`
        (1,) [1] as of `Choose`.
        """
        block = self.part(names)
        return self.get(names, block[3]), Choose(block, into, changed, keeps)

    def part(self, names: Sequence[str]) -> np.ndarray:
        """The readings (6, n_names) of consecutive ones, in their units."""
        start = self.names.index(names[0])
        return self.block[:, start : start + len(names)]

    @property
    def lost(self) -> list[str]:
        """The outputs that have been lost so far."""
        return [name for name, lost in zip(self.names, self.block[-1], strict=True) if lost]
