"""One component's step in pieces, its inputs along their courses: a list of operations.

How the inputs follow depends on what the FMU can do:

=============================  =================================================================
it interpolates its inputs     two pieces; value and two derivatives of the course at the start of
                               each
it holds its inputs            four pieces, or two along straight lines, in which it holds what
                               acts like the course (`course`)
it moves input w along input   as many pieces; w at the start of each, and the slope that brings it
u (u is declared w's rate)     to where its course is at the end of the piece: second order
=============================  =================================================================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.algorithms.course import Way
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.operations import (
    Combine,
    DoStep,
    Get,
    Operation,
    Restore,
    Save,
    setting,
    setting_derivatives,
)


@dataclass(frozen=True, eq=False)
class Courses:
    """Where the courses of all connected inputs are: `values[places[k]]`, shape (3, inputs).

    These are the values at the start, in the middle and at the end of the step.
    """

    values: np.ndarray
    places: np.ndarray

    def combined(self, into: np.ndarray, places: np.ndarray, weight: np.ndarray) -> Combine:
        """``into[i] = Σ weight[k, i] · values[places[k, i]]``, with weights that may be changed."""
        return Combine(into, self.values, places.astype(np.uint32), weight.copy())


class Part:
    """One component's step along `courses`: its `operations`, once `prepare` knows the size.

    Outputs are read in the middle and at the end, into those blocks of the network's values.
    `inputs` and `outputs` are the component's places among the network's targets and outputs,
    `pieces` the number of FMU steps, an even one where outputs are read.
    """

    def __init__(self, network: Network, name: str, courses: Courses, way: Way) -> None:
        self.name = name
        self._network, self._courses, self._way = network, courses, way
        self._instance = network.instances[name]
        self.inputs, self.outputs = network.input_slice(name), network.output_slice(name)
        self._own = courses.places[:, self.inputs]
        description = self._instance.description
        self.can_return = description.saves_state
        self._names = tuple(port.variable for port in network.targets[self.inputs])
        self._follows = bool(self._names) and description.interpolates_inputs
        rates = {} if self._follows else description.input_derivatives
        known = self._names
        self.moved = [(w, u) for w, u in rates.items() if w in known and u in known]
        ports = network.outputs[self.outputs]
        self._outputs = tuple(port.variable for port in ports)
        self._feeds = network.feeds_through(name, ports)
        self.pieces = self._fewest()
        self._sized: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self._size = 0.0
        self.operations = tuple(o for k in range(self.pieces) for o in self._piece(k))

    @property
    def save(self) -> tuple[Operation, ...]:
        """Keeps the state to which `restore` returns, if the FMU can."""
        return (Save(self._instance),) if self.can_return else ()

    @property
    def restore(self) -> tuple[Operation, ...]:
        """Returns to the start of the step."""
        return (Restore(self._instance),)

    def undo(self) -> None:
        """Return to the start of the step, also if it failed."""
        self._instance.restore_state(self._network.time)

    def prepare(self, size: float) -> None:
        """Make the operations those of a step of `size` [s]."""
        if size != self._size:
            for weight, unit, power in self._sized:
                np.divide(unit, size**power, out=weight)
            self._size = size

    def _fewest(self) -> int:
        if self._names and not self._follows:
            return self._way.held_pieces
        return 2 if self._names or self._outputs else 1

    def _piece(self, k: int) -> list[Operation]:
        """The operations from k/pieces to (k + 1)/pieces of the step."""
        network, end = self._network, (k + 1) / self.pieces
        steers = self._follow if self._follows else self._hold
        operations = [*steers(k)] if self._names else []
        operations.append(DoStep(self._instance, k / self.pieces, 1 / self.pieces))
        if self._outputs and end in (0.5, 1.0):
            if self._feeds:
                operations += self._give(self._way.at(end))
            block = network.values[network.middle if end < 1.0 else network.stepped :]
            operations.append(Get(self._instance, self._outputs, block[self.outputs]))
        return operations

    def _give(self, weights: np.ndarray) -> tuple[Operation, ...]:
        """Sets all inputs to the same combination of the values of their courses."""
        count = len(self._names)
        counts = weights != 0.0
        weight = np.repeat(weights[counts, None], count, axis=1)
        combined = self._courses.combined(np.zeros(count), self._own[counts], weight)
        return combined, *setting(self._instance, self._names, combined.into)

    def _follow(self, k: int) -> tuple[Operation, ...]:
        """Lets the inputs go from their values at the start of piece k with two derivatives."""
        value, first, half = self._way.expansion(k / self.pieces)
        count = len(self._names)
        unit = np.tile(np.column_stack((first, 2 * half)), count)
        power = np.tile((1.0, 2.0), count)
        combined = self._courses.combined(np.zeros(2 * count), self._own.repeat(2, axis=1), unit)
        self._sized.append((combined.weight, unit, power))
        given = setting_derivatives(self._instance, self._names, combined.into)
        return *self._give(value), combined, *given

    def _hold(self, k: int) -> tuple[Operation, ...]:
        """Holds the inputs in piece k, but moves those along others that are."""
        if not self.moved:
            return self._give(self._way.held(k, self.pieces))
        place = {name: column for column, name in enumerate(self._names)}
        unit = np.repeat(self._way.held(k, self.pieces)[:, None], len(place), axis=1)
        power, own = np.zeros(len(place)), self._own.copy()
        start, end = (self._way.at(j / self.pieces) for j in (k, k + 1))
        for w, u in self.moved:
            unit[:, place[w]] = start
            unit[:, place[u]] = (end - start) * self.pieces
            own[:, place[u]] = self._own[:, place[w]]
            power[place[u]] = 1.0
        combined = self._courses.combined(np.zeros(len(place)), own, unit)
        self._sized.append((combined.weight, unit, power))
        return combined, *setting(self._instance, self._names, combined.into)
