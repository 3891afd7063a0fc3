"""Quasi-Newton iteration on values that FMUs exchange, and the algebraic loops it solves.

The Jacobian is found once (by directional derivatives, where FMUs offer them, or by differences)
and kept from one instant to the next; each iteration improves it by Broyden's rank-one update, and
where that is not enough it is found anew. An iteration that does not converge is an error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.operations import LOST, Choose, Get, Operation, setting
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.wiring.links import PLAIN, Link, Port
from m4e_fmi.cosim.wiring.structure import AlgebraicLoop, Transfer
from m4e_fmi.errors import RunError
from m4e_fmi.program import is_singular
from m4e_fmi.shown import first_of

TOLERANCE = 1e-9
"""Residual over the size of its variable at which an iteration has converged."""
ROUGH = 1e-6
"""Residual, likewise, at which an iteration ends that comes no further: outputs are rough."""
ITERATIONS, RENEWALS, STUCK = 12, 3, 4
"""Iterations with one Jacobian; Jacobians found anew, before it is given up; and iterations after
which the residual must have halved."""
SINGULAR = 10 * TOLERANCE
"""Part of a pivot's terms that is left, below which `TOLERANCE` says nothing of the solution."""
MOST_NAMED = 4
"""Members of a loop that a message names."""
REMEDY = (
    "check the gains, the start values and the signs of the connections: it may have no solution; "
    "or write ', delayed' behind one of these connections, or list under `dependencies` the inputs "
    "on which the outputs really depend, if they are fewer"
)
DIFFERENCE = 1e-6
"""Step of a difference, over the scale of the variable."""
MISSED = 1e-6
"""Largest residual of a linear solution that counts as one, over the largest right-hand side."""
OF_NOMINAL = 0.01
"""Share of a variable's nominal value below which its size does not matter (FMI 2.0, 2.2.7)."""

Residual = Callable[[np.ndarray], np.ndarray]
Jacobian = Callable[[np.ndarray, np.ndarray, bool], np.ndarray]
"""Unknowns x, the residual there → matrix of its derivatives, (n, n) in the unknowns' units.

The third argument is true if one was found for this solution before, and was not good enough.
"""


class NotConvergedError(Exception):
    """The iteration failed after some `iterations`.

    `worst` is the index of the largest residual, `size` its scaled magnitude.
    """

    def __init__(self, worst: int, size: float, iterations: int) -> None:
        super().__init__(f"residual {size:.3g} at unknown {worst} after {iterations} iterations")
        self.worst, self.size, self.iterations = worst, size, iterations


@dataclass(eq=False)
class QuasiNewton:
    """Solves f(x) = x again and again, with a Jacobian that it keeps; `forget` drops it.

    `roughness` is the largest residual, over the size of its variable, that was left because the
    iteration came no further; 0 if all have converged.
    """

    _matrix: np.ndarray | None = None
    roughness: float = 0.0

    def forget(self) -> None:
        """Drop the Jacobian."""
        self._matrix = None

    def solve(
        self, residual: Residual, jacobian: Jacobian, x: np.ndarray, scale: np.ndarray
    ) -> np.ndarray:
        """The zero near `x` of `residual`, f(x) - x, all (n,) in the unknowns' units.

        `scale` (n,), in the unknowns' units, are the least sizes of the unknowns; `jacobian`, which
        gives derivatives (n, n) in the same units, may enlarge them in place. An unknown is as
        large as x and f(x) are, there. The last call of `residual` is the one at the zero.
        NotConvergedError if no zero is found.
        """
        r = residual(x)
        least = np.maximum(np.abs(x), np.abs(x + r))
        made, sizes = 0, np.abs(r) / np.maximum(scale, least)
        for renewal in range(RENEWALS):
            best = [float("inf")] * STUCK
            for _ in range(ITERATIONS):
                size = float(sizes.max(initial=0.0))
                if size <= TOLERANCE:
                    return x
                if not size < best[-STUCK] / 2:
                    break
                best.append(min(size, best[-1]))
                if self._matrix is None:
                    self._matrix = jacobian(x, r, renewal > 0)
                    r = residual(x)
                scaled = self._matrix * scale / scale[:, None]
                way = _solution(scaled, -r / scale)
                if not np.isfinite(way).all():
                    break
                x, made = x + way * scale, made + 1
                before, r = r, residual(x)
                missed = (r - before) / scale - scaled @ way
                scaled += np.outer(missed, way) / max(float(way @ way), 1e-300)
                self._matrix = scaled * scale[:, None] / scale
                sizes = np.abs(r) / np.maximum(scale, least)
            if float(sizes.max(initial=0.0)) <= ROUGH:
                self.roughness = max(self.roughness, float(sizes.max()))
                return x
            self.forget()
        raise NotConvergedError(int(sizes.argmax()), float(sizes.max()), made)


