"""Conditions under which an FMU runs in a process of its own."""

from __future__ import annotations

from dataclasses import dataclass

CALL = 600.0
"""Seconds that a call of an FMU may take."""
END = 30.0
"""Seconds that terminating or freeing an FMU may take."""


@dataclass(frozen=True)
class Host:
    """Limits of a worker, and what it knows of the user's environment.

    `call` is the time [s] that instantiating, initialising, a step and all other calls may take
    each, `end` that for terminating and freeing; `memory` the address space [bytes], None for no
    limit; `keep` are the names of further variables of the environment that the FMU gets.
    """

    call: float = CALL
    end: float = END
    memory: int | None = None
    keep: tuple[str, ...] = ()
