"""Objects that go back to a state that they had: one snapshot and one restore for all."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, ClassVar

import numpy as np

Snapshot = dict[str, Any]
"""Copies of attributes by their names; of one that is `Restorable`, its own snapshot."""


class Restorable:
    """Base of objects whose state are the attributes that `restored` names.

    Arrays are restored in place, because operations may hold their addresses: their shapes stay.
    All values have a form in `files.encoding`: snapshots are written to checkpoints.
    """

    restored: ClassVar[tuple[str, ...]] = ()

    def snapshot(self) -> Snapshot:
        """The state as it is now."""
        values = {name: getattr(self, name) for name in self.restored}
        return {
            name: value.snapshot() if isinstance(value, Restorable) else deepcopy(value)
            for name, value in values.items()
        }

    def restore(self, snapshot: Snapshot) -> None:
        """Continue as from where the snapshot was taken."""
        for name, value in snapshot.items():
            present = getattr(self, name)
            if isinstance(present, Restorable):
                present.restore(value)
            elif isinstance(present, np.ndarray) and isinstance(value, np.ndarray):
                present[...] = value
            else:
                setattr(self, name, deepcopy(value))
