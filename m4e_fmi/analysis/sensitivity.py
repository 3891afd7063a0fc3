"""Exact sensitivities at a point: of outputs, rates and eigenvalues, by parameters.

A point that is an equilibrium moves with the parameters: rates r(q, p) = 0 give
dq/dp = −(∂r/∂q)⁻¹ ∂r/∂p, and what depends on q follows. An eigenvalue with eigenvectors v, w,
wᴴ v = 1, changes by wᴴ (dA/dp) v: P. Lancaster, "On eigenvalues of matrices dependent on a
parameter", Numerische Mathematik 6 (1964), pp. 377–387.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.analysis.balance import Balance
from m4e_fmi.analysis.linearization import Linearizer
from m4e_fmi.analysis.modes import Modes, modes
from m4e_fmi.analysis.points import (
    At,
    Floats,
    Lines,
    Matrix,
    OperatingPoint,
    System,
    causes,
    observed,
    operating_point,
    place,
    program_and_model,
    unit_by,
)
from m4e_fmi.program import Variable, jacobian
from m4e_fmi.shown import listing, table

REPEATED = 1e-6
"""Relative distance below which eigenvalues count as one, whose derivatives are not defined."""


@dataclass(frozen=True)
class Sensitivity:
    """d of[i] / d by[j] = values[i, j], in the unit of the one by that of the other."""

    of: tuple[Variable, ...]
    by: tuple[Variable, ...]
    values: Floats = field(repr=False)

    def __getitem__(self, names: tuple[str, str]) -> float:
        """By the names (of, by)."""
        return float(self.values[place(names[0], self.of), place(names[1], self.by)])

    def __repr__(self) -> str:
        rows = [
            (f"d({y.name})", f"/ d({p.name})", f"{self[y.name, p.name]:.6g}", unit_by(y, p))
            for y, p in product(self.of, self.by)
        ]
        return table("Sensitivity", "<<><", *rows)


@dataclass(frozen=True)
class EigenvalueSensitivity:
    """dλ_k / d by[j] = values[k, j]; nan for eigenvalues that are equal or zero."""

    modes: Modes
    by: tuple[Variable, ...]
    values: NDArray[np.complex128] = field(repr=False)

    @property
    def frequencies(self) -> Floats:
        """d|λ_k| / d by[j], shape (modes, by) [rad/s by the unit of by]."""
        eigenvalues = self.modes.eigenvalues[:, None]
        with np.errstate(invalid="ignore"):
            return (eigenvalues.conj() * self.values).real / np.abs(eigenvalues)

    @property
    def damping_ratios(self) -> Floats:
        """d(−Re λ_k/|λ_k|) / d by[j], shape (modes, by) [1 by the unit of by]."""
        eigenvalues = self.modes.eigenvalues[:, None]
        with np.errstate(invalid="ignore"):
            ratios = -eigenvalues.real / np.abs(eigenvalues)
            return -(self.values.real + ratios * self.frequencies) / np.abs(eigenvalues)

    def __repr__(self) -> str:
        rows = [
            (
                f"mode {k + 1}, {omega:.6g} rad/s:",
                f"d|λ| / d({p.name})",
                f"{change:.6g}",
                f"(rad/s)/({p.unit})",
            )
            for k, omega in enumerate(self.modes.frequencies)
            for p, change in zip(self.by, self.frequencies[k], strict=True)
        ]
        return table("EigenvalueSensitivity", "<<><", *rows)


class Sensitivities:
    """Sensitivities of one system wherever they are asked for; derivatives are recorded once.

    `of` names outputs, states, or rates of states as ``der(name)``; `by` parameters, inputs or
    states. With `moving` every point has to be an equilibrium, as `equilibrium` finds them, and
    moves with what it is derived by; `by` cannot name states then. InputError for unknown names.
    """

    def __init__(
        self, system: System, *, of: Sequence[str] = (), by: Sequence[str], moving: bool = False
    ) -> None:
        self.program, self._model = program_and_model(system)
        self.by = causes(self.program, by, states=not moving)
        self.moving = moving
        self._balance = Balance(self.program)
        chosen = observed(self.program, of)
        self.of = chosen.outputs
        self._lines = Lines(self.program)
        self._slopes = Matrix(jacobian(chosen, "outputs", [*by, *self._moved]))
        if moving:
            self._pushes = Matrix(jacobian(self._balance.observed, "outputs", by))  # pyrefly: ignore[possibly-uninitialized-attribute]

    @cached_property
    def linearizer(self) -> Linearizer:
        """The linear equations whose eigenvalues are derived."""
        return Linearizer(self.program)

    @property
    def _moved(self) -> list[str]:
        """The states that move with the equilibrium."""
        return [self.program.states[k].name for k in self._balance.unknowns] if self.moving else []

    def at(self, at: At = None, *, time: float | None = None) -> Sensitivity:
        """Of `of` by `by` at a point; RunError where a force has no derivative."""
        point = operating_point(self.program, at, time=time, model=self._model)
        self._lines.check(point)
        slopes = self._slopes.at(point)
        n = len(self.by)
        return Sensitivity(self.of, self.by, slopes[:, :n] + slopes[:, n:] @ self._shift(point))

    def of_eigenvalues(
        self, at: At = None, *, time: float | None = None, grouped: bool = False
    ) -> EigenvalueSensitivity:
        """Of the eigenvalues of A at a point; by dA/dp, exact second derivatives.

        Equal ones have no derivatives; their mean has, which is given for each with `grouped`.
        """
        point = operating_point(self.program, at, time=time, model=self._model)
        found = modes(self.linearizer.at(point))
        names = [v.name for v in self.by]
        shift = self._shift(point)
        groups = _groups(found, grouped=grouped)
        columns = []
        for j, unit in enumerate(np.eye(len(names))):
            direction = dict(zip([*names, *self._moved], [*unit, *shift[:, j]], strict=True))
            change = self.linearizer.change(point, direction)
            columns.append([_mean_change(found, change, group) for group in groups])
        values = np.array(columns).T.reshape(len(found.eigenvalues), len(names))
        return EigenvalueSensitivity(found, self.by, values)

    def _shift(self, point: OperatingPoint) -> Floats:
        """Derivatives of the equilibrium: one row for each state of `_moved`."""
        if not self.moving:
            return np.zeros((0, len(self.by)))
        steps = self._balance.newton(point) @ self._pushes.at(point)
        return self._balance.tangent(point) @ steps

    def __repr__(self) -> str:
        return listing(f"Sensitivities of {self.program.name!r}", of=self.of, by=self.by)


def _groups(found: Modes, *, grouped: bool) -> list[NDArray[np.intp]]:
    """Of each eigenvalue those that equal it, with itself; none if it has no derivative.

    These are zeros, real ones that are about to oscillate, and unless `grouped` all that are equal.
    """
    values = found.eigenvalues
    near = REPEATED * np.max(found.frequencies, initial=0.0)
    groups = []
    for value in values:
        group = np.flatnonzero(np.abs(values - value) <= near)
        moves = value and (len(group) == 1 or grouped) and not 0.0 < 2.0 * value.imag <= near
        groups.append(group if moves and (value.imag or len(group) == 1) else group[:0])
    return groups


def _mean_change(found: Modes, change: Floats, group: NDArray[np.intp]) -> complex:
    """The change of the mean of a group of eigenvalues with a `change` of A; nan for none."""
    left, right = found.left[:, group].conj().T, found.right[:, group]
    if not group.size or np.linalg.cond(left @ right) > 1.0 / REPEATED:
        return complex(np.nan)
    return complex(np.trace(np.linalg.solve(left @ right, left @ change @ right)) / len(group))


def sensitivity(
    system: System,
    *,
    of: Sequence[str],
    by: Sequence[str],
    at: At = None,
    time: float | None = None,
    moving: bool = False,
) -> Sensitivity:
    """d of / d by of a system at a point; see `Sensitivities`."""
    return Sensitivities(system, of=of, by=by, moving=moving).at(at, time=time)


def eigenvalue_sensitivity(
    system: System,
    *,
    by: Sequence[str],
    at: At = None,
    time: float | None = None,
    moving: bool = False,
) -> EigenvalueSensitivity:
    """d λ / d by of a system linearised about a point; see `Sensitivities`."""
    return Sensitivities(system, by=by, moving=moving).of_eigenvalues(at, time=time)
