"""Chunks of ensembles: their sizes, and threads that nobody waits for."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from m4e_fmi.study.programs.chunks import LONG, MOST, Pace, chunks, in_threads


def sizes(runs: int, jobs: int, each: float) -> list[int]:
    """Sizes of chunks of `runs`, each of which takes `each` seconds."""
    pace, found = Pace(jobs), list[int]()
    parts: Iterator[Callable[[], np.ndarray]] = chunks(np.arange(runs), pace, lambda part: part)
    done = list[int]()
    for make in parts:
        part = make()
        done += part.tolist()
        found.append(len(part))
        pace.took(len(part), each * len(part))
    assert done == list(range(runs))
    return found


def test_few_runs_are_for_all_threads() -> None:
    assert sizes(24, jobs=2, each=10.0) == [8, 8, 8]


def test_short_runs_come_in_chunks_that_grow() -> None:
    assert sizes(5000, jobs=2, each=1e-5)[:8] == [8, 16, 32, 64, 128, 256, MOST, MOST]


def test_chunks_last_no_longer_than_they_should() -> None:
    assert max(sizes(1000, jobs=2, each=LONG / 50)) <= 50


def test_interruption_does_not_wait_for_a_call() -> None:
    go_on = threading.Event()
    calls = [lambda: "first", lambda: go_on.wait(20.0)]
    made = in_threads(iter(calls), 1)
    assert next(made) == "first"
    timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
    began = time.monotonic()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # it may be ignored
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            next(made)
    finally:
        signal.signal(signal.SIGINT, before)
    took = time.monotonic() - began
    go_on.set()
    assert took < 5.0


def test_the_error_of_a_call_is_raised() -> None:
    def fails() -> str:
        raise ValueError("a call failed")

    with pytest.raises(ValueError, match="a call failed"):
        list(in_threads([fails], 2))
    assert sorted(in_threads([lambda k=k: f"{k}" for k in range(9)], 3)) == list("012345678")
