"""Notes on systems at rest and in motion: motions that grow, outputs beyond their limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.linearization import Linearization, Linearizer
from m4e_fmi.analysis.modes import NEGLIGIBLE, modes
from m4e_fmi.analysis.points import Evaluation, Floats, OperatingPoint, local_parts, observed
from m4e_fmi.errors import RunError
from m4e_fmi.program import Program, Variable
from m4e_fmi.simulate import Simulation

ROUNDING = 1e-9
"""Share of limits and values by which an output may be outside by rounding."""
HALVINGS = 6
"""Of the errors of slopes, within which some are sought with which no motion grows."""


@dataclass(frozen=True)
class MotionGrowth:
    """The fastest growth of a motion about a point, at a `rate` [1/s].

    `within` names settled components, with other slopes of which, within their errors, it would
    not grow; "" where it grows certainly.
    """

    rate: float
    within: str = ""

    def __str__(self) -> str:
        if self.within:
            return (
                f"neutral within the error of K of {self.within}: a motion grows "
                f"({self.rate:.3g} 1/s), and with another K within that error it does not"
            )
        return f"a motion grows ({self.rate:.3g} 1/s)"


def growth(linear: Linearization) -> MotionGrowth | None:
    """The growth of motions about the point of `linear`; None if no motion grows."""
    found = modes(linear)
    if found.stable:
        return None
    values = found.eigenvalues.real
    rate, changes = float(np.max(values)), list(_changes(linear))
    for k in np.flatnonzero(values > NEGLIGIBLE * np.max(found.frequencies)):
        left, right = found.left[:, k].conj(), found.right[:, k]
        turned = np.zeros_like(linear.A)
        for change in changes:
            turned -= np.sign((left @ change @ right).real) * change
        parts = (0.5**n for n in range(HALVINGS))
        if not any(_growing(linear.A + part * turned) < _growing(linear.A) for part in parts):
            return MotionGrowth(rate)
    return MotionGrowth(rate, ", ".join(part.name for part, _ in local_parts(linear.point.program)))


def _growing(A: Floats) -> int:
    """The number of eigenvalues of A (n, n) [SI] whose motions grow."""
    values = np.linalg.eigvals(A)
    return int(np.sum(np.real(values) > NEGLIGIBLE * np.max(np.abs(values))))


def _changes(linear: Linearization) -> Iterator[Floats]:
    """The change of A (n, n) [SI] by the error of each parameter of a local law."""
    point, again = linear.point, None
    for part, law in local_parts(point.program):
        for name, error in law.errors.items():
            if error:
                again = again or Linearizer(point.program)
                parameter = f"{part.name}.{name}"
                moved = point.with_values({parameter: point.values[parameter] + error})
                yield again.at(moved).A - linear.A


def rest_notes(point: OperatingPoint) -> list[str]:
    """Lines on what is doubtful about an equilibrium."""
    notes = list(_beyond(point))
    try:
        found = growth(Linearizer(point.program).at(point))
    except RunError as error:
        return [*notes, f"it is not known if it is stable: {error.message}"]
    if found is None:
        return notes
    return [*notes, str(found) if found.within else f"the equilibrium is unstable: {found}"]


def limited(program: Program) -> tuple[Variable, ...]:
    """The outputs with a declared limit; not those that are rates."""
    return tuple(
        v
        for v in program.outputs
        if v.derivative_of is None and np.isfinite([v.minimum, v.maximum]).any()
    )


def limits_left(motion: Simulation) -> Iterator[str]:
    """Lines on outputs that leave their limits in the rows of a motion, with the first time."""
    time = motion.time.values
    for v in limited(motion.program):
        if v.name not in motion.values:
            continue
        values = motion[v.name].values
        scale = np.nanmax(np.abs(values[np.isfinite(values)]), initial=0.0)
        near = ROUNDING * max(scale, *(abs(b) for b in (v.minimum, v.maximum) if np.isfinite(b)))
        outside = (values < v.minimum - near) | (values > v.maximum + near)
        if outside.any():
            row = int(np.argmax(outside))
            yield (
                f"{v.name} is {values[row]:.4g} {v.unit} at t = {time[row]:.9g} s, outside of "
                f"{limits_of(v)}"
            )


def limits_of(v: Variable) -> str:
    """Words on the limits of a variable, and on what it is."""
    return f"its limits, {v.minimum:.3g} to {v.maximum:.3g} {v.unit}: {v.description}"


def _beyond(point: OperatingPoint) -> Iterator[str]:
    """Lines on outputs that are not within their limits."""
    variables = limited(point.program)
    if not variables:
        return
    values = Evaluation(observed(point.program, [v.name for v in variables])).at(point)
    for v, value in zip(variables, values, strict=True):
        if not v.minimum <= value <= v.maximum:
            yield f"{v.name}: {value:.3g} {v.unit} is outside of {limits_of(v)}"
