"""Calls that tell the progress of a run."""

from __future__ import annotations

import time as clock
from collections.abc import Callable

Progress = Callable[[float], None]
"""Called now and then with the simulated time [s]."""

PROGRESS_INTERVAL = 0.1
"""Wall seconds between calls of a progress callable."""


def ticker(progress: Progress | None) -> Callable[[float], None]:
    """A callable of the simulated time that calls `progress` ten times a second."""
    if progress is None:
        return lambda _: None
    last = clock.perf_counter()

    def tick(time: float) -> None:
        nonlocal last
        wall = clock.perf_counter()
        if wall - last >= PROGRESS_INTERVAL:
            last = wall
            progress(time)

    return tick
