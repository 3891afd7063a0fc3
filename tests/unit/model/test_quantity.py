"""Quantities given as SymPy expressions."""

from __future__ import annotations

import math
from typing import Any

import pytest
import sympy as sp

from m4e_fmi.model import Body, BodyForce, Joint, Model, Parameter
from m4e_fmi.model.expression import ExpressionError, Values
from m4e_fmi.model.quantity import as_expression
from m4e_fmi.multibody import model_program

a, b, c, t = sp.symbols("a b c t")
NUMBERS = {"a": 0.37, "b": 1.9, "c": 0.6, "t": 2.5, "body.hull.z": -0.4}
EXPRESSIONS: list[Any] = [
    sp.Integer(3), sp.Rational(-2, 7), sp.Float("0.1"), sp.pi, a, -a, a - b, -a - b + c,
    a * b / c, -3 * a / (b * c), sp.Rational(5, 3) * a**2 * b**-3, 1 / (a + b),
    sp.sqrt(a + 1) / sp.sqrt(b), a**b, a ** sp.Rational(-3, 2), sp.exp(-a) + sp.E,
    sp.Abs(a - b) * sp.sign(a - b), sp.Min(a, b, c) + sp.Max(a, b, c, 1),
    sp.atan2(a, b) + sp.tanh(a) - sp.log(b) + sp.tan(c),
    sp.sin(2 * sp.pi * t / 3) + sp.acos(a) + sp.asin(c) + sp.atan(b),
    (a + b * sp.I).subs(b, 0), -a * sp.Symbol("body.hull.z"),
]  # fmt: skip


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_they_have_the_value_that_sympy_gives(expression: Any) -> None:
    converted = as_expression(expression)
    # a dozen operations, each wrong by 1.1e-16 at most
    expected = float(expression.subs(NUMBERS).evalf(30))
    assert converted.evaluate(Values(NUMBERS)) == pytest.approx(expected, rel=2e-15)
    assert converted.names() == {str(s) for s in expression.free_symbols}


NO_COUNTERPART: list[Any] = [
    sp.I * a, sp.besselj(0, a), sp.Piecewise((a, a > 0), (b, True)), sp.Function("f")(a),
    sp.Derivative(sp.Function("f")(t), t), sp.Integral(a, a), sp.oo, sp.nan, sp.zoo, sp.true,
    a > b, sp.Matrix([a]),
]  # fmt: skip


@pytest.mark.parametrize("wrong", [*NO_COUNTERPART, True, None, math.nan, [1.0], 1j], ids=str)
def test_what_has_no_counterpart_is_refused(wrong: Any) -> None:
    with pytest.raises(ExpressionError, match=r"no counterpart|expected"):
        as_expression(wrong)


def test_a_law_in_a_model() -> None:
    """The same program as from text, except for the order of operations."""
    mass = sp.Symbol("m")

    def model(law: Any, inertia: Any) -> Model:
        return Model(
            name="pushed",
            bodies={"block": Body(mass, inertia)},
            joints={"rail": Joint("prismatic", "block", direction=(1.0, 0.0))},
            loads={"push": BodyForce("block", (law, 0.0))},
            parameters={"m": Parameter(2.0, "kg")},
        )

    program = model_program(model(3 * sp.sin(2 * t), mass / 3))
    assert program == model_program(model("3*sin(2*t)", "m/3"))
    assert {v.name for v in program.parameters} == {"m"}
