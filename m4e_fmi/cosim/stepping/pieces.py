"""Steps of components in pieces, their inputs along trajectories: lists of operations.

A component makes its step in pieces, so that its outputs are known in the middle too, and its
inputs follow the trajectories of their sources. `StepValues` has the exchanged values at the start,
in the middle and at the end of a step, and the components' steps (`ComponentStepper`). How inputs
follow depends on what the FMU can do:

=============================  =================================================================
it interpolates its inputs     two pieces; value and two derivatives of the trajectory at the
                               start of each; where it takes but one, the straight lines with the
                               trajectory's mean and first moment, which act alike (see
                               `input_interpolation`)
it holds its inputs, or a      four pieces, or two along straight lines, in which it holds what
tunable parameter is driven    acts like the trajectory (`input_interpolation`)
it moves input w along input   as many pieces; w at the start of each, and the slope that brings it
u (u is declared w's rate)     to where its trajectory is at the end of the piece: second order
=============================  =================================================================

A component with a step of its own has as many pieces as it has steps in the macro step (and each
piece is made in several steps where the macro step is longer than that of the simulation). Where
they have no end in the middle, the outputs there are taken from other points (`MiddleFromPoints`,
`MiddleFromEnds`; see `input_interpolation` for those at which they are known, and for the order).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import (
    Combine,
    DoStep,
    Get,
    Operation,
    Restore,
    Save,
    Transferring,
    gather,
    setting,
    setting_derivatives,
)
from m4e_fmi.cosim.stepping.input_interpolation import InputInterpolation


@dataclass(frozen=True, eq=False)
class InputTrajectories:
    """Trajectories of all connected inputs in a step: `values[places[k]]`, shape (3, n_inputs).

    These are the values at the start, in the middle and at the end of the step, in the units of the
    inputs' sources.
    """

    values: np.ndarray
    places: np.ndarray

    def combined(self, into: np.ndarray, places: np.ndarray, weight: np.ndarray) -> Combine:
        """``into[i] = Σ weight[k, i] · values[places[k, i]]``, with weights that may be changed.

        `into` (n,) is in the outputs' units, `places` (m, n) are indices; the `weight` (m, n) of
        each value is in the unit of the output over that of the value.
        """
        return Combine(into, self.values, places.astype(np.uint32), weight.copy())


class ComponentStepper:
    """One component's step along `trajectories`: its `operations`, once `prepare` knows the size.

    Outputs are read in the middle and at the end, into those blocks of the network's values.
    `inputs` and `outputs` are the component's places among the network's targets and outputs,
    `holds` is true if it holds its inputs, in one of `pieces` after the other.
    """

    def __init__(
        self,
        network: Network,
        name: str,
        trajectories: InputTrajectories,
        interpolation: InputInterpolation,
    ) -> None:
        self.name = name
        self._network, self._trajectories = network, trajectories
        self._interpolation = interpolation
        self._instance = network.instances[name]
        self.inputs, self.outputs = network.input_slice(name), network.output_slice(name)
        self._places = trajectories.places[:, self.inputs]
        description = self._instance.description
        self.has_rollback = description.saves_state
        self._links = network.links_to(name)
        parameters = {v.name for v in description.of_causality("parameter")}
        driven = parameters.intersection(link.target.variable for link in self._links)
        self._order = 0 if driven else description.input_order
        self._follows = bool(self._links and self._order)
        self.moved = [] if self._follows else list(network.moved(name).items())
        ports = network.outputs[self.outputs]
        self._outputs = tuple(port.variable for port in ports)
        self._early = len(network.outputs[network.early(name)])
        self.holds = bool(self._links) and not self._follows
        rate = network.rates.get(name)
        fewest = 2 if self._links or self._outputs else 1
        fewest = self._interpolation.held_pieces if self.holds else fewest
        self.pieces, self._steps = network.pieces(rate) if rate else (fewest, 1)
        self._own = rate.step if rate else 0.0
        self._sized: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self._held, self._reached = np.zeros(len(self._links)), np.zeros(3)
        self._middle = self._interpolated() if self._outputs else None
        count = self.pieces * self._steps
        self.operations = tuple(o for k in range(count) for o in self._piece(k))

    @property
    def followed(self) -> float:
        """Share by which inputs go along with their sources: see `Algorithm`."""
        return 1.0 - self._interpolation.lost(self.pieces) if self.holds else 1.0

    @property
    def save(self) -> tuple[Operation, ...]:
        """Keeps the state to which `restore` returns, if the FMU can."""
        return (Save(self._instance),) if self.has_rollback else ()

    @property
    def restore(self) -> tuple[Operation, ...]:
        """Returns to the start of the step."""
        return (Restore(self._instance),)

    def undo(self) -> None:
        """Return to the start of the step, also if it failed."""
        self._instance.restore_state(self._network.time)

    def prepare(self, size: float, last: float) -> None:
        """Make the operations those of a step of `size` [s] after one of `last` [s] (0: none)."""
        for weight, unit, power in self._sized:
            np.divide(unit, size**power, out=weight)
        if self._middle:
            self._middle.prepare(size, last)

    def _piece(self, k: int) -> list[Operation]:
        """The operations of FMU step k."""
        count = self.pieces * self._steps
        piece, later = divmod(k, self._steps)
        operations: list[Operation] = []
        if self._follows:
            operations += self._follow(k / count)
        elif self._links and (self.moved or not later):
            operations += self._hold(piece, later / self._steps)
        operations.append(DoStep(self._instance, k / count, 1 / count, self._own))
        if later == self._steps - 1:
            operations += self._read(piece + 1)
        return operations

    @property
    def looks_back(self) -> bool:
        """True if connected outputs in the middle are taken from the step before, too."""
        sources = {k.source for k in self._network.links if k.source.component == self.name}
        chains = map(self._network.derivatives, sources)
        return isinstance(self._middle, MiddleFromEnds) and any(len(chain) == 1 for chain in chains)

    def _interpolated(self) -> MiddleFromEnds | MiddleFromPoints | None:
        """The outputs in the middle as taken from others, if they cannot be read there."""
        known = self._interpolation.known(self.pieces, held=self.holds)
        known.sort(key=lambda k: abs(2 * k - self.pieces))
        points = sorted(known[: self._interpolation.most_points])
        if 2 * known[0] == self.pieces:
            return None
        if points == [0, self.pieces]:
            return MiddleFromEnds(
                self._network,
                self.outputs,
                straight=self._interpolation is InputInterpolation.LINES,
            )
        return MiddleFromPoints(self._network, self.outputs, points, self.pieces)

    def _read(self, piece: int) -> tuple[Operation, ...]:
        """Reads the outputs at the end of so many pieces, if they are wanted there.

        Those that follow no input at once are read first, before any is set; the others also then,
        of FMUs that were not built here.
        """
        network, found = self._network, self._middle
        at_end = piece == self.pieces
        if at_end:
            into = network.values[network.stepped :][self.outputs]
        elif found and piece in found.rows:
            into = found.rows[piece]
        elif not found and 2 * piece == self.pieces:
            into = network.values[network.middle :][self.outputs]
        else:
            return ()
        early, late = self._outputs[: self._early], self._outputs[self._early :]
        operations: list[Operation] = []
        if early:
            operations.append(Get(self._instance, early, into[: self._early]))
        if at_end:
            operations += network.seeing(self.name)
        end = self._give(self._interpolation.at(piece / self.pieces)) if self._links else ()
        if late or at_end:
            moved = [w for w, _ in self.moved]
            stays = () if self._follows else network.hold(self.name, self._held, moved)
            held = self._give(self._reached) if self._follows else stays
            operations += network.reread(self.name, held)
        if late:
            operations += end
            reading = Get(self._instance, late, into[self._early :])
            operations += network.read_late(self.name, reading)
        return (*operations, *(found.operations if found and at_end else ()))

    def _give(
        self, weights: np.ndarray, into: np.ndarray | None = None
    ) -> tuple[Transferring, ...]:
        """Sets all inputs to the same combination of the values of their trajectories.

        It is left `into` (n_inputs,), in the units of the inputs' sources.
        """
        count = len(self._links)
        counts = weights != 0.0
        weight = np.repeat(weights[counts, None], count, axis=1)
        into = np.zeros(count) if into is None else into
        combined = self._trajectories.combined(into, self._places[counts], weight)
        return combined, *setting(self._instance, self._links, combined.into)

    def _follow(self, s: float) -> tuple[Operation, ...]:
        """Lets the inputs go from their values at s with one derivative or two."""
        value, first, half = self._interpolation.expansion(s)
        count, piece = len(self._links), 1 / (self.pieces * self._steps)
        if self._order == 1:
            value, first, half = value - half * piece**2 / 6, first + half * piece, 0 * half
        self._reached = value + first * piece + half * piece**2
        operations: list[Operation] = list(self._give(value))
        for order, weights in ((1, first), (2, 2 * half))[: self._order]:
            unit = np.repeat(weights[:, None], count, axis=1)
            combined = self._trajectories.combined(np.zeros(count), self._places, unit)
            self._sized.append((combined.weight, unit, np.full(count, float(order))))
            given = setting_derivatives(self._instance, self._links, combined.into, order)
            operations += combined, *given
        return tuple(operations)

    def _hold(self, k: int, share: float) -> tuple[Operation, ...]:
        """Holds the inputs in piece k, from a share of it on, but moves those along others."""
        if not self.moved:
            return self._give(self._interpolation.held(k, self.pieces), self._held)
        place = {link.target.variable: column for column, link in enumerate(self._links)}
        unit = np.repeat(
            self._interpolation.held(k, self.pieces)[:, None], len(self._links), axis=1
        )
        power, own = np.zeros(len(self._links)), self._places.copy()
        start, end = (self._interpolation.at(j / self.pieces) for j in (k, k + 1))
        for w, u in self.moved:
            unit[:, place[w]] = start + share * (end - start)
            unit[:, place[u]] = (end - start) * self.pieces
            own[:, place[u]] = self._places[:, place[w]]
            power[place[u]] = 1.0
        combined = self._trajectories.combined(self._held, own, unit)
        self._sized.append((combined.weight, unit, power))
        return combined, *setting(self._instance, self._links, combined.into)


class Sampled:
    """A component that steps more rarely than the system: its inputs stay as at its last point.

    `operations` make its step in the macro step that leads to its next point, nothing in others.
    """

    def __init__(self, network: Network, name: str) -> None:
        self.name = name
        self._network, self._instance = network, network.instances[name]
        self.inputs = network.input_slice(name)
        self.operations = network.whole_step(name)
        returns = self._instance.description.saves_state
        self.save: tuple[Operation, ...] = (Save(self._instance),) if returns else ()

    def undo(self) -> None:
        """Return to the start of the macro step, also if it failed."""
        self._instance.restore_state(self._network.time)


def weights(shares: Sequence[float]) -> np.ndarray:
    """Weights (n,) [1] of values at `shares` of a step in their polynomial, taken at its middle."""
    return np.array([math.prod((0.5 - q) / (p - q) for q in shares if q != p) for p in shares])


class MiddleFromPoints:
    """From values at `points`, the ends of so many of a step's `pieces`.

    Those that lie within the step are read into `rows`; `operations` follow the reading at its end.
    """

    def __init__(
        self, network: Network, outputs: slice, points: Sequence[int], pieces: int
    ) -> None:
        values, places = network.values, np.arange(outputs.start, outputs.stop)
        read = np.zeros((len(points), len(places)))
        self.rows = {point: row for point, row in zip(points, read, strict=True) if point < pieces}
        blocks = {0: network.now, pieces: network.stepped}
        known = [
            gather(row, values, blocks[point] + places)
            for point, row in zip(points, read, strict=True)
            if point in blocks
        ]
        weight = weights([point / pieces for point in points])
        into = values[network.middle :][outputs]
        index = np.arange(read.size, dtype=np.uint32).reshape(read.shape)
        share = np.repeat(weight[:, None], len(places), axis=1)
        self.operations: tuple[Operation, ...] = (*known, Combine(into, read.ravel(), index, share))

    def prepare(self, size: float, last: float) -> None:
        """Nothing depends on the sizes."""


class MiddleFromEnds:
    """From values at both ends of the step, and their declared derivatives there.

    Without these, from those at the start of the step before; if there was none, or on a `straight`
    line, the middle has their mean.
    """

    def __init__(self, network: Network, outputs: slice, *, straight: bool) -> None:
        self.rows: dict[int, np.ndarray] = {}
        self._straight = straight
        places = np.arange(outputs.start, outputs.stop)
        chains = [network.derivatives(port) for port in network.outputs[outputs]]
        self._has_rate = np.array([len(chain) > 1 for chain in chains])
        rates = np.array([network.index(chain[min(1, len(chain) - 1)]) for chain in chains])
        now, end, before = network.now, network.stepped, network.before
        index = np.array([now + places, end + places, before + places, now + rates, end + rates])
        into = network.values[network.middle :][outputs]
        shape = np.zeros(index.shape)
        self._combined = Combine(into, network.values, index.astype(np.uint32), shape)
        self.operations: tuple[Operation, ...] = (self._combined,)

    def prepare(self, size: float, last: float) -> None:
        """Weights for a step of `size` [s] after one of `last` [s] (0: there was none)."""
        mean = [0.5, 0.5, 0.0]
        past = mean if self._straight or not last else weights((0.0, 1.0, -last / size)).tolist()
        rate = [0.0, 0.0] if self._straight else [size / 8, -size / 8]
        self._combined.weight[:] = np.array([*past, 0.0, 0.0])[:, None]
        self._combined.weight[:, self._has_rate] = np.array([*mean, *rate])[:, None]


class StepValues:
    """The exchanged values over one step, in the network's blocks `now`, `middle` and `stepped`.

    The latter two, of which `middle` and `end` (n_outputs,) are views, are predicted by the
    operations `begin`, and replaced as `steppers` make their steps; `sampled` are the components
    that step more rarely. `mean` brings the means over the step of all connected inputs into `held`
    (n_inputs,). `places` (3, n_inputs) are those of their values at the start, in the middle and at
    the end of the step. Inputs follow the trajectories of their sources, unless others are given.
    """

    def __init__(
        self,
        network: Network,
        interpolation: InputInterpolation,
        trajectories: InputTrajectories | None = None,
    ) -> None:
        self._network, self._sizes = network, (0.0, 0.0)
        values, self._count = network.values, len(network.outputs)
        self.middle, self.end = self._block(network.middle), self._block(network.stepped)
        self.sources = np.array([network.index(k.source) for k in network.links], dtype=np.intp)
        self.places = places = self.sources + np.array(
            [[network.now], [network.middle], [network.stepped]]
        )
        for column, link in enumerate(network.links):
            if (known := network.held_place(link)) is not None:
                places[:, column] = known
        found = InputTrajectories(values, places)
        given = trajectories or found
        due = {name: network.due(name) for name in network.execution_order}
        self.steppers = tuple(
            ComponentStepper(network, n, given, interpolation)
            for n in network.execution_order
            if not due[n]
        )
        self.sampled = tuple(
            Sampled(network, name) for name in network.execution_order if due[name]
        )
        self.held = np.zeros(len(self.sources))
        weight = np.repeat(interpolation.mean[:, None], len(self.sources), axis=1)
        sampled = [
            gather(self.held[own], network.inputs, range(own.start, own.stop))
            for own in (stepper.inputs for stepper in self.sampled)
        ]
        self.mean = (found.combined(self.held, found.places, weight), *sampled)
        self.followed = self._followed()
        self._predicted = tuple(
            _Prediction(network, into, share) for into, share in ((self.middle, 0.5), (self.end, 1))
        )
        rolled = gather(self._block(network.earlier), self.middle, range(self._count))
        self.begin = rolled, *(prediction.operation for prediction in self._predicted)

    def _followed(self) -> np.ndarray:
        """Shares by which the inputs go along with their sources: see `Algorithm`."""
        found = np.zeros(len(self.sources))
        for stepper in self.steppers:
            found[stepper.inputs] = stepper.followed
        for k, link in enumerate(self._network.links):
            if link.delayed or self._network.due(link.source.component):
                found[k] = 0.0
        return found

    def _block(self, start: int) -> np.ndarray:
        return self._network.values[start : start + self._count]

    def prepare(self, size: float) -> None:
        """Make all operations those of a step of `size` [s] after the network's last one."""
        sizes = size, self._network.last
        if sizes == self._sizes:
            return
        for part in (*self._predicted, *self.steppers):
            part.prepare(*sizes)
        self._sizes = sizes

    def undo(self) -> None:
        """Return all components to the start of the step, also if it failed."""
        self.middle[:] = self._block(self._network.earlier)
        for stepper in (*self.steppers, *self.sampled):
            stepper.undo()


