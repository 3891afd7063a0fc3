"""Equilibria with given properties: the ballast for a draft, the pretension for a place.

Newton's method on the parameters that may vary, with the exact derivatives of the equilibrium that
moves with them (`sensitivity`); after each step the equilibrium is found anew.

Where the values fix the whole pose, inputs follow from the balance there alone, which is linear in
efforts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from m4e_fmi.analysis.balance import Balance
from m4e_fmi.analysis.equilibrium import TINY, balanced, resting
from m4e_fmi.analysis.local_laws import ROUNDING, followed
from m4e_fmi.analysis.points import (
    At,
    Evaluation,
    Matrix,
    OperatingPoint,
    System,
    causes,
    local_parts,
    observed,
    operating_point,
    program_and_model,
)
from m4e_fmi.analysis.sensitivity import Sensitivities
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.program import Program, jacobian
from m4e_fmi.units import number_in

MOST_STEPS = 30
ACCURACY = 1e-10
"""Difference from a target, over the target or 1, at which it is met."""
SHORTEST = 1e-3
"""Part of a step below which the search is given up."""
RANK = 1e-12
"""Smallest over largest singular value, both scaled, below which parameters have no effect of their
own."""


def trimmed(
    system: System,
    *,
    such_that: Mapping[str, float | str],
    vary: Sequence[str],
    at: At = None,
    time: float | None = None,
    nearest: bool = False,
) -> OperatingPoint:
    """The equilibrium with `such_that` outputs or states at their values, by parameters `vary`.

    There are as many of the one as of the other; parameters and inputs start from `at`, and stay
    within their limits. Values are in SI or texts with a unit, as ``"25 cm"``. The other arguments
    are those of `equilibrium`. A whole pose, as of all joints, is held by inputs, such as efforts,
    stable or not; by parameters only if `equilibrium` finds it. InputError for unknown names and
    other counts, RunError with the rest of each target if no such equilibrium is found.
    """
    program, model = program_and_model(system)
    laws = {part.name for part, _ in local_parts(program)}
    known = {v.name for v in program.inputs}
    for name in vary:
        part, _, variable = name.partition(".")
        if part in laws and name not in known:  # nothing says what it does
            message = f"{program.name}: {name} cannot vary: {part} has no equations, from which "
            message += f"the effect of {variable} would follow"
            remedy = "vary another parameter, or try several start values of this one"
            raise InputError.single(message, remedy)
    targets = observed(program, list(such_that)).outputs
    varied = causes(program, vary, states=False)
    problems = []
    wanted = np.zeros(len(targets))
    for k, (v, given) in enumerate(zip(targets, such_that.values(), strict=True)):
        try:
            wanted[k] = number_in(v.unit, given)
        except ValueError as error:
            problems.append(Problem(f"the value {given!r} of {v.name} is wrong", str(error)))
    if len(varied) != len(targets):
        message = f"{len(targets)} values are given, {len(varied)} parameters may vary"
        problems.append(Problem(f"{program.name}: {message}", "name one parameter for each value"))
    InputError.raise_for(problems)
    search = _Search(program, [v.name for v in targets], wanted, vary, nearest=nearest)
    start = operating_point(program, at, time=time, model=model)
    limits = [(v.minimum, v.maximum) for v in varied]
    return search.held(start, limits) or search.found(start, limits)


class _Search:
    """Newton's method for the parameters; `wanted` (n,) are the values of the outputs `of`."""

    def __init__(
        self,
        program: Program,
        of: Sequence[str],
        wanted: np.ndarray,
        by: Sequence[str],
        *,
        nearest: bool,
    ) -> None:
        self._of, self._by, self._wanted, self._nearest = list(of), list(by), wanted, nearest
        self._balance = Balance(program)
        self._is_measured = bool(local_parts(program))
        self._slopes = Sensitivities(program, of=of, by=by, moving=True)
        self._values = Evaluation(observed(self._slopes.program, of))
        self._sizes = np.maximum(np.abs(wanted), 1.0)

    def held(
        self, start: OperatingPoint, limits: Sequence[tuple[float, float]]
    ) -> OperatingPoint | None:
        """The pose that the values fix, with the inputs that hold it, by Newton's method for these.

        None where values do not fix the pose in one step, where others than inputs vary, and where
        the balance is not met.
        """
        program, balance = start.program, self._balance
        known = {v.name for v in program.inputs}.issuperset(self._by) and not self._is_measured
        if not known or len(self._of) != len(balance.unknown_names):
            return None
        point = balance.at_rest(start)
        names = [program.states[k].name for k in balance.unknowns]
        by_states = Matrix(jacobian(self._values.program, "outputs", names))
        turns = by_states.at(point) @ balance.tangent(point)
        if np.linalg.matrix_rank(turns) < len(turns):
            return None
        point = balance.moved(
            point, np.asarray(np.linalg.solve(turns, self._off(point) * self._sizes), np.float64)
        )
        if not np.max(np.abs(self._off(point))) <= ACCURACY:
            return None
        pushes = Matrix(jacobian(balance.observed, "outputs", self._by))
        for _ in range(MOST_STEPS):
            with suppress(RunError, np.linalg.LinAlgError):
                slopes = pushes.at(point)
                columns = np.maximum(np.linalg.norm(slopes, axis=0), TINY)
                step = np.linalg.lstsq(slopes / columns, -balance.rates(point), rcond=RANK)[0]
                now = [point.values[name] for name in self._by]
                values = np.clip(now + step / columns, *np.array(limits).T)
                point = point.with_values(dict(zip(self._by, values.tolist(), strict=True)))
                return balanced(balance, point)
        return None

    def found(self, start: OperatingPoint, limits: Sequence[tuple[float, float]]) -> OperatingPoint:
        low, high = np.array(limits).T
        point = self._at_rest(start)
        off = self._off(point)
        for _ in range(MOST_STEPS):
            if np.max(np.abs(off)) <= ACCURACY:
                return point
            now = np.array([point.values[name] for name in self._by])
            step, part = self._step(point, off), 1.0
            while True:
                values = np.clip(now + part * step, low, high)
                ahead = self._settled(point, values)
                if ahead is not None:
                    left = self._off(ahead)
                    if np.linalg.norm(left) <= (1.0 - part / 4.0) * np.linalg.norm(off):
                        break
                part /= 2.0
                if part < SHORTEST:
                    if self._is_measured and np.max(np.abs(off)) <= ROUNDING:
                        return point
                    raise self._lost(point)
            point, off = ahead, left
        raise self._lost(point)

    def _at_rest(self, start: OperatingPoint) -> OperatingPoint:
        """The equilibrium from a point, with its parameters."""
        return followed(
            self._balance,
            start,
            lambda point: resting(self._balance, point, nearest=self._nearest),
        )

    def _off(self, point: OperatingPoint) -> np.ndarray:
        """The difference to each target (n,), over its size."""
        return (self._wanted - self._values.at(point)) / self._sizes

    def _step(self, point: OperatingPoint, off: np.ndarray) -> np.ndarray:
        """The change of the parameters (n,), in SI."""
        slopes = self._slopes.at(point).values / self._sizes[:, None]
        columns = np.linalg.norm(slopes, axis=0)
        columns[columns == 0.0] = 1.0
        shares = np.linalg.svd(slopes / columns, compute_uv=False)
        if not shares[-1] > RANK * shares[0]:
            raise self._lost(point, "the parameters do not change them one by one")
        return np.linalg.solve(slopes / columns, off) / columns

    def _settled(self, point: OperatingPoint, values: np.ndarray) -> OperatingPoint | None:
        """The equilibrium near `point` with other `values` of the parameters; None without one."""
        ahead = point.with_values(dict(zip(self._by, values.tolist(), strict=True)))
        try:
            return self._at_rest(ahead)
        except (RunError, np.linalg.LinAlgError):  # of rates that are not finite
            return None

    def _lost(self, point: OperatingPoint, why: str = "") -> RunError:
        left = ", ".join(
            f"{name} = {value:.6g} instead of {goal:.6g}"
            for name, value, goal in zip(
                self._of, self._values.at(point), self._wanted, strict=True
            )
        )
        by = ", ".join(f"{name} = {point.values[name]:.6g}" for name in self._by)
        because = f": {why}" if why else ""
        return RunError(
            f"{point.program.name}: no equilibrium with these values was found{because}; the "
            f"nearest has {left} with {by}",
            "start nearer, or let other parameters vary",
        )
