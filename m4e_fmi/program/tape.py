"""The tape: straight-line arithmetic with hash-consing.

Recording an algorithm on `Scalar`s appends each *new* operation to the tape; an operation that is
already there returns the old node. Recording therefore is common-subexpression elimination.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from typing import Any, NoReturn, TypeVar, cast

Operation = tuple[Any, ...]
"""A name with a number, a name or the indices of its arguments, see `Tape`."""
Value = TypeVar("Value")
"""Kind of values of nodes: floats, or arrays."""

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
FUNCTIONS = {**UNARY, **BINARY}
COMMUTATIVE = frozenset({"add", "mul"})
PLAIN, CONSTANT, NEGATED = range(3)
"""Kinds of scalars. A constant or negated one may make an operation unnecessary, or change it."""
KINDS = {"constant": CONSTANT, "neg": NEGATED}
LARGEST_UNROLLED_POWER = 8
BRANCHES = (
    "recorded code has no branches; use maximum(x, 0), minimum(x, 0) or sign(x) of m4e_fmi.program"
)


def _computed(function: Callable[..., float], *values: float) -> float | None:
    """`function` of constants; None where it has no finite value: that is left to the run."""
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
        self.operations: list[Operation] = []
        self._scalars: list[Scalar] = []
        self._known: dict[Operation, Scalar] = {}

    def __len__(self) -> int:
        return len(self.operations)

    def node(self, operation: Operation) -> int:
        """Index of `operation`, which is appended unless it is there already."""
        return self.recorded(operation).index

    def recorded(self, operation: Operation) -> Scalar:
        """The scalar of `operation`, which is appended unless it is there already."""
        scalar = self._known.get(operation)
        if scalar is None:
            kind = KINDS.get(operation[0], PLAIN)
            scalar = self._known[operation] = Scalar(self, len(self.operations), kind)
            self.operations.append(operation)
            self._scalars.append(scalar)
        return scalar

    def scalar(self, index: int) -> Scalar:
        """The scalar of a node."""
        return self._scalars[index]

    def constant(self, value: float) -> Scalar:
        """The scalar of a number; ValueError if it is not finite."""
        value = float(value)
        if not math.isfinite(value):
            raise ValueError(f"a constant must be finite, got {value}")
        return self.recorded(("constant", value + 0.0))  # one zero: -0.0 + 0.0 is 0.0

    def symbol(self, name: str) -> Scalar:
        """The scalar of a symbol."""
        return self.recorded(("symbol", name))

    @property
    def names(self) -> frozenset[str]:
        """Names of all symbols on the tape."""
        return frozenset(op[1] for op in self.operations if op[0] == "symbol")

    def value(self, index: int) -> float | None:
        """The value of a constant node, None for any other."""
        operation = self.operations[index]
        return operation[1] if operation[0] == "constant" else None

    def unary(self, name: str, a: Scalar) -> Scalar:
        """The operation `name` of one scalar."""
        if a.kind == CONSTANT:
            result = _computed(UNARY[name], self.operations[a.index][1])
            if result is not None:
                return self.constant(result)
        elif a.kind == NEGATED and name == "neg":
            return self.scalar(self.operations[a.index][1])
        return self.recorded((name, a.index))

    def binary(self, name: str, a: Scalar, b: Scalar | float) -> Scalar:
        """The operation `name` of two scalars, the second of which may be a number."""
        if not isinstance(b, Scalar):
            b = self.constant(b)
        elif b.tape is not self:
            raise ValueError("scalars of two tapes cannot be combined")
        if a.kind or b.kind:
            folded = self._folded(name, a, b)
            if folded is not None:
                return folded
        i, j = a.index, b.index
        if i > j and name in COMMUTATIVE:
            i, j = j, i
        return self.recorded((name, i, j))

    def _folded(self, name: str, a: Scalar, b: Scalar) -> Scalar | None:
        """Replacement of an operation on a constant or a negated scalar; None without one."""
        x = self.operations[a.index][1] if a.kind == CONSTANT else None
        y = self.operations[b.index][1] if b.kind == CONSTANT else None
        if x is not None and y is not None:
            result = _computed(BINARY[name], x, y)
            return None if result is None else self.constant(result)
        if x is not None or y is not None:
            neutral = self._with_constant(name, a, b, x, y)
            if neutral is not None:
                return neutral
        if a.kind == NEGATED or b.kind == NEGATED:
            return self._with_negated(name, a, b)
        return None

    def _with_constant(
        self, name: str, a: Scalar, b: Scalar, x: float | None, y: float | None
    ) -> Scalar | None:
        """An operation with a neutral or absorbing constant, whose value is x or y."""
        match name:
            case "add":
                return b if x == 0.0 else a if y == 0.0 else None
            case "sub":
                return a if y == 0.0 else self.unary("neg", b) if x == 0.0 else None
            case "mul":
                if x == 0.0 or y == 0.0:
                    return self.constant(0.0)
                for factor, other in ((x, b), (y, a)):
                    if factor == 1.0:
                        return other
                    if factor == -1.0:
                        return self.unary("neg", other)
            case "div":
                return self.constant(0.0) if x == 0.0 else a if y == 1.0 else None
            case _:
                pass
        return None

    def _with_negated(self, name: str, a: Scalar, b: Scalar) -> Scalar | None:
        """The same value, to the bit, with the sign taken out of the operands."""
        minus_a = self._scalars[self.operations[a.index][1]] if a.kind == NEGATED else None
        minus_b = self._scalars[self.operations[b.index][1]] if b.kind == NEGATED else None
        match name:
            case "add" if minus_a is not None and minus_b is not None:
                return self.unary("neg", self.binary("add", minus_a, minus_b))
            case "add" if minus_b is not None:
                return self.binary("sub", a, minus_b)
            case "add" if minus_a is not None:
                return self.binary("sub", b, minus_a)
            case "sub" if minus_b is not None:
                return self.binary("add", a, minus_b)
            case "sub" if minus_a is not None:
                return self.unary("neg", self.binary("add", minus_a, b))
            case "mul" | "div" if minus_a is not None:
                return self.unary("neg", self.binary(name, minus_a, b))
            case "mul" | "div" if minus_b is not None:
                return self.unary("neg", self.binary(name, a, minus_b))
            case _:
                return None

    def arguments(self, index: int) -> tuple[int, ...]:
        """Indices that node `index` is computed from."""
        operation = self.operations[index]
        return () if operation[0] in ("constant", "symbol") else operation[1:]

    def reachable(self, roots: Iterable[int]) -> list[int]:
        """All nodes that `roots` need, themselves included, in order of execution."""
        return needed(self, roots, known=())

    def symbols_of(self, root: int) -> frozenset[str]:
        """Names of the symbols that node `root` depends on (structurally)."""
        return self.symbols_of_each([root])[root]

    def symbols_of_each(self, roots: Iterable[int]) -> dict[int, frozenset[str]]:
        """`symbols_of` for many roots, in one pass over the tape."""
        roots = set(roots)
        names: list[str] = []
        bits: dict[int, int] = {}  # the names that a node depends on, as bits of a whole number
        for k in self.reachable(roots):
            operation = self.operations[k]
            if operation[0] == "symbol":
                bits[k] = 1 << len(names)
                names.append(operation[1])
            elif operation[0] == "constant":
                bits[k] = 0
            else:
                bits[k] = bits[operation[1]] | bits[operation[-1]]
        named: dict[int, frozenset[str]] = {}
        for b in {bits[k] for k in roots}:
            digits = bin(b)[:1:-1]  # lowest first
            chosen = (name for name, digit in zip(names, digits, strict=False) if digit == "1")
            named[b] = frozenset(chosen)
        return {k: named[bits[k]] for k in roots}

    def __repr__(self) -> str:
        return f"Tape of {len(self)} nodes"


class Scalar:
    """One node of a tape with Python's arithmetic; combining two of one tape records.

    A tape makes one Scalar for each of its nodes.
    """

    __slots__ = ("index", "kind", "tape")

    def __init__(self, tape: Tape, index: int, kind: int) -> None:
        self.tape = tape
        self.index = index
        self.kind = kind

    def record(self, name: str, *others: Scalar | float) -> Scalar:
        """Node of the operation `name` applied to this scalar (and one more, if binary)."""
        if others:
            return self.tape.binary(name, self, others[0])
        return self.tape.unary(name, self)

    def __add__(self, other: Scalar | float) -> Scalar:
        return self.tape.binary("add", self, other)

    def __radd__(self, other: float) -> Scalar:
        return self.tape.binary("add", self.tape.constant(other), self)

    def __sub__(self, other: Scalar | float) -> Scalar:
        return self.tape.binary("sub", self, other)

    def __rsub__(self, other: float) -> Scalar:
        return self.tape.binary("sub", self.tape.constant(other), self)

    def __mul__(self, other: Scalar | float) -> Scalar:
        return self.tape.binary("mul", self, other)

    def __rmul__(self, other: float) -> Scalar:
        return self.tape.binary("mul", self.tape.constant(other), self)

    def __truediv__(self, other: Scalar | float) -> Scalar:
        return self.tape.binary("div", self, other)

    def __rtruediv__(self, other: float) -> Scalar:
        return self.tape.binary("div", self.tape.constant(other), self)

    def __neg__(self) -> Scalar:
        return self.tape.unary("neg", self)

    def __abs__(self) -> Scalar:
        return self.tape.unary("abs", self)

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
        return self.tape.binary("pow", self.tape.constant(base), self)

    def __bool__(self) -> bool:
        """Refused: a branch taken while recording would be taken for ever."""
        raise TypeError(f"a recorded scalar has no truth value: {BRANCHES}")

    def _compared(self, _: object) -> NoReturn:
        raise TypeError(f"a recorded scalar cannot be compared, as in `if x > 0`: {BRANCHES}")

    __lt__ = __le__ = __gt__ = __ge__ = _compared

    def __float__(self) -> NoReturn:
        raise TypeError(
            "a recorded scalar has no value yet: use sin, sqrt, exp and the like from "
            "m4e_fmi.program, not from math or NumPy"
        )

    def __repr__(self) -> str:
        return f"Scalar({self.index}: {self.tape.operations[self.index]})"


def needed(tape: Tape, roots: Iterable[int], *, known: Container[int]) -> list[int]:
    """The nodes that `roots` need, themselves included, in order, beyond those that are `known`."""
    found = {k for k in roots if k not in known}
    waiting = list(found)
    while waiting:
        for a in tape.arguments(waiting.pop()):
            if a not in found and a not in known:
                found.add(a)
                waiting.append(a)
    return sorted(found)


def evaluated(
    tape: Tape,
    nodes: Sequence[int],
    values: Mapping[str, Value],
    *,
    functions: Mapping[str, Callable[..., Value]] = FUNCTIONS,
) -> dict[int, Value]:
    """The values of `nodes` for given `values` of their symbols; nan where undefined.

    `values` are floats, or arrays for `functions` of arrays.
    """
    found: dict[int, Value] = {}
    for k in tape.reachable(nodes):
        kind, *arguments = tape.operations[k]
        if kind == "constant":
            found[k] = arguments[0]
        elif kind == "symbol":
            found[k] = values[arguments[0]]
        else:
            try:
                found[k] = functions[kind](*(found[a] for a in arguments))
            except (ValueError, ZeroDivisionError, OverflowError):
                found[k] = cast("Value", math.nan)
    return {k: found[k] for k in nodes}


class TapeCopy:
    """The nodes of `tape` on the tape `target`, each copied when it is first asked for.

    `symbols` are the scalars that stand for symbols of `tape`; more are given by `give`, before a
    node that needs them is asked for.
    """

    def __init__(self, tape: Tape, target: Tape, symbols: Mapping[str, Scalar]) -> None:
        self.tape, self.target = tape, target
        self._symbols = dict(symbols)
        self._copied: dict[int, Scalar] = {}

    def give(self, name: str, scalar: Scalar) -> None:
        """Let `scalar` stand for the symbol `name`."""
        self._symbols[name] = scalar

    def fork(self) -> TapeCopy:
        """Another copy that knows what this one has copied so far."""
        other = TapeCopy(self.tape, self.target, self._symbols)
        other._copied = dict(self._copied)
        return other

    def __call__(self, node: int) -> Scalar:
        """The copy of a node; KeyError for a symbol that nothing stands for."""
        if node not in self._copied:
            for k in needed(self.tape, [node], known=self._copied):
                kind, *arguments = self.tape.operations[k]
                if kind == "constant":
                    self._copied[k] = self.target.constant(arguments[0])
                elif kind == "symbol":
                    self._copied[k] = self._symbols[arguments[0]]
                else:
                    first, *others = (self._copied[a] for a in arguments)
                    self._copied[k] = first.record(kind, *others)
        return self._copied[node]
