"""Chunks of ensembles: their sizes, and threads that nobody waits for."""

from __future__ import annotations

import signal
import threading
import time

import numpy as np
import pytest

from m4e_fmi.study.programs.chunks import LONG, MOST, Pace, chunks, in_threads


@pytest.mark.parametrize(
    ("runs", "each", "expected"),
    [
        (24, 10.0, [8, 8, 8]),  # few are for all threads
        (5000, 1e-5, [8, 16, 32, 64, 128, 256, MOST, MOST]),
        (1000, LONG / 50, [8, 16, 32, 48, 48]),  # none lasts longer than it should
    ],
)
def test_chunks_grow_up_to_a_duration(runs: int, each: float, expected: list[int]) -> None:
    """Of runs that take `each` seconds, by two threads."""
    pace, found, done = Pace(2), list[int](), list[int]()
    for make in chunks(np.arange(runs), pace, lambda part: part):
        part = make()
        done += part.tolist()
        found.append(len(part))
        pace.took(len(part), each * len(part))
    assert done == list(range(runs))
    assert found[: len(expected)] == expected


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
