"""CPU time, the minimum over many short batches, with the contestants taking turns."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping

from benchmark.engine import Batch

ROUNDS = 30
BATCH = 2e-3  # s
EMPTY_CALLS = 20_000
MOST_CALLS = 100_000
LEAST_SHARE = 0.05  # of what is measured that remains when the overhead is taken off


def fastest(batches: Mapping[str, Batch], *, rounds: int = ROUNDS) -> dict[str, float]:
    """CPU seconds per evaluation of each contestant: the best of `rounds` batches.

    Who begins changes from round to round, so that a disturbance hits all alike.
    """
    names = list(batches)
    calls = {name: _calls(batches[name]) for name in names}
    best = dict.fromkeys(names, float("inf"))
    for k in range(rounds):
        first = k % len(names)
        for name in names[first:] + names[:first]:
            best[name] = min(best[name], batches[name](calls[name]) / calls[name])
    return best


def _calls(batch: Batch) -> int:
    """How many evaluations fill a batch; also warms up."""
    calls = 1
    while (seconds := batch(calls)) < BATCH / 2:
        if calls >= MOST_CALLS:
            return calls
        calls *= 4
    return max(1, round(calls * BATCH / seconds))


def python_batch(function: Callable[[], object], *, overhead: float = 0.0) -> Batch:
    """Batch of a Python callable; `overhead` [s] per call is taken off."""

    def batch(calls: int) -> float:
        began = time.process_time()
        for _ in range(calls):
            function()
        spent = time.process_time() - began
        return max(spent - calls * overhead, LEAST_SHARE * spent)

    return batch


def empty_call(function: Callable[[], object]) -> float:
    """CPU seconds of one call of a function that does nothing, the loop included."""
    batch = python_batch(function)
    return min(batch(EMPTY_CALLS) for _ in range(5)) / EMPTY_CALLS


def cpu_seconds() -> float:
    """CPU time of this process and of its children that have ended (compilers)."""
    spent = os.times()
    return time.process_time() + spent.children_user + spent.children_system
