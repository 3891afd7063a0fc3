"""Equilibria with given properties: the ballast for a draft, the stiffness for a frequency.

Newton's method on the parameters that may vary, with the exact derivatives of the equilibrium that
moves with them, and of its eigenvalues (`sensitivity`); after each step the equilibrium and its
modes are found anew. A mode is the one of its number, in the order of `modes`, at every step: where
two change places, so do their values, and the result has the mode of that number.

Where the values fix the whole pose, inputs follow from the balance there alone, which is linear in
efforts.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.balance import Balance
from m4e_fmi.analysis.equilibrium import TINY, balanced, resting
from m4e_fmi.analysis.local_laws import ROUNDING, followed
from m4e_fmi.analysis.modes import Modes, modes
from m4e_fmi.analysis.points import (
    At,
    Evaluation,
    Floats,
    Matrix,
    OperatingPoint,
    System,
    causes,
    local_parts,
    observed,
    operating_point,
    program_and_model,
)
from m4e_fmi.analysis.sensitivity import EigenvalueSensitivity, Sensitivities
from m4e_fmi.errors import InputError, M4eError, Problem, RunError
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
_MODE = re.compile(r"mode (\d+)(?: (frequency|damping)(?: ratio)?)?")


@dataclass(frozen=True)
class _OfMode:
    """A natural frequency |λ| [Hz], or with `damps` a damping ratio, by the number of a mode."""

    number: int
    damps: bool

    @classmethod
    def named(cls, name: str) -> _OfMode | None:
        """That of a name as ``mode 1 frequency``, ``mode 1 damping``; None for other names."""
        match = _MODE.fullmatch(" ".join(name.split()))
        return cls(int(match[1]), match[2] == "damping") if match else None

    def __str__(self) -> str:
        return f"mode {self.number} {'damping ratio' if self.damps else 'frequency [Hz]'}"

    def wanted(self, given: float | str) -> float:
        """A given value as a number in Hz or 1; ValueError with the reason if it is wrong."""
        if self.damps:
            value, low, high = number_in("1", given), -1.0, 1.0
        elif isinstance(given, str):
            unit, size = ("rad/s", 2.0 * np.pi) if "rad" in given else ("Hz", 1.0)
            value, low, high = number_in(unit, given) / size, 0.0, np.inf
        else:
            raise ValueError(f"it has no unit: write '{given} Hz' or '{given} rad/s'")
        if not low < value < high:
            raise ValueError(f"it must be between {low:g} and {high:g}")
        return value

    def of(self, found: Modes | EigenvalueSensitivity) -> Floats:
        """Its value [Hz or 1]; or its derivatives by the parameters (n,), in SI."""
        k = self.number - 1
        return found.damping_ratios[k] if self.damps else found.frequencies[k] / (2.0 * np.pi)

    def value(self, point: OperatingPoint, found: Modes) -> float:
        """Its value; InputError if there is no mode of its number, RunError without oscillation."""
        name, count = point.program.name, len(found.eigenvalues)
        if not 0 < self.number <= count:
            message = f"{name}: there is no mode {self.number} among its {count}"
            raise InputError.single(message, "`m4e-fmi linearize` shows them by number")
        if not found.eigenvalues[self.number - 1].imag:
            message = f"{name}: mode {self.number} does not oscillate where the search begins"
            raise RunError(message, "`m4e-fmi linearize` shows which do; start with less damping")
        return float(self.of(found) + 0.0)  # no -0


def trimmed(
    system: System,
    *,
    such_that: Mapping[str, float | str],
    vary: Sequence[str],
    at: At = None,
    time: float | None = None,
    nearest: bool = False,
) -> OperatingPoint:
    """The equilibrium with `such_that` outputs, states or modes at their values, by `vary`.

    These are parameters and inputs, as many as there are values; they start from `at`, and stay
    within their limits. Values are in SI or texts with a unit, as ``"25 cm"``. Modes are named as
    ``mode 1 frequency``, with a value as ``"2 Hz"``, and ``mode 1 damping``, with a ratio, by the
    numbers of `modes` from 1: those that have them in the equilibrium found. The other arguments
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
    of_modes = {name: found for name in such_that if (found := _OfMode.named(name))}
    plain = [name for name in such_that if name not in of_modes]
    wrong = [name for name in plain if name.split()[:1] == ["mode"]]
    remedy = "write 'mode 1 frequency' or 'mode 1 damping', by its number in `m4e-fmi linearize`"
    InputError.raise_for(Problem(f"{name!r} names nothing of a mode", remedy) for name in wrong)
    units = {v.name: v.unit for v in observed(program, plain).outputs}
    varied = causes(program, vary, states=False)
    problems, wanted = [], list[float]()
    for name in [*plain, *of_modes]:
        given = such_that[name]
        try:
            mode = of_modes.get(name)
            wanted.append(mode.wanted(given) if mode else number_in(units[name], given))
        except ValueError as error:
            problems.append(Problem(f"the value {given!r} of {name} is wrong", str(error)))
    if len(varied) != len(such_that):
        message = f"{len(such_that)} values are given, {len(varied)} parameters may vary"
        problems.append(Problem(f"{program.name}: {message}", "name one parameter for each value"))
    InputError.raise_for(problems)
    targets = list(of_modes.values())
    search = _Search(program, plain, targets, np.array(wanted), vary, nearest=nearest)
    start = operating_point(program, at, time=time, model=model)
    limits = [(v.minimum, v.maximum) for v in varied]
    return search.held(start, limits) or search.found(start, limits)


