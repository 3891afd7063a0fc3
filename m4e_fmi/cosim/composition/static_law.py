"""The static law of an FMU about a point: y = y0 + K (u − u0).

Its kind may know it. Else the FMU is settled by steps with held inputs, until nothing changes any
more, and K is by differences of settled states.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.interruption import quiet, setting_up
from m4e_fmi.cosim.preparation.trial_instances import Instances, Subject
from m4e_fmi.errors import RunError
from m4e_fmi.fmu import OutputsAtRest
from m4e_fmi.fmu.importer.messages import Listener
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.program import Program, Recorder
from m4e_fmi.program import Variable as Quantity

STEPS, BRIEF = 128, 16
"""Steps with held inputs, of which outputs may not change in the second half; doubled until they do
not. `BRIEF` of an FMU that is at rest from its start at a point nearby."""
MOST_STEPS = 16384
"""Steps after which an FMU that still changes is given up."""
TOLERANCE = 1e-5
"""Change that is none, over the largest output of the same unit, or the nominal value."""
SWING = TOLERANCE**0.5
"""Swing, in the same way, about a mean that is the rest: what is not linear moves the mean of a
swing s by s² of its size, which is `TOLERANCE` then."""
LARGEST_STEP, SHARE = 0.1, 1e-3
"""First step of differences: of the input's nominal value, or of its value if that is more."""
MOST_HALVINGS = 12
ACCURATE = 1e-3
"""Error of a column of K, over its largest entry of the same unit, at which the step is kept."""
EVEN = 0.1
"""Half the difference of the slopes to both sides, in the same way, above which there is a kink."""
ROUGH = 0.02
"""The same, from which it is told."""
AT_REST = "at_rest."
"""Beginning of the names of the law's parameters."""


@dataclass(frozen=True)
class Rest:
    """Outputs at rest, `values` (n,) in the FMU's units, reached after `time` [s] and some `steps`.

    Without steps it is the start itself: nothing changed after it. With a `swing` [1], over the
    sizes of outputs, they are the mean of an oscillation that is left. `exact` ones, with their
    derivatives, are known without an FMU.
    """

    values: np.ndarray
    steps: int = 0
    time: float = 0.0
    swing: float = 0.0
    exact: bool = False


