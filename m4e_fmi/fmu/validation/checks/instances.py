"""Group `instances`: reset is a fresh start, instances do not share, freeing them frees memory."""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from m4e_fmi.fmu.validation.context import Context, first_difference
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.fmu_under_test import scale, start, within
from m4e_fmi.fmu.validation.probe import Probe

STEPS = 5
WARM_UP, CYCLES, LEAST = 10, 40, 4
"""Instances before any are counted, instances counted, and how many at least if they are slow."""
LEAK = 65536
"""Bytes that an instance may leave behind: well above what an allocator keeps, or an interpreter
that compiles a small script (5 to 8 kB have been measured)."""
_STATM = Path("/proc/self/statm")


def check(context: Context) -> Iterator[Finding | str]:
    """Instances that differ after a reset, share values, or leave memory behind."""
    for exchange in context.subject.ways:
        yield from _reset(context, exchange=exchange)
        if not context.subject.once:
            yield from _shared(context, exchange=exchange)
    yield from _leak(context)


def _trace(context: Context, probe: Probe, inputs: np.ndarray) -> list[np.ndarray]:
    """All Reals along a run; in model exchange at the start, with inputs that change."""
    if not probe.exchange:
        return context.run(probe, inputs, context.subject.step_size)
    seen = []
    for row in inputs:
        probe.put(context.subject.inputs, row)
        seen.append(probe.read(context.subject.readable))
    return seen


def _reset(context: Context, *, exchange: bool) -> Iterator[Finding]:
    inputs = context.random_inputs(STEPS)
    with context.probe(exchange=exchange) as probe:
        probe.begin()
        fresh = _trace(context, probe, inputs)
    with context.probe(exchange=exchange) as probe:
        _perturbed(context, probe)
        _trace(context, probe, inputs[::-1])
        probe.reset()
        probe.begin()
        again = _trace(context, probe, inputs)
    difference = first_difference(context.subject, fresh, again)
    if difference is not None:
        row, names = difference
        message = f"after fmi2Reset a run is not that of a new instance: {some(names)}, row {row}"
        yield Finding("instances.reset", "error", message, "FMI 2.0.4, section 2.1.6")


def _perturbed(context: Context, probe: Probe) -> None:
    """Begin with other parameters and inputs than the start values."""
    given = [v for v in context.subject.given if v.causality != "input"]
    changed = {}
    for v in given:
        change = 0.01 * context.facts.amplitude * scale(v)
        changed[v.valueReference] = within(v, start(v) + change)
    probe.begin(changed)


def _shared(context: Context, *, exchange: bool) -> Iterator[Finding]:
    inputs = context.random_inputs(STEPS)
    with context.probe(exchange=exchange) as alone:
        alone.begin()
        expected = _trace(context, alone, inputs)
    with (
        context.probe(exchange=exchange) as one,
        context.probe(exchange=exchange, name="other") as other,
    ):
        one.begin()
        _perturbed(context, other)
        seen: list[np.ndarray] = [] if exchange else [one.read(context.subject.readable)]
        for row, opposite in zip(inputs, inputs[::-1], strict=True):
            seen += _trace(context, one, row[None])[0 if exchange else 1 :]
            _trace(context, other, opposite[None])
    difference = first_difference(context.subject, expected, seen)
    if difference is not None:
        row, names = difference
        message = f"a second instance changes the results of the first: {some(names)}, row {row}"
        basis = "else declare canBeInstantiatedOnlyOncePerProcess: FMI 2.0.4, section 2.1.5"
        yield Finding("instances.shared", "error", message, basis)


def _leak(context: Context) -> Iterator[Finding]:
    if not _STATM.exists():
        return
    sizes: list[int] = []
    while len(sizes) <= WARM_UP + CYCLES and not (context.late and len(sizes) > LEAST):
        with context.probe(exchange=not context.subject.steps) as probe:
            probe.setup()
            probe.enter_initialization()
            probe.leave_initialization()
            probe.terminate()
        sizes.append(_resident())
    counted = sizes[min(WARM_UP, len(sizes) // 2) :]
    each = (counted[-1] - counted[0]) / (len(counted) - 1)
    if each > LEAK:
        message = f"{len(counted)} instances left {each / 1024:.0f} kB each behind when freed"
        yield Finding("instances.leak", "warning", message, "FMI 2.0.4, section 2.1.5")


def _resident() -> int:
    """Bytes of this process in memory."""
    return int(_STATM.read_text().split()[1]) * mmap.PAGESIZE
