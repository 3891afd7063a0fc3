"""Group `state_elsewhere`: the bytes of a state from another process."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from m4e_fmi.fmu.validation.checks.states import BASIS, RESUME, deserialise
from m4e_fmi.fmu.validation.context import Context, first_difference
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.probe import RefusedError


def check(context: Context) -> Iterator[Finding | str]:
    """A state that does not repeat a run in another process."""
    path = context.folder / RESUME
    if not path.exists():
        yield "there is no serialised state"
        return
    left = json.loads(path.read_text())
    inputs = np.array([[float.fromhex(value) for value in row] for row in left["inputs"]])
    expected = [np.frombuffer(bytes.fromhex(row)) for row in left["expected"]]
    with context.probe() as probe:
        probe.begin()
        try:
            deserialise(probe, bytes.fromhex(left["state"]))
        except RefusedError as error:
            yield Finding("state_elsewhere.refused", "error", str(error), BASIS, error.words)
            return
        probe.time = left["time"]
        again = context.run(probe, inputs, context.subject.step_size)
    difference = first_difference(context.subject, expected, again)
    if difference is not None:
        row, names = difference
        message = f"in a new process, after {row} steps other bits in {some(names)}"
        yield Finding("state_elsewhere.differs", "error", message, BASIS)