class AtRest:
    """The Real `outputs` of new instances of a component's FMU at rest, for values of inputs."""

    def __init__(self, new: Instances, outputs: Sequence[Variable]) -> None:
        self._new, self.outputs = new, outputs
        units = np.array([v.unit for v in outputs], dtype=str)
        self._alike = units[:, None] == units
        self._nominal = np.array([v.nominal for v in outputs])

    def largest(self, values: np.ndarray) -> np.ndarray:
        """The largest (n,) of `values` (n,) of outputs of the same unit, in the FMU's units."""
        return np.max(np.where(self._alike, np.abs(values), 0.0), axis=1, initial=0.0)

    def sizes(self, values: np.ndarray) -> np.ndarray:
        """The sizes (n,) of outputs `values` (n,), in the FMU's units."""
        return np.maximum(self.largest(values), self._nominal)

    def at(
        self, inputs: Mapping[str, float], *, brief: bool = False, listener: Listener | None = None
    ) -> Rest:
        """The rest with these `inputs`, in the FMU's units.

        With `brief`, fewer steps show that the start is at rest. RunError if it does not settle, or
        the FMU fails.
        """
        with (
            setting_up(),
            quiet(),
            self._new.instance(inputs, suffix="", listener=listener) as instance,
        ):
            subject = Subject(instance, [v.name for v in self.outputs], ())
            rows, count = [subject.read()], BRIEF if brief else STEPS
            while True:
                try:
                    while len(rows) <= count:
                        subject.step(self._new.step)
                        rows.append(subject.read())
                except RunError as error:
                    how = f"while {instance.name} was brought to rest, its inputs held"
                    remedy = f"{error.remedy}; or keep it open (--open {instance.name})"
                    raise RunError(f"{how}: {error.message}", remedy) from error
                seen = np.array(rows, dtype=float)
                limits = TOLERANCE * self.sizes(seen[-1])
                if (np.ptp(seen, axis=0) <= limits).all():
                    return Rest(seen[0])
                change = np.ptp(seen[count // 2 :], axis=0)
                if count >= STEPS and (change <= limits).all():
                    return Rest(seen[-1], count, count * self._new.step)
                if count >= STEPS and _is_steady(seen, limits):
                    mean, swing = _mean(seen[count // 2 :]), float(np.max(change / limits))
                    return Rest(mean, count, count * self._new.step, TOLERANCE * swing)
                if count >= MOST_STEPS:
                    raise self._restless(instance, count, change, change / limits)
                count *= 2

    def _restless(
        self, instance: Instance, count: int, change: np.ndarray, share: np.ndarray
    ) -> RunError:
        """The error of an FMU with outputs that `change` (n,), in its units, or by `share` (n,)."""
        order = np.argsort(-share)[:3]
        moving = ", ".join(
            f"{v.name} by {change[k]:.3g} {v.unit}".rstrip()
            for k in order
            if share[k] > 1.0 and (v := self.outputs[k])
        )
        time = count * self._new.step
        message = (
            f"{instance.name} ({instance.description.path.name}): it does not settle while its "
            f"inputs are held: in the second half of {count} steps ({time:g} s) still change "
            f"{moving}"
        )
        return RunError(message, f"keep it open (--open {instance.name})")


def _is_steady(seen: np.ndarray, limits: np.ndarray) -> bool:
    """True if outputs only swing, by little, about a constant mean.

    `seen` (s + 1, n) are the outputs over s steps, `limits` (n,) the negligible changes, in
    their units. The means of the second, third and fourth quarter agree, and
    the swing does not grow.
    """
    quarter = len(seen) // 4
    before, first, second = (seen[k * quarter : (k + 1) * quarter] for k in (1, 2, 3))
    means = np.array([_mean(part) for part in (before, first, second)])
    swings = [np.ptp(part, axis=0) for part in (before, first, second)]
    is_small = (swings[2] <= SWING / TOLERANCE * limits).all()
    is_growing = (swings[2] > np.maximum(swings[0], swings[1]) + limits).any()
    return bool(is_small and not is_growing and (np.ptp(means, axis=0) <= limits).all())


def _mean(part: np.ndarray) -> np.ndarray:
    """The mean (n,) of rows (s, n), by Hann's window: parts of a period hardly count."""
    weights = np.hanning(len(part) + 2)[1:-1]
    return weights @ part / weights.sum()


@dataclass(frozen=True)
class Inputs:
    """Connected Real inputs (and parameters) of a component.

    `moving` have an effect; `constant` are parameters, set once, by whose values the law is
    renewed; `rates` are velocities and accelerations, with their values at rest.
    """

    moving: Sequence[Variable]
    constant: Sequence[Variable]
    rates: Mapping[str, float]


class StaticLaw:
    """The law of a component, found anew wherever it is asked for; a `LocalLaw`.

    `statics` gives it by the values of all inputs, and None where the FMU is to be settled, of
    which `rest` then makes instances.

    Central differences with two step sizes h and 2h give K and its error. h is halved until nothing
    kinks between its ends (what rises to one side rises as much to the other: a line that falls
    slack does not), and further until the error is small or grows. `warn` receives a line for a K
    that is not accurate, `progress` one for each column of K.
    """

    def __init__(
        self,
        name: str,
        rest: Callable[[], AtRest],
        inputs: Inputs,
        warn: Callable[[str], None],
        progress: Callable[[str], object],
        *,
        outputs: Sequence[Variable],
        statics: Callable[[Mapping[str, float]], OutputsAtRest | None],
    ) -> None:
        self._name, self._settled, self._inputs, self._warn = name, rest, inputs, warn
        self._progress, self._outputs, self._statics = progress, outputs, statics
        self._known: dict[tuple[float, ...], Mapping[str, float]] = {}
        self._steps: dict[str, float] = {}
        self._errors: dict[str, float] = {}
        self.errors: Mapping[str, float] = {}
        self.last = Rest(np.zeros(0))
        """How the last point came to rest."""

    def parameters_at(self, inputs: Mapping[str, float]) -> Mapping[str, float]:
        """The parameters of `program` that hold about these inputs, in the FMU's units."""
        u = {v.name: inputs[v.name] for v in (*self._inputs.moving, *self._inputs.constant)}
        key = tuple(u.values())
        if key not in self._known:
            self._known[key] = self._exact(u) or self._measured(u)
        return self._known[key]

    @cached_property
    def _rest(self) -> AtRest:
        return self._settled()

    def _exact(self, u: Mapping[str, float]) -> dict[str, float] | None:
        """The parameters as the component's kind knows them; None if it does not."""
        found, moving = self._statics({**self._inputs.rates, **u}), self._inputs.moving
        if found is None or not (
            found.slopes.keys() >= {v.name for v in moving}
            and found.values.keys() >= {v.name for v in self._outputs}
        ):
            return None
        if not self._known:
            for line in found.warnings:
                self._warn(line)
        self.last, self.errors, self._steps = Rest(np.zeros(0), exact=True), {}, {}
        parameters = {at_rest(v): u[v.name] for v in moving}
        parameters |= {at_rest(v): found.values[v.name] for v in self._outputs}
        return parameters | {
            _slope(i, j): found.slopes[v.name].get(y.name, 0.0)
            for i, y in enumerate(self._outputs)
            for j, v in enumerate(moving)
        }

    def _measured(self, u: Mapping[str, float]) -> dict[str, float]:
        self.last = rest = self._at(u, listener=None if self._known else self._hear)
        moving, outputs = self._inputs.moving, self._outputs
        found = {at_rest(v): u[v.name] for v in moving}
        found |= {at_rest(v): float(y) for v, y in zip(outputs, rest.values, strict=True)}
        self.errors = {}
        for j, v in enumerate(moving):
            self._progress(f"{self._name}: forces at rest, by input {j + 1} of {len(moving)}")
            column = self._column(v, u, rest)
            errors = self._errors[v.name] * self._rest.largest(column)
            names = [_slope(i, j) for i in range(len(outputs))]
            found |= zip(names, column.tolist(), strict=True)
            self.errors |= zip(names, errors.tolist(), strict=True)
        for name, error in self._errors.items():
            if error > ROUGH:
                self._warn(
                    f"what it gives at rest has no sure derivative by {name} at {u[name]:.6g}: an "
                    f"error of {error:.2g} of its entries in K"
                )
        return found

    def _at(
        self, u: Mapping[str, float], *, brief: bool = False, listener: Listener | None = None
    ) -> Rest:
        return self._rest.at({**self._inputs.rates, **u}, brief=brief, listener=listener)

    def _hear(self, _: int, text: str) -> None:
        self._warn(text.removeprefix(f"{self._name}: "))

    def _column(self, v: Variable, u: Mapping[str, float], rest: Rest) -> np.ndarray:
        """Derivatives (n,) of the outputs by one input, in the FMU's units."""
        step = self._steps.get(v.name) or max(LARGEST_STEP * v.nominal, SHARE * abs(u[v.name]))
        column, _ = self._difference(v, u, step, rest)
        best: tuple[float, np.ndarray, float] | None = None
        for _ in range(MOST_HALVINGS):
            step /= 2.0
            finer, skew = self._difference(v, u, step, rest)
            error = self._share((finer - column) / 3.0, finer, step, rest)
            skewed = self._share(skew, finer, step, rest)
            column = finer
            if skewed > EVEN:
                error, best = skewed, None
            if best is not None and error >= best[0]:
                break
            best = error, finer, step
            if error <= ACCURATE:
                break
        assert best is not None
        self._errors[v.name], column, step = best
        self._steps[v.name] = 2.0 * step
        return column

    def _difference(
        self, v: Variable, u: Mapping[str, float], step: float, rest: Rest
    ) -> tuple[np.ndarray, np.ndarray]:
        """The mean slope (n,) to both sides, and half their difference (n,), in the FMU's units."""
        ends = []
        for sign in (1.0, -1.0):
            there = {**u, v.name: u[v.name] + sign * step}
            try:
                ends.append(self._at(there, brief=rest.steps == 0).values)
            except RunError as error:
                where = f"its static law needs {v.name} at {there[v.name]:.6g} {v.unit}".rstrip()
                raise RunError(f"{error.message} ({where})", error.remedy) from None
        ahead, behind = ends
        return (ahead - behind) / (2.0 * step), (ahead + behind - 2.0 * rest.values) / (2.0 * step)

    def _share(self, part: np.ndarray, column: np.ndarray, step: float, rest: Rest) -> float:
        """The largest of `part` (n,) over the largest entries of `column` (n,), the FMU's units."""
        noise = TOLERANCE * self._rest.sizes(rest.values) / step
        sizes = np.maximum(self._rest.largest(column), noise)
        return float(np.max(np.abs(part) / sizes, initial=0.0))

    def __str__(self) -> str:
        """How it was found, in words."""
        rest, units = self.last, {v.name: v.unit for v in self._inputs.moving}
        how = "at rest from its start"
        if rest.exact:
            how = "in static equilibrium, and about that y0 + K (u - u0), K exact"
        if rest.steps:
            how = f"settled in {rest.time:g} s with its inputs held"
        if rest.swing:
            how += f", to the mean of a swing of {100 * rest.swing:.2g} %"
        steps = dict.fromkeys(
            f"{step / 2.0:.3g} {units[name]}".rstrip() for name, step in self._steps.items()
        )
        if steps:
            worst = max(self._errors.values())
            how += (
                f", and about that y0 + K (u - u0), K by central differences of "
                f"{', '.join(steps)} (error {worst:.1g} of its entries)"
            )
        if not self._inputs.rates:
            return how
        return (
            f"{how}; velocities have no effect, its damping and inertia are left out: resonances "
            "come out too high, and at other periods"
        )


def at_rest(v: Variable) -> str:
    """The name of the parameter with the value of a variable at the point of the law."""
    return f"{AT_REST}{v.name}"


def _slope(row: int, column: int) -> str:
    """The name of the parameter with an entry of K."""
    return f"{AT_REST}slope[{row + 1},{column + 1}]"


def law_program(
    name: str, inputs: Inputs, every: Sequence[Variable], outputs: Sequence[Variable]
) -> Program:
    """The Program y = y0 + K (u − u0), whose parameters a `StaticLaw` finds; units are the FMU's.

    `every` are all inputs, also those without effect.
    """
    r = Recorder(name, f"Outputs of {name} at rest, linear about a point")
    known = {v.name for v in (*every, *outputs)}
    u = {v.name: r.input(_quantity(v, known)) for v in every}
    away = []
    for v in inputs.moving:
        text = f"{v.name} at the point"
        away.append(u[v.name] - r.parameter(Quantity(at_rest(v), v.unit or "1", text)))
    for i, y in enumerate(outputs):
        text = f"{y.name} at rest at the point"
        value = r.parameter(Quantity(at_rest(y), y.unit or "1", text))
        for j, (v, change) in enumerate(zip(inputs.moving, away, strict=True)):
            unit = f"({y.unit or '1'})/({v.unit or '1'})"
            text = f"Change of {y.name} at rest by {v.name}"
            value = value + r.parameter(Quantity(_slope(i, j), unit, text)) * change
        r.output(_quantity(y, known), value)
    return r.program()


def _quantity(v: Variable, known: set[str]) -> Quantity:
    """A variable of an FMU as one of a program."""
    of = v.derivative_of if v.derivative_of in known else None
    start = float(v.start or 0.0)
    return Quantity(v.name, v.unit or "1", v.description, start=start, derivative_of=of)
