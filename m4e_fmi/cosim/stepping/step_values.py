"""Exchanged values at the start, middle and end of a step, and the components' steps.

A component makes its step in pieces, so that its outputs are known in the middle too, and its
inputs follow their trajectories (`input_interpolation`, `component_stepper`).
"""

from __future__ import annotations

import math

import numpy as np

from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.exchange.operations import Combine, gather
from m4e_fmi.cosim.stepping.component_stepper import ComponentStepper, InputTrajectories, Sampled
from m4e_fmi.cosim.stepping.input_interpolation import InputInterpolation


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
