"""Notes on systems at rest and in motion: motions that grow, outputs beyond their limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.linearization import Linearization, Linearizer
from m4e_fmi.analysis.modes import NEGLIGIBLE, modes
from m4e_fmi.analysis.points import Evaluation, Floats, OperatingPoint, local_parts, observed
from m4e_fmi.errors import RunError
from m4e_fmi.simulate.limits import limited, limits_of

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


def _beyond(point: OperatingPoint) -> Iterator[str]:
    """Lines on outputs that are not within their limits."""
    variables = limited(point.program)
    if not variables:
        return
    values = Evaluation(observed(point.program, [v.name for v in variables])).at(point)
    for v, value in zip(variables, values, strict=True):
        if not v.minimum <= value <= v.maximum:
            yield f"{v.name}: {value:.3g} {v.unit} is outside of {limits_of(v)}"
