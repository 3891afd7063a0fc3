"""Progress bars, over simulated time and over runs."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from typing import NoReturn

_FORMAT = "{percentage:3.0f} % |{bar:30}| {n:.1f} of {total:g} s simulated{postfix}"
_RUNS = "{percentage:3.0f} % |{bar:30}| {n_fmt} of {total_fmt} runs, {remaining} left{postfix}"
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
    began = shown = time.perf_counter()

    with _bar(_FORMAT) as bar:

        def show(t: float) -> None:
            nonlocal shown
            now = time.perf_counter()
            if bar is None or (now - shown < _INTERVAL and t < stop_time):
                return
            shown = now
            done = t - start
            bar(done, stop_time - start, f"{done / (now - began):.1f} × real time")

        yield show


@contextmanager
def runs_bar() -> Generator[Callable[[int, int], None] | None]:
    """A callable to be told the runs that are done and all; None where there is no terminal.

    The time left is by the rate of the runs made here, without those that were kept.
    """
    with _bar(_RUNS) as bar:
        yield bar


@contextmanager
def _bar(form: str) -> Generator[Callable[..., None] | None]:
    """A callable to be told what is done, of all, and a text: a bar; None without a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    bar: tqdm[NoReturn] | None = None

    def show(done: float, total: float, text: str = "") -> None:
        nonlocal bar
        with suppress(OSError):
            if bar is None:
                bar = tqdm(total=total, initial=done, bar_format=form, mininterval=_INTERVAL)
            bar.set_postfix_str(text, refresh=False)
            bar.update(done - bar.n)

    try:
        yield show
    finally:
        if bar is not None:
            with suppress(OSError):
                bar.close()
