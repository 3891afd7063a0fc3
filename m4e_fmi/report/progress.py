"""A progress bar over simulated time."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from typing import NoReturn

_FORMAT = "{percentage:3.0f} % |{bar:30}| {n:.1f} of {total:g} s simulated{postfix}"
_INTERVAL = 0.1


def say_beside(line: str) -> None:
    """Print a line on the standard error, if it takes it, above a progress bar if there is one."""
    from tqdm import tqdm

    if sys.stderr is None:
        return
    with suppress(OSError):
        tqdm.write(line, file=sys.stderr)


@contextmanager
def progress_bar(stop_time: float, *, start: float = 0.0) -> Generator[Callable[[float], None]]:
    """A callable to be told the simulated time [s]; shows it and the real-time factor.

    The real-time factor is simulated over elapsed time: above 1, faster than reality. A bar is
    drawn on terminals only. Nothing is shown before the first call: whatever finds
    an error before that tells it alone. No run ends because the standard error takes nothing.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda _: None
        return
    from tqdm import tqdm

    bar: tqdm[NoReturn] | None = None
    began = shown = time.perf_counter()

    def show(t: float) -> None:
        nonlocal bar, shown
        if bar is None:
            bar = tqdm(total=stop_time - start, bar_format=_FORMAT, mininterval=_INTERVAL)
        now = time.perf_counter()
        if now - shown < _INTERVAL and t < stop_time:
            return
        shown = now
        done = t - start
        bar.set_postfix_str(f"{done / (now - began):.1f} × real time", refresh=False)
        bar.update(done - bar.n)

    def show_if_taken(t: float) -> None:
        with suppress(OSError):
            show(t)

    try:
        yield show_if_taken
    finally:
        if bar is not None:
            with suppress(OSError):
                bar.close()
