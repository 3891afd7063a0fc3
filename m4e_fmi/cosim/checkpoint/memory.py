"""The memory of a run beside its state, as another process must have it."""

from __future__ import annotations

from m4e_fmi.cosim.checkpoint.state import Memory
from m4e_fmi.cosim.exchange.fmu_log import Journal, Warn
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.monitoring.instability import Stability
from m4e_fmi.cosim.results.writer import ResultsWriter


def memory(
    network: Network, journal: Journal, stability: Stability, results: ResultsWriter | None
) -> Memory:
    """All that these remember."""
    warned = {name: instance.warned for name, instance in network.instances.items()}
    return Memory(
        {name: (one.count, one.first, one.last) for name, one in warned.items()},
        journal.snapshot(),
        stability.snapshot(),
        results.snapshot() if results else (),
    )


def remember(
    kept: Memory,
    network: Network,
    journal: Journal,
    stability: Stability,
    results: ResultsWriter | None,
    warn: Warn | None,
) -> None:
    """Let these go on with the memory of another process; `warn` hears what FMUs log then."""
    for name, instance in network.instances.items():
        one = instance.warned
        one.count, one.first, one.last = kept.warned[name]
    journal.restore(kept.messages, warn)
    stability.restore(kept.stability)
    if results:
        results.restore(kept.ranges)
