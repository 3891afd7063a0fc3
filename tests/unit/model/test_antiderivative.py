"""Integrals of laws: their derivative, by the exact derivatives of programs, is the law."""

from __future__ import annotations

import math

import pytest
from support.programs import Evaluated

from m4e_fmi.model.antiderivative import antiderivative, potential
from m4e_fmi.model.expression import Expression, Values, parse
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
    integral = antiderivative(law, "x")
    assert integral is not None, text
    derivative = slope(integral)
    for at in places:
        expected = law.evaluate(Values({**PARAMETERS, "x": at}))
        found = derivative.outputs({"x": at, "d(x)": 1.0})["d(y)"]
        # some dozen operations on numbers up to 1e3
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12), text


@pytest.mark.parametrize("text", [
    "k", "k*x", "k*x + c*x**3", "x**12 - k*x**5*(1 + x)", "(k*x + c)**9", "(1 + x + c*x**2)**4",
    "(k*x + 1)*(x - c)**2/a", "-(x - 2)*3", "k*abs(x)*x", "k*abs(x)**1.5*sign(x)", "c*max(0, x)",
    "k*max(x - 0.1, 0)**1.5", "k*min(0, a*x + b)", "k*min(0, x)**2", "k*min(x, 0)**3*sign(x)",
    "k*tanh(x/0.01)", "tanh(a*x + b) + c*atan(2*x) - sin(x)*k", "k*(exp(a*x) - 1)",
    "k*cos(a*x)/c", "x*(1 + abs(x))", "(1 - abs(x)*c)*x", "abs(a*x - b)**3", "k*sign(x - 1)",
    "1/(x + 0.05)", "c/(x - 7)**2", "-k/(a*x + b)**3",
])  # fmt: skip
def test_the_derivative_of_the_integral_is_the_law(text: str) -> None:
    check(text)


@pytest.mark.parametrize("text", ["k*sqrt(x)", "log(x)*a", "x**0.3", "a/sqrt(x)", "(a*x + b)**2.5"])
def test_laws_of_positive_numbers(text: str) -> None:
    check(text, PLACES[2:])


@pytest.mark.parametrize("text", [
    "x*tanh(x)", "exp(x**2)", "sin(x)/x", "max(x, x**2)", "x**x", "tan(x)", "abs(x)*abs(x-1)",
    "((x**2 + 1)**4)**4",  # too long to be multiplied out
    "*".join(["(1 + abs(x))"] * 100),
])  # fmt: skip
def test_what_is_not_known_is_said_to_be_unknown(text: str) -> None:
    assert antiderivative(parse(text), "x") is None


def test_a_potential_is_zero_without_extension() -> None:
    law = parse("k*(exp(a*x + b) - 1)")
    found = potential(law, "x", Values(PARAMETERS))
    assert found is not None
    k, a, b = (PARAMETERS[name] for name in "kab")
    expected = k * ((math.exp(a * 0.5 + b) - math.exp(b)) / a - 0.5)
    assert found.evaluate(Values({**PARAMETERS, "x": 0.5})) == pytest.approx(expected, rel=1e-14)
    assert found.evaluate(Values({**PARAMETERS, "x": 0.0})) == 0


@pytest.mark.parametrize("text", ["1/x", "1/x**2", "log(x) + 1/x"])
def test_a_law_that_is_infinite_at_zero_has_no_potential(text: str) -> None:
    assert potential(parse(text), "x", Values(PARAMETERS)) is None
