"""Wave directions of a file: all around, by symmetry of the data, or just those that it has.

Symmetry that the data of a file have: planes of reflection, bodies of revolution.

What it forbids is noise of the panels, and made exactly 0, as of computed coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients

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


AXES = {"y": 0.0, "x": 180.0}
"""The sum [deg] of a direction and its mirror image in the plane of equal y, or x."""
SPACING = 1e-3  # deg
TURNS = 5  # directions that describe a body of revolution
UNRESOLVED = 0.02  # highest harmonic over the largest, of directions that are too few


def with_directions(
    coefficients: Coefficients, directions: np.ndarray, table: np.ndarray, symmetry: Symmetry
) -> tuple[Coefficients, list[str]]:
    """The coefficients with the excitation `table` (nω, nβ, n) [N/m, N.m/m].

    It is that of `directions` (nβ,) [deg].

    In space with harmonics, if the directions go all around, as they are or by the `symmetry` of
    the data. Also what is to be told of that.
    """
    found = replace(coefficients, directions=directions, by_direction=table)
    if coefficients.dimensions == 2:
        return found, []
    omega, shown = coefficients.omega, ", ".join(f"{beta:g}" for beta in directions)
    ways = np.stack([coefficients.way(omega, beta) for beta in directions.tolist()], axis=1)
    relative, notes = table * ways.conj(), []
    if symmetry.is_round:
        notes.append(f"excitation of all directions follows from {directions[0]:g} deg by symmetry")
        directions, relative = _turned(float(directions[0]), relative[:, 0])
    else:
        for plane in symmetry.planes:
            if _is_even(relative, directions, plane):
                odd = np.ix_(_within(directions, plane), _odd(plane, relative.shape[2]))
                relative = relative.copy()
                relative[:, *odd] = 0.0
                if _spacing(directions) is None:
                    directions, relative = _mirrored(plane, directions, relative)
                    notes.append(f"wave directions are mirrored in the plane of equal {plane}")
    spacing = _spacing(directions)
    if spacing is None:
        text = f"the wave directions {shown} deg do not go all around in equal steps: only these"
        return found, [f"{text} can be used"]
    harmonics = _harmonics(directions, relative)
    notes.append(f"{len(directions)} wave directions go all around, in steps of {spacing:g} deg")
    if not symmetry.is_round:
        notes += _unresolved(omega, harmonics)
    return replace(coefficients, harmonics=harmonics), notes


def _spacing(directions: np.ndarray) -> float | None:
    """The step [deg] of `directions` (nβ,) [deg] that go all around in equal ones."""
    count = len(directions)
    step = 360.0 / count
    steps = np.diff(directions, append=directions[0] + 360.0)
    return step if count > 2 and np.abs(steps - step).max() < SPACING else None


def _harmonics(directions: np.ndarray, relative: np.ndarray) -> np.ndarray:
    """`Coefficients.harmonics` of the excitation (nω, nβ, n) relative to the bodies' centres."""
    most = (len(directions) - 1) // 2
    orders = np.arange(-most, most + 1)
    turns = np.exp(-1j * np.outer(orders, np.radians(directions))) / len(directions)
    return np.einsum("jb,wbn->wjn", turns, relative)


def _unresolved(omega: np.ndarray, harmonics: np.ndarray) -> list[str]:
    """A warning if the highest harmonics are not small."""
    size = np.abs(harmonics)
    largest = size.max(axis=(0, 1))
    relevant = largest > 1e-6 * np.repeat(largest.reshape(-1, 3).max(axis=1), 3)
    outer = np.maximum(size[:, 0], size[:, -1])[:, relevant] / largest[relevant]
    bad = np.flatnonzero((outer > UNRESOLVED).any(axis=1))
    if not len(bad):
        return []
    return [
        f"warning: the wave directions of the file are too few above {omega[bad[0]]:.3g} rad/s: "
        "between them the excitation is inaccurate; compute more directions"
    ]


def _turned(direction: float, relative: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions all around, and the excitation of bodies of revolution (nω, nβ, n) for them.

    `relative` (nω, n) is that for one `direction` [deg]. Across the wave there is none.
    """
    first = np.radians(direction)
    along, across = _in_axes(relative, -first), np.tile(SIGNS["y"] < 0, relative.shape[1] // 6)
    along[:, across] = 0.0
    directions = np.mod(direction + 360.0 * np.arange(TURNS) / TURNS, 360.0)
    directions = np.sort(directions)
    return directions, np.stack([_in_axes(along, a) for a in np.radians(directions)], axis=1)


def _in_axes(relative: np.ndarray, angle: float) -> np.ndarray:
    """Forces (nω, n) turned about Z by an `angle` [rad]."""
    found = relative.copy()
    cosine, sine = np.cos(angle), np.sin(angle)
    for first in (0, 3):
        x, y = relative[:, first::6], relative[:, first + 1 :: 6]
        found[:, first::6] = cosine * x - sine * y
        found[:, first + 1 :: 6] = sine * x + cosine * y
    return found


def _within(directions: np.ndarray, plane: str) -> np.ndarray:
    """True for the directions that lie in a plane."""
    return np.abs(np.mod(2 * directions - AXES[plane] + 180.0, 360.0) - 180.0) < SPACING


def _odd(plane: str, n: int) -> np.ndarray:
    return np.tile(SIGNS[plane] < 0, n // 6)


def _is_even(relative: np.ndarray, directions: np.ndarray, plane: str) -> bool:
    """True if waves along a plane of symmetry make no force across it."""
    within, odd = _within(directions, plane), _odd(plane, relative.shape[2])
    largest = np.abs(relative).max(axis=(0, 1))
    kinds = np.repeat(largest.reshape(-1, 3).max(axis=1), 3)
    forbidden = np.abs(relative[:, within][:, :, odd]).max(axis=(0, 1), initial=0.0)
    return bool((forbidden < ALIKE * kinds[odd]).all())


def _mirrored(
    plane: str, directions: np.ndarray, relative: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The directions with their mirror images, increasing, and the excitation for them."""
    signs = np.tile(SIGNS[plane], relative.shape[2] // 6)
    every = np.mod(np.concatenate([directions, AXES[plane] - directions]), 360.0)
    every[360.0 - every < SPACING] = 0.0
    table = np.concatenate([relative, relative * signs], axis=1)
    order = np.argsort(every, kind="stable")
    kept = order[np.diff(every[order], prepend=-1.0) > SPACING]
    return every[kept], table[:, kept]
