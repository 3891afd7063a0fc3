"""Points at which an FMU's functions are evaluated: known values are set, unknown ones read.

Three places have such a function: initialization mode (start values → initial unknowns), a
communication point of co-simulation (inputs → outputs), continuous-time mode of model exchange
(states and inputs → rates and outputs).
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.elements import FmpyUnknown
from m4e_fmi.fmu.validation.context import Context
from m4e_fmi.fmu.validation.probe import Probe, RefusedError

INITIAL, STEPPING, EXCHANGE = "initialization mode", "co-simulation", "model exchange"
_STEPS = 3  # made before the communication point


@dataclass
class Place:
    """One of the three; `declared` are the entries of ModelStructure for its unknowns."""

    name: str
    context: Context
    probe: Probe
    knowns: list[ModelVariable]
    unknowns: list[ModelVariable]
    declared: list[FmpyUnknown]

    def evaluate(self, values: np.ndarray) -> np.ndarray | None:
        """Unknowns (n_unknowns,), in their units; None where the FMU has no finite answer.

        The knowns are `values` (n_knowns,), in their units.

        After an answer that leaves the FMU unusable, it is brought here anew.
        """
        try:
            self._set(values)
            found = self.probe.read(self.unknowns)
        except RefusedError:
            self.renew()
            return None
        return found if np.isfinite(found).all() else None

    def _set(self, values: np.ndarray) -> None:
        count = len(self.context.subject.states)
        if self.name == EXCHANGE:
            self.probe.set_state_vector(values[:count])
            self.probe.put(self.knowns[count:], values[count:])
        else:
            self.probe.put(self.knowns, values)

    def renew(self) -> None:
        """Bring a new instance here, instead of the one there was."""
        self.probe.free()
        self.probe = _new_probe(self.context, self.name)
        arrive(self.context, self.probe, self.name)


def _new_probe(context: Context, name: str) -> Probe:
    return context.library.probe(exchange=name == EXCHANGE or not context.subject.steps)


def arrive(context: Context, probe: Probe, name: str) -> None:
    """Bring a new instance to the place of this name."""
    if name == INITIAL:
        probe.setup()
        probe.enter_initialization()
        return
    probe.begin()
    if name == STEPPING:
        for row in context.random_inputs(_STEPS):
            probe.put(context.subject.inputs, row)
            probe.advance(context.subject.step_size)


@contextmanager
def _place(
    context: Context, name: str, knowns: list[ModelVariable], entries: list[FmpyUnknown]
) -> Generator[Place, None, None]:
    entries = [e for e in entries if e.variable.type == "Real"]
    unknowns = [e.variable for e in entries]
    probe = _new_probe(context, name)
    place = Place(name, context, probe, knowns, unknowns, entries)
    try:
        arrive(context, probe, name)
        yield place
    finally:
        place.probe.free()


def places(context: Context) -> Iterator[Place]:
    """Those that the FMU has, one after the other."""
    subject, raw = context.subject, context.subject.raw
    continuous = [e for e in raw.outputs if e.variable.variability == "continuous"]
    wanted = []
    if subject.given and raw.initialUnknowns:
        wanted.append((INITIAL, subject.given, raw.initialUnknowns))
    if subject.steps and subject.inputs and continuous:
        wanted.append((STEPPING, subject.inputs, continuous))
    if subject.exchanges and (subject.states or subject.inputs):
        both = [*subject.states, *subject.inputs]
        wanted.append((EXCHANGE, both, [*continuous, *raw.derivatives]))
    for name, knowns, entries in wanted:
        with _place(context, name, knowns, entries) as place:
            if name != EXCHANGE or _states_fit(place):
                yield place


def _states_fit(place: Place) -> bool:
    """True if the declared states are those of the state vector; `derivatives` tells if not."""
    place.probe.set_state_vector(place.context.random(place.context.subject.states)[0])
    variables = place.probe.read(place.context.subject.states)
    return np.allclose(variables, place.probe.state_vector(), rtol=1e-12, atol=0.0)
