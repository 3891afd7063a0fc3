"""The tape: one node per operation, constants folded, what is undefined left to run time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from m4e_fmi.program import Scalar, Tape, atan2, maximum, sin, sqrt
from m4e_fmi.program.tape import BINARY


@pytest.fixture
def tape() -> Tape:
    return Tape()


@pytest.fixture
def x(tape: Tape) -> Scalar:
    return tape.symbol("x")


@pytest.fixture
def y(tape: Tape) -> Scalar:
    return tape.symbol("y")


def operation(scalar: Scalar) -> tuple:
    return scalar.tape.operations[scalar.index]


def test_the_same_operation_is_the_same_node(x: Scalar, y: Scalar) -> None:
    """Whatever its order where that does not count, and whichever of the two is a number."""
    first = sin(x * y) + sqrt(x)
    two, length = x.tape.constant(2), len(x.tape)
    assert (sqrt(x) + sin(y * x)).index == first.index
    assert len(x.tape) == length
    numpy: Any = np.float64(2.0)
    for one, other in (
        (2 - x, two - x), (2 / x, two / x), (2**x, two**x), (atan2(2, x), atan2(two, x)),
        (maximum(x, 2), maximum(x, two)), (numpy * x, two * x),
    ):  # fmt: skip
        assert one.index == other.index
    for name in sorted(set(BINARY) - {"add", "mul"}):
        assert x.record(name, y).index != y.record(name, x).index
    for index in range(len(x.tape)):
        assert all(a < index for a in x.tape.arguments(index))
    with pytest.raises(ValueError, match="two tapes"):
        x.record("add", Tape().symbol("x"))


class TestFolding:
    def test_what_is_undefined_is_left_to_run_time(self, tape: Tape) -> None:
        zero, one = tape.constant(0), tape.constant(1)
        assert operation(one / zero) == ("div", one.index, zero.index)
        assert operation(zero / zero) == ("div", zero.index, zero.index)
        assert operation(sqrt(tape.constant(-1)))[0] == "sqrt"
        assert operation(tape.constant(0.0) ** -0.5)[0] == "pow"
        assert operation(tape.constant(0.0) ** -2)[0] == "div"

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_constants_are_finite(self, tape: Tape, x: Scalar, value: float) -> None:
        with pytest.raises(ValueError, match="finite"):
            tape.constant(value)
        with pytest.raises(ValueError, match="finite"):
            x.record("add", value)


NO_BRANCH = r"use maximum\(x, 0\), minimum\(x, 0\) or sign"
NO_NUMBER = "use sin, sqrt, exp and the like"
ATTEMPTS: list[tuple[Callable[[Any], Any], str]] = [
    (lambda x: x > 0, NO_BRANCH), (lambda x: x <= 1.0, NO_BRANCH),
    (lambda x: max(x, 0.0), NO_BRANCH), (bool, NO_BRANCH),
    (math.sin, NO_NUMBER), (float, NO_NUMBER), (math.sqrt, NO_NUMBER),
]  # fmt: skip


@pytest.mark.parametrize(("attempt", "told"), ATTEMPTS)
def test_a_recorded_scalar_has_no_branches_and_is_no_number(
    attempt: Callable[[Any], Any], told: str
) -> None:
    """A comparison made while recording would freeze one of its two outcomes."""
    with pytest.raises(TypeError, match=told):
        attempt(Tape().symbol("x"))
