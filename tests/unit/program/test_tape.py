"""The tape: one node per operation, constants folded, what is undefined left to run time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from m4e_fmi.program import Scalar, Tape, atan2, maximum, sin, sqrt
from m4e_fmi.program.tape import BINARY, LARGEST_UNROLLED_POWER, UNARY


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
    def test_neutral_and_absorbing_constants(self, tape: Tape, x: Scalar) -> None:
        for same in (x + 0, 0 + x, x - 0, x * 1, 1 * x, x / 1, x**1, -(0 - x)):
            assert same.index == x.index
        for negated in (0 - x, x * -1, -1 * x):
            assert operation(negated) == ("neg", x.index)
        for zero in (x * 0, 0 * x, 0 / x):
            assert tape.value(zero.index) == 0.0
        assert tape.value((x**0).index) == 1.0

    def test_operations_on_constants_are_computed(self, tape: Tape) -> None:
        half = tape.constant(0.5)
        for name, function in UNARY.items():
            assert operation(half.record(name)) == ("constant", function(0.5))
        for name, function in BINARY.items():
            assert operation(half.record(name, 0.25)) == ("constant", function(0.5, 0.25))

    def test_there_is_one_zero(self, tape: Tape) -> None:
        zero = tape.constant(-0.0)
        assert zero.index == tape.constant(0.0).index == (-tape.constant(0.0)).index
        assert math.copysign(1.0, operation(zero)[1]) == 1.0

    def test_what_is_undefined_is_left_to_run_time(self, tape: Tape) -> None:
        zero, one = tape.constant(0), tape.constant(1)
        assert operation(one / zero) == ("div", one.index, zero.index)
        assert operation(zero / zero) == ("div", zero.index, zero.index)
        assert operation(sqrt(tape.constant(-1)))[0] == "sqrt"
        assert operation(tape.constant(0.0) ** -0.5)[0] == "pow"
        assert operation(tape.constant(0.0) ** -2)[0] == "div"

    def test_what_overflows_is_left_to_run_time(self, tape: Tape) -> None:
        huge = tape.constant(1e308)
        assert operation(huge * 10)[0] == "mul"
        assert operation(tape.constant(1000.0).record("exp"))[0] == "exp"

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_constants_are_finite(self, tape: Tape, x: Scalar, value: float) -> None:
        with pytest.raises(ValueError, match="finite"):
            tape.constant(value)
        with pytest.raises(ValueError, match="finite"):
            x.record("add", value)


@pytest.mark.parametrize("exponent", [2, 3, -1, -3, LARGEST_UNROLLED_POWER])
def test_small_whole_powers_are_products(x: Scalar, exponent: int) -> None:
    power = x**exponent
    kinds = {operation(x.tape.scalar(k))[0] for k in x.tape.reachable([power.index])}
    assert kinds <= {"symbol", "constant", "mul", "div"}
    assert power.index == (x ** float(exponent)).index


def test_other_powers(x: Scalar, y: Scalar) -> None:
    assert operation(x**0.5) == ("sqrt", x.index)
    for exponent in (LARGEST_UNROLLED_POWER + 1, 1.5, -0.5, 1e300):
        assert operation(x**exponent)[0] == "pow"
    assert operation(x**y) == ("pow", x.index, y.index)
    assert (x ** x.tape.constant(2)).index == (x * x).index


def test_reachable_nodes_and_symbols(x: Scalar, y: Scalar) -> None:
    tape = x.tape
    used, unused = x * 2 + 1, sin(y)
    nodes = tape.reachable([used.index])
    assert used.index in nodes
    assert unused.index not in nodes
    assert nodes == sorted(nodes)
    assert tape.symbols_of(used.index) == {"x"}
    assert tape.symbols_of((used * unused).index) == {"x", "y"}
    assert tape.symbols_of((y * 0).index) == frozenset()
    assert tape.reachable([]) == []


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
