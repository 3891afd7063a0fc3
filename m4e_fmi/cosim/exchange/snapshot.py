"""What an object must be given back so that it goes on as from here: its attributes `SNAPSHOT`.

Each class of the time loop names those in which its past lies. They are numbers, arrays, tuples, or
objects that name their own. Arrays get their values back in place, because operations performed in
C hold their addresses.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

Memory = Mapping[str, Any]


def remember(thing: object) -> Memory:
    """Copies of what `thing` names; nothing if it names none."""
    return {name: _copied(getattr(thing, name)) for name in _names(thing)}


def recall(thing: object, memory: Memory) -> None:
    """Give back to `thing` what was remembered of it; the memory can be used again."""
    for name, kept in memory.items():
        present = getattr(thing, name)
        if _names(present):
            recall(present, kept)
        elif isinstance(present, np.ndarray) and np.shape(kept) == present.shape:
            present[...] = kept
        else:
            setattr(thing, name, _copied(kept))


def _names(thing: object) -> tuple[str, ...]:
    return getattr(type(thing), "SNAPSHOT", ())


def _copied(value: Any) -> Any:
    if _names(value):
        return remember(value)
    return value.copy() if isinstance(value, np.ndarray) else value
