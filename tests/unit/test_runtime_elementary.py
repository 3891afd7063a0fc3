"""The runtime's sine and cosine against mpmath."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest

from m4e_fmi.runtime.library import library


def _nearest_to_zeros(first: int, last: int) -> list[float]:
    """Doubles next to k·π/2: most digits of the reduced argument cancel."""
    return [float(k * mpmath.pi / 2) for k in range(first, last)]


def _arguments(kind: str) -> list[float]:
    rng = random.Random(1)
    with mpmath.workprec(1300):
        return {
            "reduced": [rng.uniform(-0.8, 0.8) for _ in range(3000)],
            "usual": [rng.uniform(-1e5, 1e5) for _ in range(3000)],
            "near zeros": _nearest_to_zeros(1, 1500) + _nearest_to_zeros(63_000, 64_000),
            "large near zeros": [
                float(rng.randrange(10**6, 10**15) * mpmath.pi / 2) for _ in range(1000)
            ],
            "all magnitudes": [
                math.ldexp(rng.uniform(-1, 1), rng.randrange(-1070, 1025)) for _ in range(3000)
            ],
            # the double nearest to a multiple of π/2 (Muller, Elementary Functions, section 9.1.2)
            "extreme": [
                6381956970095103 * 2.0**797,
                1.7976931348623157e308,
                1e5,
                100000.00000000001,
            ],
        }[kind]


@pytest.mark.parametrize(
    "kind", ["reduced", "usual", "near zeros", "large near zeros", "all magnitudes", "extreme"]
)
def test_sine_and_cosine_are_within_one_ulp(kind: str) -> None:
    lib = library()
    assert lib is not None
    with mpmath.workprec(1300):  # exponents up to 1024 plus the digits of the result
        for x in _arguments(kind):
            for got, exact in (
                (lib.m4e_sin(x), mpmath.sin(mpmath.mpf(x))),
                (lib.m4e_cos(x), mpmath.cos(mpmath.mpf(x))),
            ):
                assert abs(mpmath.mpf(got) - exact) < math.ulp(float(abs(exact))), x


def test_vectors_give_the_bits_of_single_calls() -> None:
    lib = library()
    assert lib is not None
    x = np.array([v for kind in ("usual", "all magnitudes") for v in _arguments(kind)])
    x[::97] = np.inf
    sine, cosine = np.empty_like(x), np.empty_like(x)
    lib.m4e_sincos_many(x.size, x.ctypes.data, sine.ctypes.data, cosine.ctypes.data)
    np.testing.assert_array_equal(sine, [lib.m4e_sin(v) for v in x])
    np.testing.assert_array_equal(cosine, [lib.m4e_cos(v) for v in x])
    assert np.isnan(sine[::97]).all()
    assert np.isnan(lib.m4e_sin(math.nan))
