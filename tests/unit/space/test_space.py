"""Vectors, inertias and freedoms of space against matrices of numbers."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.space import (
    TURN,
    Component,
    Freedom,
    Inertia,
    Twist,
    Vector,
    cross,
    dot,
    norm,
    outward,
    swung,
    unit,
)

SPACE = tuple(range(2 * TURN))
RANDOM = np.random.default_rng(20261123)
ROUNDING = 1e-13


def vector() -> Vector:
    x, y, z = RANDOM.uniform(-1, 1, 3).tolist()
    return x, y, z


def tilde(arm: Vector) -> np.ndarray:
    """The matrix that makes arm × b of b."""
    return np.cross(np.array(arm), np.eye(3)).T


def shift(arm: Vector) -> np.ndarray:
    """The motion (a, α) of the point at `arm`, of that of the origin."""
    found = np.eye(6)
    found[:3, 3:] = -tilde(arm)
    return found


def definite() -> np.ndarray:
    """A symmetric positive definite matrix (6, 6), as that of a body with all that hangs on it."""
    root = RANDOM.uniform(-1, 1, (6, 6))
    return root @ root.T + 6 * np.eye(6)


def inertia(H: np.ndarray, *, symmetric: bool = True) -> Inertia:
    return Inertia(H.tolist(), SPACE, symmetric)


def column(freedom: Freedom) -> np.ndarray:
    return np.array(freedom.column((0, 0, 0), spin=True), float)


class TestVectors:
    def test_against_numpy(self) -> None:
        a, b, c = vector(), vector(), vector()
        assert cross(a, b) == pytest.approx(np.cross(a, b), abs=ROUNDING)
        assert dot(a, b) == pytest.approx(np.dot(a, b), abs=ROUNDING)
        assert swung(c, a, b) == pytest.approx(c + np.cross(a, b), abs=ROUNDING)
        assert outward(a, b) == pytest.approx(-np.cross(a, np.cross(a, b)), abs=ROUNDING)
        assert unit(a) == pytest.approx(np.array(a) / np.linalg.norm(a), abs=ROUNDING)
        assert norm(a) == pytest.approx(np.linalg.norm(a), abs=ROUNDING)


FREEDOMS: dict[str, Freedom] = {
    **{f"component {c}": Component(c) for c in SPACE},
    "slide": Twist(unit(vector()), vector()),
    "hinge": Twist((0, 0, 0), vector(), turning=unit(vector())),
    "screw": Twist(vector(), vector(), turning=unit(vector())),
}


class TestInertia:
    @pytest.mark.parametrize("symmetric", [True, False])
    def test_added_mass_at_an_arm(self, symmetric: bool) -> None:
        own, block, arm = definite(), RANDOM.uniform(-1, 1, (6, 6)), vector()
        block = block + block.T if symmetric else block
        found = inertia(own, symmetric=symmetric)
        found.add_at(block.tolist(), arm)
        moved = shift(arm).T @ block @ shift(arm)
        assert np.array(found.H) == pytest.approx(own + moved, abs=ROUNDING)

    @pytest.mark.parametrize("symmetric", [True, False])
    @pytest.mark.parametrize("name", FREEDOMS)
    def test_an_eliminated_acceleration(self, name: str, symmetric: bool) -> None:
        """The joint's own equation holds, and what is handed on is what is left of it."""
        H = definite() + (0 if symmetric else RANDOM.uniform(-0.5, 0.5, (6, 6)))
        freedom, f, a = FREEDOMS[name], RANDOM.uniform(-1, 1, 6), RANDOM.uniform(-1, 1, 6)
        own = inertia(H, symmetric=symmetric)
        out = own.eliminate(freedom, SPACE)
        along = column(freedom)
        free = along @ f / out.pivot
        motion = a.tolist()
        if isinstance(freedom, Component):  # what the parent has of it does not matter
            a[freedom.index] = 0.0
        value = out.value(free, motion)
        freedom.set(motion, value)
        felt = H @ np.array(motion) - f
        assert along @ felt == pytest.approx(0.0, abs=ROUNDING)
        own.reduce(out)
        left = list(out.column)
        reduced = np.zeros((6, 6))
        reduced[np.ix_(left, left)] = np.array(own.H)[np.ix_(left, left)]
        rest = np.array([f[c] - free * out.column.get(c, 0.0) for c in SPACE])
        handed = (reduced @ a - rest)[left]
        assert handed == pytest.approx(felt[left], abs=ROUNDING)
