"""Symmetry that the data of a file have: planes of reflection, bodies of revolution.

What it forbids is noise of the panels, and made exactly 0, as of computed coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ALIKE = 0.01  # of the motions' own values: what symmetry forbids, and panels make
ROUND = 1e-3  # yaw's added mass over roll's, below which a body is one of revolution
LEAST = 1e-3  # of the largest of its kind, below which a motion's own value is noise
SAME_PLACE = 1e-6  # m, of coordinates of centres
SIGNS = {
    "y": np.array([1, -1, 1, -1, 1, -1]),
    "x": np.array([-1, 1, 1, 1, -1, -1]),
}
"""Signs of the motions in the mirror image in the plane of equal y, or x, of all centres."""


@dataclass(frozen=True)
class Symmetry:
    """`planes` ("y", "x") that the hulls of N bodies are their own mirror images in.

    `is_round`: all are bodies of revolution about one axis, which has both planes.
    """

    planes: tuple[str, ...]
    is_round: bool
    bodies: int

    @property
    def forbidden(self) -> np.ndarray:
        """Pairs of motions (6N, 6N), booleans, that do not feel each other."""
        found = np.zeros((6 * self.bodies,) * 2, dtype=bool)
        for plane in self.planes:
            signs = np.tile(SIGNS[plane], self.bodies)
            found |= np.not_equal.outer(signs, signs)
        return found

    @property
    def text(self) -> str:
        """One line on it; "" if there is none."""
        if not self.planes:
            return ""
        planes = " and ".join(f"a plane of equal {plane}" for plane in self.planes)
        what = "bodies of revolution about one axis" if self.is_round else f"hulls with {planes}"
        return (
            f"the data are those of {what}: couplings that this forbids, less than "
            f"{100 * ALIKE:g} % of the motions' own, are 0"
        )


def symmetry_of(matrices: tuple[np.ndarray, ...], centers: np.ndarray) -> Symmetry:
    """The symmetry that `matrices` (nω, 6N, 6N) have, A and B in SI units over the density.

    Motions are about the `centers` (N, 3) [m].
    """
    count = len(centers)
    planes = []
    for plane, axis in (("y", 1), ("x", 0)):
        signs = np.tile(SIGNS[plane], count)
        odd = np.not_equal.outer(signs, signs)
        if np.ptp(centers[:, axis]) < SAME_PLACE and _largest(matrices, odd) < ALIKE:
            planes.append(plane)
    is_round = len(planes) == 2 and _is_round(matrices[0], count)
    return Symmetry(tuple(planes), is_round, count)


def _largest(matrices: tuple[np.ndarray, ...], pairs: np.ndarray) -> float:
    """The largest value of some pairs of motions (6N, 6N), booleans, over the motions' own."""
    worst = 0.0
    for values in matrices:
        own = np.abs(values.diagonal(axis1=1, axis2=2)).max(axis=0)
        kinds = own.reshape(-1, 3).max(axis=1)
        size = np.sqrt(np.maximum(own, LEAST * np.repeat(kinds, 3)))
        size = np.where(size > 0, size, 1.0)
        worst = max(worst, float((np.abs(values) / np.outer(size, size) * pairs).max()))
    return worst


def _is_round(added_mass: np.ndarray, count: int) -> bool:
    """True if no yaw moves the water, and X and Y are alike."""
    own = np.abs(added_mass.diagonal(axis1=1, axis2=2)).max(axis=0).reshape(count, 6)
    for surge, sway, _, roll, pitch, yaw in own.tolist():
        if not (roll > 0 and yaw < ROUND * roll):
            return False
        if abs(surge - sway) > ALIKE * surge or abs(roll - pitch) > ALIKE * roll:
            return False
    return True