class _Prediction:
    """Predicts all outputs, `share` of the step ahead of its start.

    An output with declared derivatives follows them, and one more power of time that brings it
    through its value at the start of the step before; any other follows the parabola through its
    values at the start, in the middle and at the end of that step. In the first step derivatives
    are all there is. Outputs of components that step more rarely stay as they are.
    """

    def __init__(self, network: Network, into: np.ndarray, share: float) -> None:
        self._share = share
        chains = [[network.index(p) for p in network.derivatives(y)] for y in network.outputs]
        count = len(chains)
        index = np.zeros((4, count), dtype=np.uint32)
        stays = [network.due(port.component) is not None for port in network.outputs]
        self._columns = [
            [k for k, c in enumerate(chains) if len(c) == n + 1 and not stays[k]] for n in range(3)
        ]
        for column, chain in enumerate(chains):
            now = network.now + column
            rest = chain[1:] if len(chain) > 1 else [network.earlier + column]
            rest = [now, network.before + column, *rest]
            index[: len(rest), column] = rest
        self.operation = Combine(into, network.values, index, np.zeros((4, count)))
        self.operation.weight[0, stays] = 1.0

    def prepare(self, size: float, last: float) -> None:
        """Weights for a step of `size` [s] after one of `last` [s] (0: there was none)."""
        for derivatives, columns in enumerate(self._columns):
            if columns:
                weights = _weights(self._share * size, last, derivatives)
                self.operation.weight[:, columns] = weights[:, None]


def _weights(ahead: float, last: float, derivatives: int) -> np.ndarray:
    """Weights (4,) of an output's value now, one step of `last` [s] before, and others.

    These are its value in the middle of that step, or so many of its derivatives now.
    """
    if not derivatives:
        s = ahead / last if last else 0.0
        return np.array([1 + 3 * s + 2 * s * s, s + 2 * s * s, -4 * (s + s * s), 0.0])
    power = derivatives + 1
    missed = (-ahead / last) ** power if last else 0.0
    found = [1 - missed, missed, 0.0, 0.0]
    for k in range(1, power):
        found[k + 1] = (ahead**k - missed * (-last) ** k) / math.factorial(k)
    return np.array(found)
