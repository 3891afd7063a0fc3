"""Potentials of laws: their derivative, by the exact derivatives of programs, is the law."""

from __future__ import annotations

import pytest
from support.programs import Evaluated

from m4e_fmi.model.expression import Expression, Values, parse
from m4e_fmi.model.potential import potential
from m4e_fmi.program import Recorder, Variable, tangent

PARAMETERS = {"k": 3.5, "c": -0.75, "a": 1.25, "b": 0.4}
PLACES = (-1.7, -0.3, 0.2, 0.9, 2.4)


def slope(e: Expression) -> Evaluated:
    """The derivative of an expression in x, as output d(y) for d(x) = 1."""
    recorder = Recorder("law", "law")
    parameters = {
        name: recorder.parameter(Variable(name, "1", name, start=value))
        for name, value in PARAMETERS.items()
    }
    x = recorder.input(Variable("x", "1", "x"))
    recorder.output(Variable("y", "1", "y"), e.evaluate(Values({**parameters, "x": x})))
    return Evaluated(tangent(recorder.program(), ["x"]))


def check(text: str, places: tuple[float, ...] = PLACES) -> None:
    law = parse(text)
    integral = potential(law, "x")
    assert integral is not None, text
    derivative = slope(integral)
    for at in places:
        expected = law.evaluate(Values({**PARAMETERS, "x": at}))
        found = derivative.outputs({"x": at, "d(x)": 1.0})["d(y)"]
        # some dozen operations on numbers up to 1e3
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12), text


@pytest.mark.parametrize("text", [
    "k", "k*x", "k*x + c*x**3", "x**12 - k*x**5*(1 + x)", "(k*x + c)**4", "(1 + x + c*x**2)**4",
    "(k*x + 1)*(x - c)**2/a", "-(x - 2)*3",
])  # fmt: skip
def test_the_derivative_of_the_potential_is_the_law(text: str) -> None:
    check(text)


@pytest.mark.parametrize("text", [
    "x*tanh(x)", "exp(x)", "1/x", "k*max(0, x)", "x**x", "x**0.5", "abs(x)*x",
    "((x**2 + 1)**4)**4",  # too long to be multiplied out
])  # fmt: skip
def test_a_law_that_is_no_polynomial_has_no_potential(text: str) -> None:
    assert potential(parse(text), "x") is None


def test_a_potential_is_zero_without_extension() -> None:
    found = potential(parse("k*(a*x + b)**2"), "x")
    assert found is not None
    k, a, b = (PARAMETERS[name] for name in "kab")
    expected = k * ((a * 0.5 + b) ** 3 - b**3) / (3 * a)
    assert found.evaluate(Values({**PARAMETERS, "x": 0.5})) == pytest.approx(expected, rel=1e-14)
    assert found.evaluate(Values({**PARAMETERS, "x": 0.0})) == 0
