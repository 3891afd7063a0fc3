"""Vectors, inertias and freedoms of space against matrices of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from m4e_fmi.space import (
    PLANE,
    TURN,
    Component,
    Freedom,
    Inertia,
    Rotation,
    Twist,
    Vector,
    add_force,
    cross,
    dot,
    minus,
    norm,
    outward,
    plus,
    swung,
    times,
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


class TestWhatIsAlwaysZero:
    """The integer 0 makes nothing but itself; other numbers count as they are."""

    def test_sums_and_products(self) -> None:
        assert (plus(0, 2.0), plus(2.0, 0), plus(1.0, 2.0)) == (2.0, 2.0, 3.0)
        assert (minus(0, 2.0), minus(2.0, 0), minus(1.0, 2.0)) == (-2.0, 2.0, -1.0)
        assert (times(0, 2.0), times(2.0, 0), times(1, 2.0), times(3.0, 2.0)) == (0, 0, 2.0, 6.0)
        assert isinstance(times(float("nan"), 0), int)
        assert isinstance(plus(0, 0.0), float)

    def test_a_planar_vector_stays_in_the_plane(self) -> None:
        a, b = (1.0, 0, 2.0), (3.0, 0, 4.0)
        assert isinstance(Rotation.about_y(0.3)(a)[1], int)
        assert all(isinstance(cross(a, b)[c], int) for c in (0, 2))
        assert all(isinstance(part, int) for part in cross((0, 1.0, 0), a)[1:2])


class TestVectors:
    def test_against_numpy(self) -> None:
        a, b, c = vector(), vector(), vector()
        assert cross(a, b) == pytest.approx(np.cross(a, b), abs=ROUNDING)
        assert dot(a, b) == pytest.approx(np.dot(a, b), abs=ROUNDING)
        assert swung(c, a, b) == pytest.approx(c + np.cross(a, b), abs=ROUNDING)
        assert outward(a, b) == pytest.approx(-np.cross(a, np.cross(a, b)), abs=ROUNDING)
        assert unit(a) == pytest.approx(np.array(a) / np.linalg.norm(a), abs=ROUNDING)
        assert norm(a) == pytest.approx(np.linalg.norm(a), abs=ROUNDING)

    def test_a_force_at_an_arm(self) -> None:
        force, arm, torque = vector(), vector(), vector()
        wrench: list[Any] = [1.0] * 6
        add_force(wrench, force, arm, torque)
        moment = 1 + np.array(torque) + np.cross(arm, force)
        assert wrench == pytest.approx([*(1 + np.array(force)), *moment], abs=ROUNDING)


FREEDOMS: dict[str, Freedom] = {
    **{f"component {c}": Component(c) for c in SPACE},
    "slide": Twist(unit(vector()), vector()),
    "hinge": Twist((0, 0, 0), vector(), turning=unit(vector())),
    "screw": Twist(vector(), vector(), turning=unit(vector())),
}


class TestInertia:
    def test_of_a_rigid_body(self) -> None:
        """It is felt at the origin as by Newton and Euler at the centre of gravity."""
        mass, arm, about = 2.5, vector(), definite()[:3, :3]
        second = about + mass * (np.dot(arm, arm) * np.eye(3) - np.outer(arm, arm))
        found = np.array(Inertia.rigid(mass, second.tolist(), arm, SPACE).H, float)
        block = np.zeros((6, 6))
        block[:3, :3], block[3:, 3:] = mass * np.eye(3), about
        assert found == pytest.approx(shift(arm).T @ block @ shift(arm), abs=ROUNDING)

    def test_of_a_rigid_body_in_the_plane(self) -> None:
        second = np.diag([7.0, 3.0, 9.0]).tolist()
        found = Inertia.rigid(2.0, second, (0.5, 0, 0.25), PLANE).H
        for a in SPACE:
            for b in SPACE:
                assert (a in PLANE and b in PLANE) or found[a][b] == 0
        inside = [[found[a][b] for b in PLANE] for a in PLANE]
        assert inside == [[2.0, 0, 0.5], [0, 2.0, -1.0], [0.5, -1.0, 3.0]]

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

    @pytest.mark.parametrize("symmetric", [True, False])
    @pytest.mark.parametrize("handed_on", [SPACE, (0, 1, 2, 3, 5)])
    def test_a_child(self, handed_on: tuple[int, ...], symmetric: bool) -> None:
        child, own, reach = definite(), definite(), vector()
        if not symmetric:
            child, own = child + RANDOM.uniform(-1, 1, (6, 6)), own + RANDOM.uniform(-1, 1, (6, 6))
        kept = np.zeros((6, 6))
        places = np.ix_(handed_on, handed_on)
        kept[places] = child[places]
        found = inertia(own, symmetric=symmetric)
        found.add_child(inertia(child, symmetric=symmetric), reach, handed_on, rotates=True)
        moved = shift(reach).T @ kept @ shift(reach)
        assert np.array(found.H) == pytest.approx(own + moved, abs=ROUNDING)


@pytest.mark.parametrize("name", FREEDOMS)
def test_the_column_of_a_lever_and_its_rate(name: str) -> None:
    """The motion of a point of the body at unit rate; its derivative by a small turn."""
    freedom, lever, growth = FREEDOMS[name], vector(), vector()
    expected = shift(lever) @ column(freedom)
    assert freedom.column(lever, spin=True) == pytest.approx(expected, abs=ROUNDING)
    assert freedom.column(lever, spin=False)[TURN:] == [0, 0, 0]
    rate = freedom.column_rate(growth)
    if isinstance(freedom, Component):
        turned, expected = None, shift(growth) @ column(freedom) - column(freedom)
        assert (rate is None) == (freedom.index < TURN)
    else:
        spin, both = np.array(freedom.omega), column(freedom)
        turned = np.concatenate([np.cross(spin, both[:3]), np.cross(spin, both[3:])])
        expected = turned + shift(growth) @ both - both
    assert np.array(rate or [0] * 6, float) == pytest.approx(expected, abs=ROUNDING)
