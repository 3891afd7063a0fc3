"""The quasi-Newton iteration by itself: scales, rough functions, equations without a solution."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from m4e_fmi.cosim.exchange.newton import ROUGH, NotConvergedError, QuasiNewton

Function = Callable[[np.ndarray], np.ndarray]


def solved(function: Function, scale: list[float], start: list[float] | None = None) -> np.ndarray:
    """The x at which function(x) = x, with Jacobians by differences."""
    newton = QuasiNewton()
    x = newton.solve(
        *parts(function, scale), np.array(start or [0.0] * len(scale)), np.array(scale)
    )
    assert newton.roughness <= ROUGH
    return x


def parts(function: Function, scale: list[float]) -> tuple[Function, Callable]:
    def residual(x: np.ndarray) -> np.ndarray:
        return function(x) - x

    def jacobian(x: np.ndarray, r: np.ndarray, *, again: bool) -> np.ndarray:
        del again
        steps = 1e-6 * np.diag(scale)
        return np.column_stack([(residual(x + step) - r) / step.max() for step in steps])

    return residual, jacobian


def test_what_is_zero_by_symmetry_stays_zero() -> None:
    """Three equations of 1e6 about the first unknown, a fourth that is not connected with them."""
    rng = np.random.default_rng(3)
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = rng.normal(size=(3, 3))
    matrix[3, 3] = 7.3
    found = solved(lambda x: matrix @ x + [1e6, 2.0, -3.0, 0.0], [1.0] * 4)
    assert found[3] == 0.0
    assert found[:3] == pytest.approx(np.linalg.solve(np.eye(3) - matrix[:3, :3], [1e6, 2.0, -3.0]))


@pytest.mark.parametrize("scale", [1.0, 1e-9])
def test_no_solution_is_never_taken_for_one(scale: float) -> None:
    """x + 0.1 = x: the iterates go far, and what they miss does not become small by that."""
    with pytest.raises(NotConvergedError) as caught:
        solved(lambda x: x[::-1] + 0.1, [scale, scale])
    assert caught.value.size > 1e-3


def test_a_jump_without_a_solution_is_never_taken_for_one() -> None:
    with pytest.raises(NotConvergedError):
        solved(lambda x: np.where(x < 1.0, 2.0, 0.0), [1.0])
