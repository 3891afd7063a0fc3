"""Gauss–Seidel of second order for plain FMI 2.0 FMUs: no rollback, no input derivatives.

Components step one after the other from t to t + H, those first whose outputs cannot be predicted
(forces), so that the others (bodies) know those outputs at both ends of the step. An FMU holds its
inputs during a step; a held value acts to second order like the true trajectory of the input if
it is the *mean* of that trajectory. With y the source of an input, at `now` (y₀), one step `before`
(y₋) and, once its component has stepped, `stepped` (y₁):

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

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Combine, Get, Operation, gather, setting
from m4e_fmi.cosim.stepping.algorithm import Scheduled
from m4e_fmi.cosim.wiring.links import Link, Port
from m4e_fmi.coupling_algorithms import AlgorithmDescriptor, LinkDelay

Terms = dict[int, float]
"""A linear combination: index into `Network.values` → coefficient."""
MOST_TERMS = 3
Formula = Callable[[float, float], Terms]
"""Step size and the one before [s] → terms."""


class GaussSeidel(Scheduled):
    """Steps of the components one after the other, with predicted means of inputs held."""

    order = 2

    def __init__(self, network: Network) -> None:
        held = np.zeros_like(network.inputs)
        place = {name: k for k, name in enumerate(network.execution_order)}
        asked: dict[str, list[Port]] = {name: [] for name in place}
        for link in network.links:
            ends = link.source.component, link.target.component
            if link.delayed or any(map(network.due, ends)):
                continue
            if place[ends[0]] < place[ends[1]]:
                asked[link.source.component].append(link.source)
        self._components = tuple(
            _Component(
                network, name, before=set(network.execution_order[:k]), asked=asked[name], held=held
            )
            for name, k in place.items()
        )
        super().__init__(network, [o for c in self._components for o in c.operations], held)
        self._prepared = (0.0, 0.0)

    def prepare(self, size: float) -> None:
        """Weights for this size, and that of the step before."""
        sizes = (size, self.network.last)
        if sizes != self._prepared:
            for component in self._components:
                component.prepare(*sizes)
            self._prepared = sizes


class _Component:
    """One component's part of a step: others step `before` it, and wait for the outputs `asked`.

    It sets the held inputs, steps, and brings the outputs that are asked for to the end.
    """

    def __init__(
        self,
        network: Network,
        name: str,
        *,
        before: Container[str],
        asked: Sequence[Port],
        held: np.ndarray,
    ) -> None:
        instance, own = network.instances[name], network.input_slice(name)
        inputs = network.links_to(name)
        steps = network.steps(name)
        if network.due(name):
            noted = (gather(held[own], network.inputs, range(own.start, own.stop)),)
            self._formulas: list[tuple[Combine, list[Formula]]] = []
            self.operations = (*(noted if inputs else ()), *network.whole_step(name))
            return
        names = [link.target.variable for link in inputs]
        signals = [_signal(network, link, before) for link in inputs]
        moved = network.moved(name)
        self._ends = _combination(np.zeros(len(inputs)), network.values)  # pyrefly: ignore[possibly-uninitialized-attribute]
        self._formulas = [(self._ends, [signal.end for signal in signals])]
        operations: list[Operation] = []
        into = held[own]
        for step in steps:
            if inputs and (step is steps[0] or moved):
                into = held[own] if step is steps[0] else np.zeros(len(inputs))
                combined = _combination(into, network.values)
                self._formulas.append((combined, _held(names, signals, moved, step.start)))
                operations += [combined, *setting(instance, inputs, into)]
            operations.append(step)
        operations += network.arrival(name)
        operations += network.reread(name, network.hold(name, into, moved))
        late = slice(network.early(name).stop, network.output_slice(name).stop)
        if not set(asked).isdisjoint(network.outputs[late]):
            names = tuple(port.variable for port in network.outputs[late])
            if inputs:
                operations += [self._ends, *setting(instance, inputs, self._ends.into)]
            reading = Get(instance, names, network.values[network.stepped :][late])
            operations += network.read_late(name, reading)
        self.operations = tuple(operations)

    def prepare(self, size: float, last: float) -> None:
        """Coefficients for a step of `size` [s] after one of `last` [s]."""
        for combined, formulas in self._formulas:
            _fill(combined, [formula(size, last) for formula in formulas])


@dataclass(frozen=True)
class _Source:
    """Positions of the values of one source in `Network.values`.

    `stepped` is its end-of-step value, None if its component steps later; `rate` and `curvature`
    are its declared first and second time derivative now, None if not declared. The value is
    constant within the step if `stays`.
    """

    now: int
    before: int
    stepped: int | None
    rate: int | None
    curvature: int | None
    stays: bool = False

    def mean(self, size: float, last: float) -> Terms:
        """Mean over a step of `size` [s] after one of `last` [s] (0: there was none)."""
        if self.stays:
            return {self.now: 1.0}
        if self.stepped is not None:
            return self._parabola_mean(self.stepped, size, last)
        if self.rate is not None:
            return self._taylor(size / 2, size**2 / 6)
        return self._line(size / 2, last)

    def along(self, share: float, size: float, last: float) -> Terms:
        """Value at a share of the step on the straight line to its end."""
        if share == 0.0:
            return {self.now: 1.0}
        terms = {index: share * factor for index, factor in self.end(size, last).items()}
        terms[self.now] = terms.get(self.now, 0.0) + 1.0 - share
        return terms

    def end(self, size: float, last: float) -> Terms:
        """Value at the end of the step."""
        if self.stays:
            return {self.now: 1.0}
        if self.stepped is not None:
            return {self.stepped: 1.0}
        if self.rate is not None:
            return self._taylor(size, size**2 / 2)
        return self._line(size, last)

    def slope(self, size: float, last: float) -> Terms:
        """Mean slope over the step: (end − now)/size."""
        terms = {index: factor / size for index, factor in self.end(size, last).items()}
        terms[self.now] = terms.get(self.now, 0.0) - 1.0 / size
        return terms

    def _parabola_mean(self, stepped: int, size: float, last: float) -> Terms:
        if last == 0.0:
            return {self.now: 0.5, stepped: 0.5}
        # quadratic coefficient c of the parabola; mean = (now + stepped)/2 − c size²/6
        total = size + last
        weight = size**2 / 6
        return {
            stepped: 0.5 - weight / (size * total),
            self.now: 0.5 + weight / (size * last),
            self.before: -weight / (last * total),
        }

    def _taylor(self, first: float, second: float) -> Terms:
        assert self.rate is not None
        terms = {self.now: 1.0, self.rate: first}
        if self.curvature is not None:
            terms[self.curvature] = second
        return terms

    def _line(self, ahead: float, last: float) -> Terms:
        if last == 0.0:
            return {self.now: 1.0}
        return {self.now: 1.0 + ahead / last, self.before: -ahead / last}


def _held(
    names: Sequence[str], signals: Sequence[_Source], moved: Mapping[str, str], share: float
) -> list[Formula]:
    """Formulas of the values held in a piece of the step that begins at this share of it.

    The `signals` lead to inputs of these `names`, of which some are `moved` along others.
    """
    driver = {u: w for w, u in moved.items()}
    formulas: list[Formula] = []
    for variable, signal in zip(names, signals, strict=True):
        if variable in moved:
            formulas.append(partial(signal.along, share))
        elif variable in driver:
            formulas.append(signals[names.index(driver[variable])].slope)
        else:
            formulas.append(signal.mean)
    return formulas


def _signal(network: Network, link: Link, before: Container[str]) -> _Source:
    """The source of a link, as seen by its target's component."""
    known = network.held_place(link)
    if known is not None:
        return _Source(known, known, stepped=None, rate=None, curvature=None, stays=True)
    now, *rates = (network.index(port) for port in network.derivatives(link.source))
    rate, curvature = (*rates, None, None)[:2]
    return _Source(
        now=now,
        before=network.before + now,
        stepped=network.stepped + now if link.source.component in before else None,
        rate=rate,
        curvature=curvature,
        stays=network.due(link.source.component) is not None,
    )


def _combination(into: np.ndarray, source: np.ndarray) -> Combine:
    shape = (MOST_TERMS, len(into))
    return Combine(into, source, np.zeros(shape, dtype=np.uint32), np.zeros(shape))


def _fill(combination: Combine, rows: Sequence[Terms]) -> None:
    """Put the terms of each row into place; those that it has not have weight 0."""
    combination.index[:] = 0
    combination.weight[:] = 0.0
    for row, terms in enumerate(rows):
        for k, (index, weight) in enumerate(sorted(terms.items())):
            combination.index[k, row] = index
            combination.weight[k, row] = weight


ALGORITHM = AlgorithmDescriptor(
    name="gauss_seidel",
    summary="components step one after the other, with the means of their inputs held",
    order=GaussSeidel.order,
    link_delay=LinkDelay.EXECUTION_ORDER,
    needs_rollback=False,
    stability=0,
    make=GaussSeidel,
)
