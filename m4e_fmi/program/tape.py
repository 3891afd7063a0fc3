"""The tape: straight-line arithmetic with hash-consing.

Recording an algorithm on `Scalar`s appends each *new* operation to the tape; an operation that is
already there returns the old node. Recording therefore is common-subexpression elimination.
"""

from __future__ import annotations

import math
from collections.abc import Callable

UNARY: dict[str, Callable[[float], float]] = {
    "neg": lambda a: -a,
    "abs": abs,
    "sign": lambda a: float((a > 0) - (a < 0)),
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "tanh": math.tanh,
}
BINARY: dict[str, Callable[[float, float], float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "pow": math.pow,
    "atan2": math.atan2,
    "min": min,
    "max": max,
}
COMMUTATIVE = frozenset({"add", "mul"})
LARGEST_UNROLLED_POWER = 8


def _computed(function: Callable[..., float], *values: float) -> float | None:
    """`function` of constants; None where it has no finite value, which is then met at run time."""
    try:
        result = function(*values)
    except (ValueError, ZeroDivisionError, OverflowError):
        return None
    return result if math.isfinite(result) else None


class Tape:
    """A growing list of operations; a node is its index.

    `operations[k]` is ``("constant", value)``, ``("symbol", name)``, ``(unary, a)`` or
    ``(binary, a, b)`` with a, b < k: the list is in an order in which it can be executed.
    """

    def __init__(self) -> None:
        self.operations: list[tuple] = []
        self._index: dict[tuple, int] = {}

    def __len__(self) -> int:
        return len(self.operations)

    def node(self, operation: tuple) -> int:
        """Index of `operation`, appended unless it is there already."""
        index = self._index.get(operation)
        if index is None:
            index = len(self.operations)
            self.operations.append(operation)
            self._index[operation] = index
        return index

    def constant(self, value: float) -> Scalar:
        value = float(value)
        if not math.isfinite(value):
            raise ValueError(f"a constant must be finite, got {value}")
        if value == 0.0:  # one zero: -0.0 equals 0.0 as a key
            value = 0.0
        return Scalar(self, self.node(("constant", value)))

    def symbol(self, name: str) -> Scalar:
        return Scalar(self, self.node(("symbol", name)))

    def value(self, index: int) -> float | None:
        """The value of a constant node, None for any other."""
        operation = self.operations[index]
        return operation[1] if operation[0] == "constant" else None

    def unary(self, name: str, a: int) -> int:
        value = self.value(a)
        if value is not None:
            result = _computed(UNARY[name], value)
            if result is not None:
                return self.constant(result).index
        if name == "neg" and self.operations[a][0] == "neg":
            return self.operations[a][1]
        return self.node((name, a))

    def binary(self, name: str, a: int, b: int) -> int:
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            result = _computed(BINARY[name], x, y)
            if result is not None:
                return self.constant(result).index
        folded = self._fold(name, a, b, x, y)
        if folded is not None:
            return folded
        if name in COMMUTATIVE and a > b:
            a, b = b, a
        return self.node((name, a, b))

    def _fold(self, name: str, a: int, b: int, x: float | None, y: float | None) -> int | None:
        """Node of an operation with a neutral or absorbing constant, None where there is none."""
        if name == "add":
            return b if x == 0.0 else a if y == 0.0 else None
        if name == "sub":
            if y == 0.0:
                return a
            return self.unary("neg", b) if x == 0.0 else None
        if name == "mul":
            if x == 0.0 or y == 0.0:
                return self.constant(0.0).index
            for factor, other in ((x, b), (y, a)):
                if factor == 1.0:
                    return other
                if factor == -1.0:
                    return self.unary("neg", other)
            return None
        if name == "div":
            if x == 0.0 and y != 0.0:
                return self.constant(0.0).index
            return a if y == 1.0 else None
        return None

    def arguments(self, index: int) -> tuple[int, ...]:
        """Indices that node `index` is computed from."""
        operation = self.operations[index]
        return () if operation[0] in ("constant", "symbol") else operation[1:]

    def reachable(self, roots: list[int]) -> list[int]:
        """All nodes that `roots` need, themselves included, in order of execution."""
        needed = set(roots)
        for index in range(max(roots, default=-1), -1, -1):
            if index in needed:
                needed.update(self.arguments(index))
        return sorted(needed)

    def symbols_of(self, root: int) -> frozenset[str]:
        """Names of the symbols that node `root` depends on (structurally)."""
        operations = (self.operations[k] for k in self.reachable([root]))
        return frozenset(op[1] for op in operations if op[0] == "symbol")


class Scalar:
    """One node of a tape with Python's arithmetic; combining two of one tape records."""

    __slots__ = ("index", "tape")

    def __init__(self, tape: Tape, index: int) -> None:
        self.tape = tape
        self.index = index

    def _node(self, other: Scalar | float) -> int:
        if isinstance(other, Scalar):
            if other.tape is not self.tape:
                raise ValueError("scalars of two tapes cannot be combined")
            return other.index
        return self.tape.constant(other).index

    def record(self, name: str, *others: Scalar | float) -> Scalar:
        """Node of the operation `name` applied to this scalar (and one more, if binary)."""
        if others:
            return Scalar(self.tape, self.tape.binary(name, self.index, self._node(others[0])))
        return Scalar(self.tape, self.tape.unary(name, self.index))

    def _reversed(self, name: str, other: float) -> Scalar:
        return Scalar(self.tape, self.tape.binary(name, self._node(other), self.index))

    def __add__(self, other: Scalar | float) -> Scalar:
        return self.record("add", other)

    def __radd__(self, other: float) -> Scalar:
        return self._reversed("add", other)

    def __sub__(self, other: Scalar | float) -> Scalar:
        return self.record("sub", other)

    def __rsub__(self, other: float) -> Scalar:
        return self._reversed("sub", other)

    def __mul__(self, other: Scalar | float) -> Scalar:
        return self.record("mul", other)

    def __rmul__(self, other: float) -> Scalar:
        return self._reversed("mul", other)

    def __truediv__(self, other: Scalar | float) -> Scalar:
        return self.record("div", other)

    def __rtruediv__(self, other: float) -> Scalar:
        return self._reversed("div", other)

    def __neg__(self) -> Scalar:
        return self.record("neg")

    def __abs__(self) -> Scalar:
        return self.record("abs")

    def __pow__(self, exponent: Scalar | float) -> Scalar:
        """Small whole powers are recorded as products: the same bits everywhere."""
        if isinstance(exponent, Scalar):
            constant = self.tape.value(exponent.index)
        else:
            constant = float(exponent)
        if constant is None or abs(constant) > LARGEST_UNROLLED_POWER or constant != int(constant):
            return self.record("sqrt") if constant == 0.5 else self.record("pow", exponent)
        result = self.tape.constant(1.0)
        for _ in range(abs(int(constant))):
            result = result * self
        return 1.0 / result if constant < 0 else result

    def __rpow__(self, base: float) -> Scalar:
        return self._reversed("pow", base)

    def __bool__(self) -> bool:
        """Refused: a branch taken while recording would be taken for ever."""
        raise TypeError("a recorded scalar has no truth value; use minimum, maximum or sign")

    def __repr__(self) -> str:
        return f"Scalar({self.index}: {self.tape.operations[self.index]})"
