"""Capytaine's approximation of finite depth."""

from __future__ import annotations

import warnings

import numpy as np

from m4e_adapters.hydrodynamics.flow.capytaine_setup import accurate_finite_depth, import_capytaine


def test_a_point_where_capytaines_function_has_no_value_is_left_out_in_silence() -> None:
    """Its Green function of finite depth, with its approximation made accurate: four terms are
    judged on x from -0.1 to 20 in 32 intervals; at one of these kh is x."""
    green = import_capytaine().Delhommeau()
    kh = float(np.linspace(-0.1, 20.0, 33)[13])
    with accurate_finite_depth(), warnings.catch_warnings():
        warnings.simplefilter("error")
        found, near = (green.find_best_exponential_decomposition(k) for k in (kh, kh + 1e-3))
    x = np.linspace(0.0, 20.0, 50)
    values = [np.exp(np.outer(x, rates)) @ amplitudes for rates, amplitudes in (found, near)]
    assert np.isfinite(found).all()
    assert np.abs(values[0] - values[1]).max() < 0.01
