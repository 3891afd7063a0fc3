"""Panels of damped lids in gaps; Capytaine's approximation of finite depth."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from support.hulls import configured, hulls

from m4e_adapters.hydrodynamics.flow.capytaine_setup import accurate_finite_depth, import_capytaine
from m4e_adapters.hydrodynamics.flow.gap_lid import damped_lid


def lid_panels(size: float, bodies: dict[str, Any]) -> np.ndarray:
    """Centres (n, 3) [m] of the panels of a square lid about the origin."""
    lid = {"length": size, "width": size, "damping": 0.1}
    given = configured({"dimensions": 3, "bodies": bodies, "gap_lids": [lid]})
    found = damped_lid(given.gap_lids, hulls(given))
    assert found is not None
    assert np.all(found.panels.centers[:, 2] == 0)
    return found.panels.centers


def test_a_lid_between_two_barges_and_around_them() -> None:
    bodies = {
        name: {
            "shape": {"box": {"length": 16, "width": 8, "draft": 2, "center_y": y}},
            "center_of_gravity": [0, y, 0],
            "panels": 120,
        }
        for name, y in (("left", -6.0), ("right", 6.0))
    }
    x, y, _ = lid_panels(30, bodies).T
    assert not np.any((np.abs(x) < 8) & (np.abs(y) > 2) & (np.abs(y) < 10))
    assert np.any(np.abs(y) < 2)


def test_a_lid_in_a_moonpool_and_around_the_ring() -> None:
    ring = {"torus": {"radius": 6, "tube_radius": 1}}
    centers = lid_panels(16, {"ring": {"shape": ring, "center_of_gravity": [0, 0, -0.2]}})
    radii = np.hypot(*centers[:, :2].T)
    assert not np.any((radii > 5) & (radii < 7))
    assert radii.min() < 1
    assert radii.max() > 7.5


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