class _Search:
    """Newton's method for the parameters.

    `wanted` (n,) are the values of the outputs `of`, in SI, and then of the `modes`.
    """

    def __init__(
        self,
        program: Program,
        of: Sequence[str],
        modes: Sequence[_OfMode],
        wanted: np.ndarray,
        by: Sequence[str],
        *,
        nearest: bool,
    ) -> None:
        self._by, self._wanted, self._nearest = list(by), wanted, nearest
        self._modes, self._names = modes, [*of, *map(str, modes)]
        self._balance = Balance(program)
        self._is_measured = bool(local_parts(program))
        self._has_unknown_slopes = self._is_measured and bool(modes)
        self._close = np.array(
            [ACCURACY] * len(of) + [ROUNDING if self._is_measured else ACCURACY] * len(modes)
        )
        self._slopes = Sensitivities(program, of=of, by=by, moving=True)
        self._values = Evaluation(observed(self._slopes.program, of))
        smallest = [0.0 if name.endswith("[Hz]") else 1.0 for name in self._names]
        self._sizes = np.maximum(np.abs(wanted), smallest)

    def held(
        self, start: OperatingPoint, limits: Sequence[tuple[float, float]]
    ) -> OperatingPoint | None:
        """The pose that the values fix, with the inputs that hold it, by Newton's method for these.

        None where values do not fix the pose in one step, where others than inputs vary, where
        values of modes are wanted, and where the balance is not met.
        """
        program, balance = start.program, self._balance
        known = {v.name for v in program.inputs}.issuperset(self._by) and not self._is_measured
        if not known or self._modes or len(self._names) != len(balance.unknown_names):
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
        off, slopes = self._off(point), self._slopes_at(point)
        for _ in range(MOST_STEPS):
            if (np.abs(off) <= self._close).all():
                return point
            now = np.array([point.values[name] for name in self._by])
            step, part = self._step(point, slopes, off), 1.0
            while True:
                values = np.clip(now + part * step, low, high)
                nearer = self._settled(point, values)
                if nearer is not None:
                    ahead, left = nearer
                    slopes = self._corrected(slopes, values - now, off - left)
                    if np.linalg.norm(left) <= (1.0 - part / 4.0) * np.linalg.norm(off):
                        break
                    if self._has_unknown_slopes:
                        step = self._step(point, slopes, off)
                part /= 2.0
                if part < SHORTEST:
                    if self._is_measured and np.max(np.abs(off)) <= ROUNDING:
                        return point
                    raise self._lost(point)
            point, off = ahead, left
            if not self._has_unknown_slopes:
                slopes = self._slopes_at(point)
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
        return (self._wanted - self._found(point)) / self._sizes

    def _found(self, point: OperatingPoint) -> np.ndarray:
        """The values at a point (n,) that have targets."""
        found = modes(self._slopes.linearizer.at(point)) if self._modes else None
        of_modes = [mode.value(point, found) for mode in self._modes if found]
        return np.append(self._values.at(point), of_modes)

    def _slopes_at(self, point: OperatingPoint) -> np.ndarray:
        """Derivatives (n, n) of the values, over their sizes, by the parameters, in SI."""
        slopes = self._slopes.at(point).values
        if self._modes:
            found = self._slopes.of_eigenvalues(point, grouped=True)
            slopes = np.vstack([slopes, *(mode.of(found) for mode in self._modes)])
        slopes = slopes / self._sizes[:, None]
        if not np.isfinite(slopes).all():
            raise self._lost(point, "modes of one frequency there have no derivatives")
        return slopes

    def _corrected(self, slopes: np.ndarray, moved: np.ndarray, gained: np.ndarray) -> np.ndarray:
        """`slopes` (n, n) that fit the last step, if laws that are measured change in it.

        Parameters have `moved` (n,), in SI, by which the values, over their sizes, have `gained`
        (n,): C. G. Broyden, "A class of methods for solving nonlinear simultaneous equations",
        Math. Comp. 19 (1965), pp. 577–593.
        """
        along = np.sum(slopes**2, axis=0) * moved
        if not (self._has_unknown_slopes and along @ moved > 0.0):
            return slopes
        return slopes + np.outer(gained - slopes @ moved, along) / (along @ moved)

    def _step(self, point: OperatingPoint, slopes: np.ndarray, off: np.ndarray) -> np.ndarray:
        """The change of the parameters (n,), in SI."""
        columns = np.linalg.norm(slopes, axis=0)
        columns[columns == 0.0] = 1.0
        shares = np.linalg.svd(slopes / columns, compute_uv=False)
        if not shares[-1] > RANK * shares[0]:
            raise self._lost(point, "the parameters do not change them one by one")
        return np.linalg.solve(slopes / columns, off) / columns

    def _settled(
        self, point: OperatingPoint, values: np.ndarray
    ) -> tuple[OperatingPoint, np.ndarray] | None:
        """The equilibrium near `point` with other `values` of the parameters, and its `_off`.

        None without one, or without its modes.
        """
        ahead = point.with_values(dict(zip(self._by, values.tolist(), strict=True)))
        try:
            found = self._at_rest(ahead)
            return found, self._off(found)
        except (M4eError, np.linalg.LinAlgError):  # of rates that are not finite
            return None

    def _lost(self, point: OperatingPoint, why: str = "") -> RunError:
        left = ", ".join(
            f"{name} = {value:.6g} instead of {goal:.6g}"
            for name, value, goal in zip(self._names, self._found(point), self._wanted, strict=True)
        )
        by = ", ".join(f"{name} = {point.values[name]:.6g}" for name in self._by)
        because = f": {why}" if why else ""
        return RunError(
            f"{point.program.name}: no equilibrium with these values was found{because}; the "
            f"nearest has {left} with {by}",
            "start nearer, or let other parameters vary"
            + "; modes change their numbers where they cross" * bool(self._modes),
        )
