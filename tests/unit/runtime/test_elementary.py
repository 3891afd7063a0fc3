"""The runtime's elementary functions against mpmath."""

from __future__ import annotations

import ctypes
import ctypes.util
import itertools
import math
import random
import sys
from collections.abc import Callable
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from m4e_fmi.program import Recorder, Variable, functions
from m4e_fmi.runtime.compiler import cached_shared
from m4e_fmi.runtime.engine import Engine

SOURCE = """#include "elementary.h"
#pragma GCC visibility push(default)
double m4e_sin(double x);
double m4e_sin(double x) { return el_sin(x); }
double m4e_cos(double x);
double m4e_cos(double x) { return el_cos(x); }
void m4e_sincos_many(size_t count, const double *x, double *sine, double *cosine);
void m4e_sincos_many(size_t count, const double *x, double *sine, double *cosine) {
    el_sincos_many(count, x, sine, cosine);
}
"""


@pytest.fixture(scope="module")
def lib() -> ctypes.CDLL:
    """The runtime's sine and cosine, compiled as for its library."""
    found = ctypes.CDLL(str(cached_shared("elementary", [], SOURCE)))
    for function in (found.m4e_sin, found.m4e_cos):
        function.restype, function.argtypes = ctypes.c_double, (ctypes.c_double,)
    found.m4e_sincos_many.argtypes = (ctypes.c_size_t, *[ctypes.c_void_p] * 3)
    return found


def _nearest_to_zeros(first: int, last: int) -> list[float]:
    """Doubles next to k·π/2: most digits of the reduced argument cancel."""
    return [float(k * mpmath.pi / 2) for k in range(first, last)]


def _between(low: float, high: float, count: int = 700) -> list[float]:
    rng = random.Random(2)
    return [rng.uniform(low, high) for _ in range(count)]


def _magnitudes(first: int, last: int, count: int = 700) -> list[float]:
    rng = random.Random(3)
    return [
        rng.choice((-1, 1)) * math.ldexp(rng.uniform(0.5, 1), rng.randrange(first, last))
        for _ in range(count)
    ]


with mpmath.workprec(1300):  # exponents up to 1024 plus the digits of the result
    ANGLES = {
        "reduced": _between(-0.8, 0.8),
        "usual": _between(-1e5, 1e5),
        "near zeros": _nearest_to_zeros(1, 500) + _nearest_to_zeros(63_600, 64_000),
        "large near zeros": [float(random.Random(k).randrange(10**6, 10**15) * mpmath.pi / 2)
                             for k in range(500)],
        "all magnitudes": _magnitudes(-1070, 1025, 1500),
        # the double nearest to a multiple of π/2 (Muller, Elementary Functions, section 9.1.2)
        "extreme": [6381956970095103 * 2.0**797, sys.float_info.max, 1e5, 100000.00000000001],
    }  # fmt: skip


@pytest.mark.parametrize("kind", ANGLES)
def test_sine_and_cosine_are_within_one_ulp(kind: str, lib: ctypes.CDLL) -> None:
    with mpmath.workprec(1300):
        for x in ANGLES[kind]:
            for got, exact in (
                (lib.m4e_sin(x), mpmath.sin(mpmath.mpf(x))),
                (lib.m4e_cos(x), mpmath.cos(mpmath.mpf(x))),
            ):
                assert abs(mpmath.mpf(got) - exact) < math.ulp(float(abs(exact))), x


def test_vectors_give_the_bits_of_single_calls(lib: ctypes.CDLL) -> None:
    x = np.array([*ANGLES["usual"], *ANGLES["all magnitudes"]])
    x[::97] = np.inf
    sine, cosine = np.empty_like(x), np.empty_like(x)
    lib.m4e_sincos_many(x.size, x.ctypes.data, sine.ctypes.data, cosine.ctypes.data)
    np.testing.assert_array_equal(sine, [lib.m4e_sin(v) for v in x])
    np.testing.assert_array_equal(cosine, [lib.m4e_cos(v) for v in x])
    assert np.isnan(sine[::97]).all()
    assert np.isnan(lib.m4e_sin(math.nan))


def runtime(name: str, arguments: int) -> Callable[..., float]:
    """The operation `name` as the interpreter computes it."""
    r = Recorder(name, name)
    given = [r.input(Variable(n, "1", "argument", start=0.5)) for n in "ab"[:arguments]]
    value = given[0] ** given[1] if name == "pow" else getattr(functions, name)(*given)
    r.output(Variable("y", "1", "value"), value)
    engine = Engine(r.program())

    def evaluated(*values: float) -> float:
        engine.set_inputs(values)
        return float(engine.outputs(0.0, [])[0])

    return evaluated


