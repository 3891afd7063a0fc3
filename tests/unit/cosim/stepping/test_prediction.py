"""Coefficients of means and end values: exact for the polynomials they are made for."""

from __future__ import annotations

import pytest

from m4e_fmi.cosim.stepping.prediction import Signal, Terms

SIZE, LAST = 0.3, 0.2
NOW, BEFORE, STEPPED, RATE, CURVATURE = range(5)


def applied(terms: Terms, polynomial: tuple[float, float, float]) -> float:
    """The combination applied to y = a + b s + c s², whose present is s = 0."""
    a, b, c = polynomial
    values = [a, a - b * LAST + c * LAST**2, a + b * SIZE + c * SIZE**2, b, 2 * c]
    return sum(factor * values[index] for index, factor in terms.items())


def true(polynomial: tuple[float, float, float]) -> tuple[float, float, float]:
    """Mean, end value and mean slope over the step."""
    a, b, c = polynomial
    end = a + b * SIZE + c * SIZE**2
    return a + b * SIZE / 2 + c * SIZE**2 / 3, end, (end - a) / SIZE


@pytest.mark.parametrize(
    ("signal", "polynomial"),
    [
        (Signal(NOW, BEFORE, STEPPED, RATE, CURVATURE), (1.0, 2.0, 3.0)),
        (Signal(NOW, BEFORE, STEPPED, None, None), (1.0, -2.0, 3.0)),
        (Signal(NOW, BEFORE, None, RATE, CURVATURE), (1.0, 2.0, -3.0)),
        (Signal(NOW, BEFORE, None, RATE, None), (1.0, 2.0, 0.0)),
        (Signal(NOW, BEFORE, None, None, None), (-1.0, 2.0, 0.0)),
    ],
)
def test_exact_for_polynomials(signal: Signal, polynomial: tuple[float, float, float]) -> None:
    mean, end, slope = true(polynomial)
    # tolerance: rounding of a handful of additions
    assert applied(signal.mean(SIZE, LAST), polynomial) == pytest.approx(mean, abs=1e-14)
    assert applied(signal.end(SIZE, LAST), polynomial) == pytest.approx(end, abs=1e-14)
    assert applied(signal.slope(SIZE, LAST), polynomial) == pytest.approx(slope, abs=1e-14)


def test_without_a_step_before_only_the_present_counts() -> None:
    known = Signal(NOW, BEFORE, STEPPED, None, None)
    assert known.mean(SIZE, 0.0) == {NOW: 0.5, STEPPED: 0.5}
    unknown = Signal(NOW, BEFORE, None, None, None)
    assert unknown.mean(SIZE, 0.0) == unknown.end(SIZE, 0.0) == {NOW: 1.0}