def _solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of the linear equations; the smallest least-squares solution if they are singular.

    Elimination does not mix unconnected unknowns: a motion that symmetry forbids stays zero.
    """
    try:
        found = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.linalg.lstsq(matrix, right, rcond=None)[0]
    size = np.abs(right).max(initial=0.0)
    if np.abs(matrix @ found - right).max(initial=0.0) <= MISSED * size:
        return found
    return np.linalg.lstsq(matrix, right, rcond=None)[0]


class LoopEquations(Restorable):
    """Inputs and outputs that depend on one another within an instant.

    `links` (of all those given) lead to the loop's inputs, `outputs` are its outputs; `solve` finds
    `input_values` (n_links,) that links carry, in their sources' units, and `output_values`
    (n_outputs,), in theirs; the FMUs then have them. `known` links carry values from outside.
    """

    restored = ("input_values", "output_values", "_newton", "is_started", "_scale")

    def __init__(
        self, instances: Mapping[str, Instance], loop: AlgebraicLoop, links: Iterable[Link]
    ) -> None:
        self.instances = instances
        into: dict[Port, list[Link]] = {}
        for link in links:
            into.setdefault(link.target, []).append(link)
        sets = [
            (t, [link for name in t.variables for link in into[Port(t.component, name)]])
            for t in loop.sets
        ]
        self.links = [link for _, own in sets for link in own]
        self.outputs = [Port(t.component, name) for t in loop.gets for name in t.variables]
        self.input_values = np.zeros(len(self.links))
        self.output_values = np.zeros(len(self.outputs))
        place = {port: k for k, port in enumerate(self.outputs)}
        inner = [k for k, one in enumerate(self.links) if one.source in place and not one.delayed]
        self._places, self._solved = np.array(inner), [self.links[k] for k in inner]
        self._source = [place[link.source] for link in self._solved]
        self.known = [link for link in self.links if link.source not in place or link.delayed]
        ends = np.cumsum([len(own) for _, own in sets])[:-1]
        views = np.split(self.input_values, ends)
        self._parts = [
            (instances[t.component], own, view) for (t, own), view in zip(sets, views, strict=True)
        ]
        operations: list[Operation] = [o for part in self._parts for o in setting(*part)]
        views = np.split(self.output_values, np.cumsum([len(t.variables) for t in loop.gets])[:-1])
        for t, view in zip(loop.gets, views, strict=True):
            operations.append(Get(instances[t.component], t.variables, view))
        self._evaluate = Schedule(operations)
        nominals = [
            instances[link.target.component].description.variables[link.target.variable].nominal
            for link in self._solved
        ]
        self._scale = OF_NOMINAL * np.array(nominals)
        self._newton = QuasiNewton()
        self.is_started = False

    @property
    def roughness(self) -> float:
        """The largest residual that was left, as of `QuasiNewton`."""
        return self._newton.roughness

    def solve(self, known: Mapping[Link, float]) -> None:
        """Bring inputs and outputs into agreement; RunError naming a variable if that fails.

        The values of the links that are `known` are in their sources' units.
        """
        if not self.is_started:
            self._read_start_values()
            self.is_started = True
        for place, link in enumerate(self.links):
            self.input_values[place] = known.get(link, self.input_values[place])
        guess = self.input_values[self._places]
        self._scale = np.maximum(self._scale, np.abs(guess))
        try:
            # derivatives are exact, and differences cannot be had better: none is found anew
            self._newton.solve(
                self._residual, lambda x, r, _: self._jacobian(x, r), guess, self._scale
            )
        except NotConvergedError as failure:
            port, time = self._solved[failure.worst].target, self._time
            raise RunError(
                f"the algebraic loop of {self._names} at t = {time:.9g} s is not solved after "
                f"{failure.iterations} iterations: {port} still differs from its source by "
                f"{failure.size:.3g} of its value",
                REMEDY,
            ) from failure

    def _read_start_values(self) -> None:
        """Take the inputs' own values as what their links carry, each an equal share of a sum."""
        for instance, links, view in self._parts:
            names = [link.target.variable for link in links]
            unique, own = tuple(dict.fromkeys(names)), np.zeros(len(set(names)))
            Schedule([Get(instance, unique, own, checked=False)]).run(instance.time)
            factor, offset = instance.scales.of([link.ends for link in links]) or PLAIN
            share = np.array([own[unique.index(name)] / names.count(name) for name in names])
            view[:] = (share - offset) / factor

    @property
    def _names(self) -> str:
        return first_of(dict.fromkeys(link.target for link in self.links), MOST_NAMED)

    def check_regular(self) -> None:
        """RunError if the loop is singular at its solution, so that there are others."""
        x = self.input_values[self._places]
        matrix = self._jacobian(x, self._residual(x))
        self._residual(x)  # the FMUs have the solution again
        if is_singular((-matrix).tolist(), least=SINGULAR):
            raise RunError(
                f"the algebraic loop of {self._names} is singular at t = {self._time:.9g} s: its "
                "equations have no single solution",
                REMEDY,
            )

    @property
    def _time(self) -> float:
        """The present time [s]."""
        return self.instances[self.links[0].target.component].time

    def _residual(self, x: np.ndarray) -> np.ndarray:
        self.input_values[self._places] = x
        self._evaluate.run(self._time)
        return self.output_values[self._source] - x

    def _jacobian(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        matrix = np.zeros((len(x), len(x)))
        for column, link in enumerate(self._solved):
            port, instance = link.target, self.instances[link.target.component]
            described = instance.description
            is_input = described.variables[port.variable].causality == "input"
            if not (is_input and described.directional_derivatives):
                delta = DIFFERENCE * max(abs(float(x[column])), float(self._scale[column]))
                moved = x.copy()
                moved[column] += delta
                matrix[:, column] = (self._residual(moved) - r) / delta
                continue
            for row, source in enumerate(self._source):
                output = self.outputs[source]
                if output.component == port.component:
                    slope = instance.directional_derivative(output.variable, port.variable)
                    matrix[row, column] = instance.scales.factor(link.ends) * slope
            matrix[column, column] -= 1.0
        return matrix


class SolvedLoop:
    """An algebraic loop within the exchange, whose solution goes into `values` and `inputs`.

    `outputs` are the places of its outputs in `values`, `into` those of its links in `inputs`;
    `known` the places in `values` of links that carry values from outside. All values are in the
    units of the links' sources. Of outputs that are read twice there are `readings` (see `Choose`).
    """

    def __init__(
        self,
        equations: LoopEquations,
        values: np.ndarray,
        inputs: np.ndarray,
        *,
        outputs: Sequence[int],
        into: Sequence[int],
        known: Mapping[Link, int],
        readings: Sequence[tuple[Transfer, np.ndarray]],
    ) -> None:
        self.equations = equations
        self._values, self._inputs, self._known = values, inputs, known
        self._outputs, self._into = np.array(outputs, np.intp), np.array(into, np.intp)
        place = dict(zip(equations.outputs, outputs, strict=True))
        self._readings: list[tuple[Transfer, np.ndarray, np.ndarray]] = []
        choices: list[Choose] = []
        for transfer, rows in readings:
            names, component = transfer.variables, transfer.component
            start = place[Port(component, names[0])]
            self._readings.append((transfer, values[start : start + len(names)], rows))
            instance, chosen = equations.instances[component], np.zeros(len(names))
            choices.append(Choose(instance, names, chosen, rows, checked=False))
        self._choose = Schedule(choices)

    def run(self, time: float) -> None:
        """Solve the loop at the present point, `time` [s].

        RunError if it fails, is singular at first, or setting its inputs loses outputs.
        """
        equations, values = self.equations, self._values
        is_first = not equations.is_started
        equations.solve({link: values[place] for link, place in self._known.items()})
        if is_first:
            equations.check_regular()
        values[self._outputs] = equations.output_values
        self._inputs[self._into] = equations.input_values
        for _, solved, readings in self._readings:
            readings[3] = solved
        self._choose.run(time)
        for transfer, _, (first, second, before, _, size, lost) in self._readings:
            gross = np.isfinite(before) & ~(np.abs(second - first) <= LOST * size)
            for name in np.array(transfer.variables)[(lost > 0) & gross]:
                raise RunError(
                    f"{transfer.component}.{name} at t = {time:.9g} s is lost when inputs are set, "
                    "so that the algebraic loop through it has no solution",
                    f"list the inputs on which it really depends under `dependencies` of "
                    f"{transfer.component} in the system file, as {{{name}: []}}",
                )
            lost[:] = 0  # noise of the FMU, with which the solution counts
