"""What passes between the components during one step: values at its start, middle and end.

Through the three values u₀, u½, u₁ of an input goes a parabola, its *course*:

    u(s) = c₀ + c₁ s + c₂ s²,   s = (t − tₙ)/H,   c₁ = −3u₀ + 4u½ − u₁,   c₂ = 2u₀ − 4u½ + 2u₁.

A component makes its step in pieces, so that its outputs are known in the middle too. How its
inputs follow their courses depends on what its FMU can do:

=============================  =================================================================
it interpolates its inputs     two halves; value and two derivatives of the course at the start of
                               each
it holds its inputs            four quarters, each two of which have the same mean and the same
                               first moment as the course: u₀ + c₁/12, u₀ + 5c₁/12 + c₂/6,
                               u₀ + 7c₁/12 + c₂/3, u₀ + 11c₁/12 + 5c₂/6
it moves input w along input   quarters; w at the start of each, and the slope that brings it to
u (u is declared w's rate)     where its course is at the end of the quarter
=============================  =================================================================

A held value with the right mean gives a velocity that a force drives, but not the displacement:
that is off by H³/96 of the force's rate in a half step, and lets an undamped pair gain energy. Two
values with the right first moment besides, ∫u ds and ∫s u ds, act to the fourth order like the
course itself, at their end. A moved input is of second order.

Straight lines from u₀ over u½ to u₁ in two halves (`Way.LINES`; held is their mean) are of second
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
    """How inputs pass through their three values."""

    PARABOLA = "parabola"
    LINES = "straight lines"


HELD = {
    Way.PARABOLA: ((1 / 12, 0.0), (5 / 12, 1 / 6), (7 / 12, 1 / 3), (11 / 12, 5 / 6)),
    Way.LINES: ((1 / 4, 1 / 8), (3 / 4, 5 / 8)),
}
"""Shares of c₁ and c₂ in what is held in each piece, besides u₀."""


class Interface:
    """Courses of all connected inputs of a network over one step.

    `middle` and `end` are the values of all exchanged outputs there, in the order of a block of
    `Network.values`: predicted by `begin`, replaced as the `parts` make their steps.
    """

    REMEMBERED = ("_start", "middle", "_attempt", "_history", "_last")

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

    def forget(self) -> None:
        """Nothing is to be extrapolated from the last step."""
        self._attempt = (self._attempt[0], 0.0)

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
        """One component's step along the present courses; its outputs then stand in them."""
        own = self.sources[part.inputs]
        part.step(time, size, self.middle[own], self.end[own], way)
        self.take(part)

    def take(self, part: Part) -> None:
        """Take over what a component has found in its step."""
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
        self._holds = connected and not self.follows
        self._derive = network.derivative_writer(name, self._derivatives) if self.follows else None
        place = {variable: k for k, variable in enumerate(targets)}
        moved = description.input_derivatives.items()
        self.moved = [] if self.follows else [(w, u) for w, u in moved if w in place and u in place]
        self._moved = [(place[w], place[u]) for w, u in self.moved]
        names = [port.variable for port in network.outputs[self.outputs]]
        self._fewest = 2 if connected or names else 1
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
        """Step from `time` by `size` [s] in pieces; its inputs pass `middle` and `end`."""
        start = self._start.copy()
        slope = -3 * start + 4 * middle - end
        bend = 2 * start - 4 * middle + 2 * end
        shares = HELD[way]
        pieces = len(shares) if self._holds else self._fewest
        length = size / pieces
        first = start
        for k in range(pieces):
            s = (k + 1) / pieces
            last = start + s * slope + s * s * bend
            if self.follows:
                rate, second = (last - first) / length, np.zeros_like(first)
                if way is Way.PARABOLA:
                    rate, second = (slope + k * bend) / size, 2 * bend / size**2
                self._follow(first, rate, second)
            elif self._holds:
                of_slope, of_bend = shares[k]
                self._hold(start + of_slope * slope + of_bend * bend, first, last, length)
            self._do_step(time + k * length, length)
            first = last
            if s in (0.5, 1.0):
                self._give(last)
                (self._read_middle if s < 1.0 else self._read_end)()

    def _give(self, values: np.ndarray) -> None:
        self._values[:] = values
        self._set()

    def _follow(self, value: np.ndarray, rate: np.ndarray, second: np.ndarray) -> None:
        """Let the inputs go from `value` with these derivatives."""
        self._give(value)
        self._derivatives[:, 0] = rate
        self._derivatives[:, 1] = second
        assert self._derive is not None
        self._derive()

    def _hold(self, held: np.ndarray, first: np.ndarray, last: np.ndarray, length: float) -> None:
        """Hold the inputs, but move those along others that are, from `first` to `last`."""
        for w, u in self._moved:
            held[w] = first[w]
            held[u] = (last[w] - first[w]) / length
        self._give(held)


def _nothing() -> None:
    pass


def _places(network: Network, chains: Sequence[Sequence[Port]], length: int) -> np.ndarray:
    """Places of the chains of this length, an output and its derivatives: one column for each."""
    rows = [[network.index(port) for port in chain] for chain in chains if len(chain) == length]
    return np.array(rows, dtype=np.intp).reshape(-1, length).T
