"""A progress bar over the runs of a study."""

from __future__ import annotations

import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from typing import NoReturn

from m4e_fmi.study.run import Progress

_FORMAT = "{percentage:3.0f} % |{bar:30}| {n_fmt} of {total_fmt} runs, {remaining} left{postfix}"


@contextmanager
def runs_bar() -> Generator[Progress | None]:
    """A callable to be told the runs that are done and all; None where there is no terminal.

    The time left is by the rate of the runs made here, without those that were kept. No study ends
    because the standard error takes nothing.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    bar: tqdm[NoReturn] | None = None

    def show(done: int, total: int) -> None:
        nonlocal bar
        with suppress(OSError):
            if bar is None:
                bar = tqdm(total=total, initial=done, bar_format=_FORMAT, mininterval=0.1)
            bar.update(done - bar.n)

    try:
        yield show
    finally:
        if bar is not None:
            with suppress(OSError):
                bar.close()
