"""What passes between the components during one step: values at its start, middle and end.

Through the three values u₀, u½, u₁ of an input goes a parabola, its *course*:

    u(s) = c₀ + c₁ s + c₂ s²,   s = (t − tₙ)/H,   c₁ = −3u₀ + 4u½ − u₁,   c₂ = 2u₀ − 4u½ + 2u₁.

A component makes its step in two halves, so that its outputs are known in the middle too. How its
inputs follow their courses depends on what its FMU can do:

=============================  =================================================================
it interpolates its inputs     value and two derivatives of the course at the start of each half
it holds its inputs            u₀ + c₁/4 + c₂/12 and u₀ + 3c₁/4 + 7c₂/12, means of the halves, in
                               a pass that looks for the middle; u₀ + c₁/6 and u₀ + 5c₁/6 + 2c₂/3
                               in one that makes the end exact
it moves input w along input   w at the start of each half, and the slope that brings it to where
u (u is declared w's rate)     its course is at the end of the half
=============================  =================================================================

The last two values have the same mean and the same first moment over the step as the course, ∫u ds
and ∫s u ds, and so act at the end to third order like the course itself. With the means of the
halves, what depends on an input by one integration (a velocity on a force) is right to third
order in the middle too; by two integrations (a displacement), it is off by O(H³), which does no
harm in the middle and costs an order at the end. A moved input is of second order.

Straight lines from u₀ over u½ to u₁ (`Way.LINES`; held is their mean in each half) are of second
order, and stable where a parabola, solved for its values, is not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum

import numpy as np

from m4e_fmi.cosim.connect import Port
from m4e_fmi.cosim.network import Network


class Way(Enum):
    """How inputs pass through their three values; MIDDLE and END tell what is to be exact."""

    MIDDLE = "parabola, means of the halves"
    END = "parabola, mean and first moment of the step"
    LINES = "straight lines"


HELD = {
    Way.MIDDLE: ((1 / 4, 1 / 12), (3 / 4, 7 / 12)),
    Way.END: ((1 / 6, 0.0), (5 / 6, 2 / 3)),
    Way.LINES: ((1 / 4, 1 / 8), (3 / 4, 5 / 8)),
}
"""Shares of c₁ and c₂ in what is held in each half, besides u₀."""


class Interface:
    """Courses of all connected inputs of a network over one step.

    `middle` and `end` are the values of all exchanged outputs there, in the order of a block of
    `Network.values`: predicted by `begin`, replaced as the `parts` make their steps.
    """

    def __init__(self, network: Network) -> None:
        self._network = network
        count = len(network.outputs)
        self._now = network.values[:count]
        self.middle = np.zeros(count)
        self.end = np.zeros(count)
        self.sources = np.array([network.index(k.source) for k in network.links], dtype=np.intp)
        self.parts = tuple(Part(network, name) for name in network.sweep)
        self._start = np.zeros(count)
        self._attempt = (network.time, 0.0)
        self._history = np.zeros((2, count))
        self._last = 0.0
        chains = [network.derivatives(port) for port in network.outputs]
        self._derivatives = [_places(network, chains, length) for length in (2, 3)]

    @property
    def has_history(self) -> bool:
        """Whether a step has been made from which outputs can be extrapolated."""
        return self._last > 0.0

    def begin(self, time: float, size: float) -> None:
        """Save all states and predict all outputs over the step of `size` [s] from `time`.

        An output with declared derivatives follows them, and one more power of time that brings it
        through its value at the start of the step before; any other follows the parabola through
        its values at the start, in the middle and at the end of that step. In the first step
        derivatives are all there is.

        A step that begins where the last one began takes that one's place.
        """
        begun, last = self._attempt
        if time > begun:
            self._history[:] = self._start, self.middle
            self._last = last
        self._attempt = (time, size)
        now = self._now
        self._start[:] = now
        for part in self.parts:
            part.save()
        for place, share in ((self.middle, 0.5), (self.end, 1.0)):
            place[:] = now
            if self._last:
                first, middle = self._history
                s = share * size / self._last
                place += s * (first - 4 * middle + 3 * now)
                place += s * s * (2 * first - 4 * middle + 2 * now)
            for chains in self._derivatives:
                place[chains[0]] = self._along(chains, share * size)

    def _along(self, chains: np.ndarray, ahead: float) -> np.ndarray:
        """Outputs `chains[0]`, `ahead` [s] after the start, from their derivatives `chains[1:]`."""

        def taylor(s: float) -> np.ndarray:
            return sum(
                (self._now[row] * s**k / math.factorial(k) for k, row in enumerate(chains)),
                np.zeros(chains.shape[1]),
            )

        if not self._last:
            return taylor(ahead)
        missed = self._history[0, chains[0]] - taylor(-self._last)
        return taylor(ahead) + missed * (-ahead / self._last) ** len(chains)

    def step(self, part: Part, time: float, size: float, way: Way) -> None:
        """One component's step along the present courses; its outputs then stand in them.

        An FMU that holds its inputs can be right in the middle or at the end (`Way.END`); the
        middle then stays as it was.
        """
        own = self.sources[part.inputs]
        part.step(time, size, self.middle[own], self.end[own], way)
        self.take(part, way)

    def take(self, part: Part, way: Way) -> None:
        """Take over what a component has found in its step."""
        if part.follows or way is not Way.END:
            self.middle[part.outputs] = part.middle
        self.end[part.outputs] = part.end

    def mean(self, way: Way) -> np.ndarray:
        """Means of the courses of all connected inputs over the step."""
        weight = 2 if way is Way.LINES else 4  # trapezoid, Simpson
        start, middle, end = (v[self.sources] for v in (self._start, self.middle, self.end))
        return (start + weight * middle + end) / (2 + weight)


class Part:
    """One component during a step: it can be taken back, and made again with other inputs.

    `inputs` and `outputs` are its places among the network's targets and outputs; `middle` and
    `end` its outputs there after `step`.
    """

    def __init__(self, network: Network, name: str) -> None:
        self.name = name
        self._instance = network.instances[name]
        self.inputs = network.input_slice(name)
        self.outputs = network.output_slice(name)
        self._start = network.inputs[self.inputs]
        self._values = np.zeros_like(self._start)
        self._derivatives = np.zeros((len(self._start), 2))
        self.middle = np.zeros(self.outputs.stop - self.outputs.start)
        self.end = np.zeros_like(self.middle)
        self._do_step = network.stepper(name)
        connected = len(self._start) > 0
        self.connected = connected
        self._set = network.writer(name, self._values) if connected else _nothing
        description = self._instance.description
        self.can_return = description.saves_state
        targets = [port.variable for port in network.targets[self.inputs]]
        self.follows = connected and description.interpolates_inputs
        self._derive = network.derivative_writer(name, self._derivatives) if self.follows else None
        place = {variable: k for k, variable in enumerate(targets)}
        moved = description.input_derivatives.items()
        self.moved = [] if self.follows else [(w, u) for w, u in moved if w in place and u in place]
        self._moved = [(place[w], place[u]) for w, u in self.moved]
        names = [port.variable for port in network.outputs[self.outputs]]
        read = network.reader if names else None
        self._read_middle = read(name, names, self.middle) if read else _nothing
        self._read_end = read(name, names, self.end) if read else _nothing

    def save(self) -> None:
        """Keep the state to which `restore` returns."""
        if self.can_return:
            self._instance.save_state()

    def restore(self) -> None:
        """Return to the state that was saved."""
        self._instance.restore_state()

    def step(self, time: float, size: float, middle: np.ndarray, end: np.ndarray, way: Way) -> None:
        """Step from `time` by `size` [s] in two halves; its inputs pass `middle` and `end`."""
        start, half = self._start, size / 2
        slope = -3 * start + 4 * middle - end
        bend = 2 * start - 4 * middle + 2 * end
        first = start.copy()
        halves = (middle, self._read_middle), (end, self._read_end)
        for k, (last, read) in enumerate(halves):
            if self._derive is None:
                of_slope, of_bend = HELD[way][k]
                held = start + of_slope * slope + of_bend * bend
                self._half_held(held, first, last, time + k * half, half)
            elif way is Way.LINES:
                rate = (last - first) / half
                self._half_along(first, rate, np.zeros_like(rate), time + k * half, half)
            else:
                rate = (slope + k * bend) / size
                self._half_along(first, rate, 2 * bend / size**2, time + k * half, half)
            self._give(last)
            read()
            first = last

    def _give(self, values: np.ndarray) -> None:
        self._values[:] = values
        self._set()

    def _half_along(
        self, value: np.ndarray, first: np.ndarray, second: np.ndarray, time: float, half: float
    ) -> None:
        self._give(value)
        self._derivatives[:, 0] = first
        self._derivatives[:, 1] = second
        assert self._derive is not None
        self._derive()
        self._do_step(time, half)

    def _half_held(
        self, held: np.ndarray, first: np.ndarray, last: np.ndarray, time: float, half: float
    ) -> None:
        for w, u in self._moved:
            held[w] = first[w]
            held[u] = (last[w] - first[w]) / half
        self._give(held)
        self._do_step(time, half)


def _nothing() -> None:
    pass


def _places(network: Network, chains: Sequence[Sequence[Port]], length: int) -> np.ndarray:
    """Places of the chains of this length, an output and its derivatives: one column for each."""
    rows = [[network.index(port) for port in chain] for chain in chains if len(chain) == length]
    return np.array(rows, dtype=np.intp).reshape(-1, length).T