NEAR_ONE = [1.0 + sign * 2.0**-k for k in range(1, 53) for sign in (-1, 1)]
ARGUMENTS: dict[str, list[float]] = {
    "exp": [*_between(-745.2, 709.8), *_between(-1, 1), *_magnitudes(-60, 9), -745.13, 709.78],
    "log": [*map(abs, _magnitudes(-1073, 1024)), *_between(0.5, 2), *NEAR_ONE, 5e-324],
    "tanh": [*_between(-23, 23), *_between(-1, 1), *_magnitudes(-1000, 3)],
    "tan": [*_between(-1e5, 1e5), *_magnitudes(-1000, 1024), *_nearest_to_zeros(1, 1500)],
    "asin": [*_between(-1, 1), *_magnitudes(-1000, 0), *(x for x in NEAR_ONE if x <= 1), 1.0],
    "acos": [*_between(-1, 1), *_magnitudes(-100, 0), *(x for x in NEAR_ONE if x <= 1), -1.0],
    "atan": [*_between(-3, 3), *_magnitudes(-1073, 1024), *NEAR_ONE],
}


@pytest.mark.parametrize("name", ARGUMENTS)
def test_functions_are_within_one_ulp(name: str) -> None:
    function, exact = runtime(name, 1), getattr(mpmath, name)
    with mpmath.workprec(1300):
        for x in ARGUMENTS[name]:
            true = exact(mpmath.mpf(x))
            assert abs(mpmath.mpf(function(x)) - true) < math.ulp(float(abs(true))), x


def test_powers_and_directions_are_within_one_ulp() -> None:
    rng = random.Random(4)
    power, angle = runtime("pow", 2), runtime("atan2", 2)
    bases = [*map(abs, _magnitudes(-40, 40, 400)), *_between(0.5, 2, 200), *NEAR_ONE]
    with mpmath.workprec(1300):
        for a in bases:
            b = rng.uniform(-700, 700) / max(abs(math.log(a)), 1e-3)
            for exponent in (b, rng.uniform(-3, 3), 2.0, -1.0, 0.5):
                true = mpmath.power(mpmath.mpf(a), mpmath.mpf(exponent))
                got = mpmath.mpf(power(a, exponent))
                assert abs(got - true) < math.ulp(float(true)), (a, exponent)
        for y, x in zip(_magnitudes(-300, 300), reversed(_magnitudes(-300, 299)), strict=True):
            for b, a in ((y, x), (x, x * rng.uniform(-3, 3))):
                true = mpmath.atan2(mpmath.mpf(b), mpmath.mpf(a))
                got = mpmath.mpf(angle(b, a))
                assert abs(got - true) < math.ulp(float(abs(true))), (b, a)


def test_whole_powers_are_exact_where_they_can_be() -> None:
    power = runtime("pow", 2)
    for base in (2.0, 3.0, -7.0, 10.0, 1.5, -0.125):
        for exponent in range(-20 if abs(base) in (2.0, 0.125) else 0, 16):
            if Fraction(base) ** exponent == Fraction(float(Fraction(base) ** exponent)):
                assert power(base, float(exponent)) == float(Fraction(base) ** exponent)


SPECIAL = [0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 3.0, -3.0, 1e300, -1e300, 5e-324]
SPECIAL += [math.inf, -math.inf, math.nan]


@pytest.mark.parametrize(
    "name", ["exp", "log", "tanh", "tan", "asin", "acos", "atan", "pow", "atan2"]
)
def test_zeros_infinities_and_nan_are_those_of_the_c_library(name: str) -> None:
    """To 1 ulp, signs of zeros included."""
    count = 2 if name in ("pow", "atan2") else 1
    function = runtime(name, count)
    theirs = getattr(ctypes.CDLL(ctypes.util.find_library("m")), name)
    theirs.restype, theirs.argtypes = ctypes.c_double, [ctypes.c_double] * count
    for values in itertools.product(SPECIAL, repeat=count):
        got, expected = function(*values), theirs(*values)
        if math.isnan(expected):
            assert math.isnan(got), values
        else:
            assert math.isclose(got, expected, rel_tol=2**-52), values
            assert math.copysign(1, got) == math.copysign(1, expected), values
