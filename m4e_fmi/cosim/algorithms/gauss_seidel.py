"""Gauss–Seidel of second order for plain FMI 2.0 FMUs: no rollback, no input derivatives.

Components step one after the other from t to t + H, those first whose outputs cannot be predicted
(forces), so that the others (bodies) know those outputs at both ends of the step. An FMU holds its
inputs during a step; a held value acts to second order like the true course of the input if it is
the *mean* of that course. With y the source of an input, at `now` (y₀), one step `before` (y₋) and,
once its component has stepped, `stepped` (y₁):

===========  ==========================================  =====================================
source       mean over the step                          value at the end of the step
===========  ==========================================  =====================================
stepped      that of the parabola through y₋, y₀, y₁:    y₁
             (y₀ + y₁)/2 − (y₁ − 2 y₀ + y₋)/12
predictable  y₀ + H y′/2 + H² y″/6                       y₀ + H y′ + H² y″/2
neither      y₀ + (y₀ − y₋)/2                            y₀ + (y₀ − y₋)
===========  ==========================================  =====================================

Predictable is an output whose FMU declares an output as its `derivative` (x ← vx ← ax). The
parabola is Adams–Moulton's; in the first step, without y₋, it is the mean of both ends.

An FMU that declares an input u as derivative of another input w moves w along u during the step:
w(t + s) = w + s u. There w starts at y₀ and u is the mean slope (end − y₀)/H, so that w arrives
where its source does. (Driving a mooring line with the body's velocity at the start of the step
instead makes the coupling first order.)

After its step a component gets all its inputs at their end-of-step values, and its outputs are read
for those that follow. When all have stepped, the exchange at t + H replaces predictions by values.

Order and stability. Local errors are third order: the trapezoid's and that of holding the mean of
a force, which displaces a body by H³F′/12m and no more. For a mass and a spring in two components,
together of frequency ω, the amplitude changes by the factor 1 − (ωH)⁴/32 per step, the frequency
by 1 − (ωH)²/24, and the step is stable up to ωH = 2.1; if the force does not follow its input
after the step (a mooring line), 1 − (ωH)⁴/10 and 1.7. A damper d on a mass m is stable up to
dH/m = 2.4. So energy is lost, never gained, and little: 5e-5 of the amplitude per period at 100
steps a period. One thing stays first order: the damping inside an FMU whose force does not follow
its inputs after the step, because that force belongs to the mean velocity, half a step old.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from m4e_fmi.cosim.algorithms.prediction import Signal, Terms
from m4e_fmi.cosim.connect import Link, Port
from m4e_fmi.cosim.network import Network


class GaussSeidel:
    """See the module."""

    def __init__(self, network: Network) -> None:
        self.held = np.zeros_like(network.inputs)
        self.notes: tuple[str, ...] = ()
        self.order = 2
        self._last = 0.0
        self._attempt = (network.time, 0.0)
        self._prepared = (0.0, 0.0)
        order = network.sweep
        self._components = tuple(
            _Component(network, name, before=order[:k], after=order[k + 1 :], held=self.held)
            for k, name in enumerate(order)
        )

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s].

        A step that begins where the last one began takes that one's place.
        """
        begun, last = self._attempt
        if time > begun:
            self._last = last
        self._attempt = (time, size)
        sizes = (size, self._last)
        if sizes != self._prepared:
            for component in self._components:
                component.prepare(*sizes)
            self._prepared = sizes
        for component in self._components:
            component.step(time, size)


class _Component:
    """One component's part of a sweep; `before` and `after` it step the others."""

    def __init__(
        self,
        network: Network,
        name: str,
        *,
        before: Sequence[str],
        after: Sequence[str],
        held: np.ndarray,
    ) -> None:
        own = network.input_slice(name)
        self._values = network.values
        self._held = held[own]
        self._ends = np.zeros(len(self._held))
        self._inputs = _inputs(network, name, before)
        self._index = np.zeros(0, dtype=np.intp)
        self._local = np.zeros(0)
        self._held_matrix = self._end_matrix = np.zeros((len(self._held), 0))
        self._set_held = network.writer(name, self._held) if len(self._held) else None
        self._do_step = network.stepper(name)
        self._set_ends = self._read = None
        asked = [k.source for k in network.links if k.target.component in after]
        asked = [port for port in asked if port.component == name]
        if asked:
            outputs = network.output_slice(name)
            view = self._values[network.stepped :][outputs]
            names = [port.variable for port in network.outputs[outputs]]
            self._read = network.reader(name, names, view)
            if _any_feed_through(network, name, asked):
                self._set_ends = network.writer(name, self._ends)

    def prepare(self, size: float, last: float) -> None:
        """Coefficients for a step of `size` [s] after one of `last` [s]."""
        held = [terms(size, last) for terms, _ in self._inputs]
        ends = [terms(size, last) for _, terms in self._inputs]
        used = sorted({index for terms in (*held, *ends) for index in terms})
        self._index = np.array(used, dtype=np.intp)
        self._local = np.zeros(len(used))
        self._held_matrix = _matrix(held, used)
        self._end_matrix = _matrix(ends, used)

    def step(self, time: float, size: float) -> None:
        """Set the held inputs, step, and bring the outputs that others wait for to the end."""
        if self._set_held is not None:
            self._values.take(self._index, out=self._local, mode="clip")
            self._held_matrix.dot(self._local, out=self._held)
            self._set_held()
        self._do_step(time, size)
        if self._set_ends is not None:
            self._end_matrix.dot(self._local, out=self._ends)
            self._set_ends()
        if self._read is not None:
            self._read()


Formula = Callable[[float, float], Terms]
"""Step size and the one before [s] → terms."""


def _inputs(network: Network, name: str, before: Sequence[str]) -> list[tuple[Formula, Formula]]:
    """For each connected input of a component: what it holds, and its value at the end."""
    own = network.links[network.input_slice(name)]
    signals = {k.target.variable: _signal(network, k, before) for k in own}
    rates = network.instances[name].description.input_derivatives
    moved = {w: u for w, u in rates.items() if w in signals and u in signals}
    driver = {u: w for w, u in moved.items()}
    formulas: list[tuple[Formula, Formula]] = []
    for variable, signal in signals.items():
        if variable in moved:
            held: Formula = signal.start
        elif variable in driver:
            held = signals[driver[variable]].slope
        else:
            held = signal.mean
        formulas.append((held, signal.end))
    return formulas


def _signal(network: Network, link: Link, before: Sequence[str]) -> Signal:
    """The source of a link, as seen by its target's component."""
    now, *rates = (network.index(port) for port in network.derivatives(link.source))
    rate, curvature = (*rates, None, None)[:2]
    return Signal(
        now=now,
        before=network.before + now,
        stepped=network.stepped + now if link.source.component in before else None,
        rate=rate,
        curvature=curvature,
    )


def _any_feed_through(network: Network, name: str, outputs: Sequence[Port]) -> bool:
    """Whether any of the outputs depends on a connected input of its component."""
    connected = {port.variable for port in network.targets[network.input_slice(name)]}
    dependencies = network.instances[name].description.dependencies
    return any(dependencies[port.variable] & connected for port in outputs)


def _matrix(rows: Sequence[Terms], columns: Sequence[int]) -> np.ndarray:
    place = {index: k for k, index in enumerate(columns)}
    matrix = np.zeros((len(rows), len(columns)))
    for row, terms in zip(matrix, rows, strict=True):
        for index, factor in terms.items():
            row[place[index]] = factor
    return matrix
