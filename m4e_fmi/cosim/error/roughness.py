"""Kinks and jumps of the exchanged outputs, found in every step at little cost.

The estimate of the coupling error rests on parts of a run that are repeated. It holds for the
rest as long as the outputs are as smooth there. This is watched in all steps by fourth differences:
of a smooth motion they are of the order H⁴, of one with a kink in its k-th derivative of the order
H^k.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Monitor
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.cosim.stepping.algorithm import BLOCK

HISTORY = 4
"""Steps before one that its fourth difference looks at."""
STEPS = 5
"""Steps before a fourth difference has a level for comparison."""
ROUNDING = 2e-14
"""Share of the largest value of a unit that a fourth difference may be by rounding."""
_NONE = np.zeros(0, dtype=np.intp)


class Roughness(Restorable):
    """Watches all exchanged outputs of `network` (n,), while `operation` follows each step.

    The steps are of equal size; after any other `forget` is to be called.
    """

    restored = ("_past", "gate")

    def __init__(self, network: Network) -> None:
        count = len(network.outputs)
        self._flags = np.zeros((BLOCK, 1))
        self._past = np.zeros(6 * count + 1)
        self.gate = np.zeros(count)
        source = network.values[network.now : network.now + count]
        self.operation = Monitor(self._flags, source, self.gate, self._past)
        self._source = source
        self.largest = self._past[5 * count : 6 * count]
        """Largest fourth difference of each output since it was set to 0."""
        self.forget()

    def forget(self) -> None:
        """Compare the next steps with none before this one."""
        self._past[-1] = STEPS

    def sudden(self, row: int, steps: int, *, same: bool, jumped: bool) -> np.ndarray:
        """Suddenly rough steps (k,) of so many, as indices from 0.

        They are noted from a row on. The last does not count if it has `jumped`, nor the first
        few if they are not of the `same` size as those before.
        """
        first, end = (0 if same else STEPS), steps - jumped
        if end <= first or (steps == 1 and not self._flags[row, 0]):
            return _NONE
        return first + np.flatnonzero(self._flags[row + first : row + end, 0])
