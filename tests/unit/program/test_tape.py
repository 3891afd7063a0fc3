"""The tape: one node per operation, constants folded, what is undefined left to run time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from m4e_fmi.program import Scalar, Tape, atan2, maximum, minimum, sign, sin, sqrt
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


class TestHashConsing:
    def test_the_same_operation_is_the_same_node(self, x: Scalar, y: Scalar) -> None:
        first = sin(x * y) + sqrt(x)
        length = len(x.tape)
        assert (sin(x * y) + sqrt(x)).index == first.index
        assert len(x.tape) == length

    def test_sums_and_products_commute(self, x: Scalar, y: Scalar) -> None:
        assert (x + y).index == (y + x).index
        assert (x * y).index == (y * x).index

    @pytest.mark.parametrize("name", sorted(set(BINARY) - {"add", "mul"}))
    def test_nothing_else_commutes(self, x: Scalar, y: Scalar, name: str) -> None:
        assert x.record(name, y).index != y.record(name, x).index

    def test_numbers_and_scalars_mix_on_both_sides(self, tape: Tape, x: Scalar) -> None:
        two = tape.constant(2)
        assert (2 - x).index == (two - x).index
        assert (2 / x).index == (two / x).index
        assert (2**x).index == (two**x).index
        assert atan2(2, x).index == atan2(two, x).index
        assert maximum(x, 2).index == maximum(x, two).index

    def test_numbers_of_numpy(self, tape: Tape, x: Scalar) -> None:
        product: Any = np.float64(3.0) * x
        assert product.index == (tape.constant(3.0) * x).index

    def test_arguments_come_before_the_operation(self, x: Scalar, y: Scalar) -> None:
        assert len((sin(x * y - 3) / (x + 2) ** 3).tape) > 5
        for index in range(len(x.tape)):
            assert all(a < index for a in x.tape.arguments(index))

    def test_two_tapes_do_not_mix(self, x: Scalar) -> None:
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

    @pytest.mark.parametrize("name", sorted(UNARY))
    def test_functions_of_constants_are_computed(self, tape: Tape, name: str) -> None:
        folded = tape.constant(0.5).record(name)
        assert operation(folded) == ("constant", UNARY[name](0.5))

    @pytest.mark.parametrize("name", sorted(BINARY))
    def test_operations_on_constants_are_computed(self, tape: Tape, name: str) -> None:
        folded = tape.constant(0.5).record(name, 0.25)
        assert operation(folded) == ("constant", BINARY[name](0.5, 0.25))

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


class TestPowers:
    @pytest.mark.parametrize("exponent", [2, 3, -1, -3, LARGEST_UNROLLED_POWER])
    def test_small_whole_powers_are_products(self, x: Scalar, exponent: int) -> None:
        power = x**exponent
        kinds = {operation(x.tape.scalar(k))[0] for k in x.tape.reachable([power.index])}
        assert kinds <= {"symbol", "constant", "mul", "div"}
        assert power.index == (x ** float(exponent)).index

    def test_square_root(self, x: Scalar) -> None:
        assert operation(x**0.5) == ("sqrt", x.index)

    @pytest.mark.parametrize("exponent", [LARGEST_UNROLLED_POWER + 1, 1.5, -0.5, 1e300])
    def test_other_powers_are_powers(self, x: Scalar, exponent: float) -> None:
        assert operation(x**exponent)[0] == "pow"

    def test_an_exponent_may_be_recorded(self, x: Scalar, y: Scalar) -> None:
        assert operation(x**y) == ("pow", x.index, y.index)
        assert (x ** x.tape.constant(2)).index == (x * x).index


class TestNoBranchesWhileRecording:
    """A comparison made while recording would freeze one of its two outcomes."""

    def test_a_scalar_has_no_truth_value(self, x: Scalar) -> None:
        with pytest.raises(TypeError, match="truth value"):
            bool(x)

    def test_scalars_are_not_ordered(self, x: Scalar) -> None:
        untyped: Any = x
        for compare in (lambda: untyped < 0, lambda: max(untyped, 0), lambda: untyped >= untyped):
            with pytest.raises(TypeError):
                compare()

    def test_minimum_maximum_and_sign_are_recorded(self, x: Scalar) -> None:
        assert operation(minimum(x, 1))[0] == "min"
        assert operation(maximum(1, x))[0] == "max"
        assert operation(sign(x))[0] == "sign"


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


@pytest.mark.parametrize("attempt", [
    lambda x: x > 0, lambda x: x <= 1.0, lambda x: max(x, 0.0), bool,
])  # fmt: skip
def test_a_recorded_scalar_has_no_branches(attempt: Callable[[Any], Any]) -> None:
    x = Tape().symbol("x")
    with pytest.raises(TypeError, match=r"use maximum\(x, 0\), minimum\(x, 0\) or sign"):
        attempt(x)


@pytest.mark.parametrize("attempt", [math.sin, float, math.sqrt])
def test_a_recorded_scalar_is_no_number(attempt: Callable[[Any], Any]) -> None:
    with pytest.raises(TypeError, match="use sin, sqrt, exp and the like"):
        attempt(Tape().symbol("x"))
