"""Expressions of input files: the grammar, and that nothing but the grammar is understood."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from m4e_fmi.model.expression import (
    DEEPEST_NESTING,
    FUNCTIONS,
    LONGEST_TEXT,
    ExpressionError,
    Values,
    parse,
)

NAMES = {"a": 1.75, "b": -0.5, "L_2": 3.0, "_x": 0.0}


def value(text: str) -> Any:
    return parse(text).evaluate(Values(NAMES))


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_every_function_is_that_of_the_math_module(name: str) -> None:
    ours = {"abs": abs, "max": max, "min": min, "sign": lambda x: math.copysign(1, x)}
    theirs: Any = ours.get(name) or getattr(math, name)
    arguments = (0.3, 0.7) if name in {"atan2", "max", "min"} else (0.3,)
    assert value(f"{name}({', '.join(map(str, arguments))})") == theirs(*arguments)


@pytest.mark.parametrize("text", [
    "__import__('os')", "__import__", "eval(1)", "open(a)", "a.real", "a[0]",
    "(1).bit_length()", "lambda: 1", "1 if a else 2", "a == b", "a and b", "[1, 2]", "a; b",
    "a := 1", "'text'", "f'{a}'", "a # comment", "a @ b", "~a", "a % b", "1j", "0x10", "1_000",
    "True", "exp(log)",
])  # fmt: skip
def test_python_is_not_evaluated(text: str) -> None:
    """Refused by the grammar or, where it reads as a name, as a name that nobody declared."""
    with pytest.raises((ExpressionError, KeyError)):
        value(text)


@pytest.mark.parametrize(
    "text",
    [
        "-" * (DEEPEST_NESTING + 1) + "1",
        "+".join(["1"] * (DEEPEST_NESTING + 1)),
        "sin(" * (DEEPEST_NESTING) + "1" + ")" * (DEEPEST_NESTING),
        "1" * (LONGEST_TEXT + 1),
    ],
)
def test_what_is_too_deep_or_too_long_is_an_error_of_ours(text: str) -> None:
    with pytest.raises(ExpressionError, match=r"nested more|longer than"):
        parse(text)


def test_what_is_as_deep_as_allowed_can_be_used() -> None:
    expression = parse("-" * (DEEPEST_NESTING - 1) + "a")
    assert expression.evaluate(Values(NAMES)) == -1.75
    assert expression.names() == {"a"}
    assert str(expression).count("-") == DEEPEST_NESTING - 1
    assert parse("(" * 900 + "a" + ")" * 900) == parse("a")


def test_the_written_form_means_the_same() -> None:
    text = "-a**2*(b - 3)/max(L_2, _x) + 2**-b"
    assert value(str(parse(text))) == value(text)


NUMBERS = st.sampled_from(["0.0", "1.0", ".25", "2.", "3.5e0", "1e-3", "7.0"])
LEAVES = NUMBERS | st.sampled_from(["a", "b", "L_2", "_x"])


def _combined(parts: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Larger texts: with few parentheses, so that precedence and associativity decide."""
    space = st.sampled_from(["", " ", "\t"])
    operator = st.sampled_from(["+", "-", "*", "/", "**"])
    binary = st.tuples(parts, space, operator, space, parts).map("".join)
    unary = st.tuples(st.sampled_from(["-", "+", "- "]), parts).map("".join)
    one = st.tuples(st.sampled_from(["sin", "tanh", "abs", "exp"]), parts)
    two = st.tuples(st.sampled_from(["max", "min", "atan2"]), parts, parts)
    return (
        binary
        | unary
        | parts.map(lambda part: f"({part})")
        | one.map(lambda call: f"{call[0]}({call[1]})")
        | two.map(lambda call: f"{call[0]}({call[1]}, {call[2]})")
    )


TEXTS = st.recursive(LEAVES, _combined, max_leaves=12)


@settings(max_examples=400, deadline=None, derandomize=True)
@given(TEXTS)
def test_random_texts_have_the_value_that_python_gives_them(text: str) -> None:
    functions: dict[str, Any] = {"abs": math.fabs, "max": max, "min": min}
    functions |= {name: getattr(math, name) for name in ("sin", "tanh", "exp", "atan2")}
    try:
        expected = eval(text, {"__builtins__": {}}, {**functions, **NAMES})
    except (ArithmeticError, ValueError):
        expected = None
    except TypeError:  # a function of a complex number
        expected = 1j
    if expected is None or isinstance(expected, complex):
        with pytest.raises((ArithmeticError, ValueError)):
            value(text)
    else:
        assert value(text) == expected or (math.isnan(value(text)) and math.isnan(expected))
