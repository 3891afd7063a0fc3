"""Numbers, tables and summaries as text; panels of time histories."""

from __future__ import annotations

import numpy as np
import pytest
from support.reports import results_of

from m4e_fmi.report.panels import MOST_LINES, by_unit, fitting, moving, panels
from m4e_fmi.report.text import summaries
from m4e_fmi.results.series import Series

SINE = np.sin(np.linspace(0.0, 6.0, 50))


def series(unit: str, **sizes: float) -> dict[str, Series]:
    """Sines by name, `_` for a point; the size is the largest value."""
    names = {name.replace("_", "."): size for name, size in sizes.items()}
    return {name: Series(name, unit, name, size * SINE) for name, size in names.items()}


def test_powers_are_shown_in_a_unit_that_fits() -> None:
    (panel,) = by_unit(series("W", wave_power=5e5, pump_power=2e3))
    assert (panel.unit, list(panel.series)) == ("kW", ["wave.power", "pump.power"])
    assert max(panel.curves["pump.power"]) == pytest.approx(2.0, rel=1e-2)
    (panel,) = by_unit(series("m", a_s=1.0, b_s=1e-4))
    assert (panel.unit, panel.scale, list(panel.series)) == ("m", 1.0, ["a.s", "b.s"])


def test_the_power_of_all_inputs_hides_no_take_off() -> None:
    """It has no panel beside the others, and is all that there is without them."""
    powers = series("W", float_inputs_power=5e6, pto_power=2e5)
    (_, shown) = panels({**powers, **series("m", body_m_z=1.0)})
    assert list(shown.series) == ["pto.power"]
    assert list(by_unit(series("W", a_inputs_power=1.0))[0].series) == ["a.inputs.power"]


def test_what_stands_still_or_moves_by_rounding_is_left_out() -> None:
    """Sway and yaw of a symmetric hull: 1e-17 m in pictures and summaries say nothing."""
    moved = series("m", body_hull_x=0.3, body_hull_y=1e-17, body_hull_z=1e-9)
    still = {"body.m.x": Series("x", "m", "x", np.full(50, 2.0)), **series("rad", body_m_theta=0.0)}
    shown = panels({**still, **moved})
    assert [panel.title for panel in shown] == ["motion from start", "rotation"]
    assert [list(panel.series) for panel in moving(shown)] == [["body.hull.x", "body.hull.z"]]
    nothing = panels(still)
    assert moving(nothing) == nothing
    lost = {**moved, "body.hull.x": Series("x", "m", "x", np.full(50, np.nan))}
    assert [list(panel.series) for panel in moving(panels(lost))] == [[*moved]]


def test_mechanisms_are_shown_by_their_joints() -> None:
    """Angles, positions, efforts; those of bodies where there is water, or no joint."""
    bodies = series("m", body_m_x=1.0, body_m_z=1.0) | series("rad", body_m_theta=1.0)
    joints = series("rad", joint_pin_q=1.0) | series("m", joint_rail_q=1.0)
    efforts = series("N.m", joint_pin_effort=1.0, load_coil_moment=2.0) | series(
        "N", joint_rail_effort=3.0
    )
    titles = ["joint angles", "joint positions", "efforts", "efforts"]
    assert [panel.title for panel in panels(bodies | joints | efforts)] == titles
    assert [panel.title for panel in panels(bodies | series("rad", joint_pin_q=1.0))] == titles[:1]
    wave = series("m", wave_elevation=1.0)
    usual = ["motion from start", "rotation"]
    assert [panel.title for panel in panels(bodies)] == usual
    assert [panel.title for panel in panels(bodies | joints | wave)] == ["wave elevation", *usual]


def test_angles_are_drawn_without_jumps_and_kept_as_they_are() -> None:
    """A turn and a half in steps of 0.1 rad; what is beyond half a turn has no jumps by itself."""
    angle = np.arange(0.0, 3 * np.pi, 0.1)
    turned = Series("body.m.psi", "rad", "", (angle + np.pi) % (2 * np.pi) - np.pi)
    spun = Series("body.m.theta", "rad", "", 40 * angle)
    (panel,) = by_unit({"psi": turned, "theta": spun})
    np.testing.assert_allclose(panel.curves["psi"], angle, atol=1e-12)
    np.testing.assert_array_equal(panel.curves["theta"], 40 * angle)
    assert turned.values.max() < np.pi


def test_of_many_series_those_that_vary_most_are_shown() -> None:
    (panel,) = by_unit({f"{k}": Series(f"{k}", "m", "", k * SINE) for k in range(10)})
    shown = fitting(panel)
    assert set(shown.series) == {f"{k}" for k in range(10 - MOST_LINES, 10)}
    assert shown.left_out == 10 - MOST_LINES


def test_mean_powers_weigh_rows_by_the_time_between_them() -> None:
    """0 W to 2 W within the first second of ten, 2 W from there on; the inputs' is no other."""
    powers = {"pto.power": [0.0, 2.0, 2.0], "a.inputs.power": [-3.0, -3.0, -3.0]}
    time = np.array([0.0, 1.0, 10.0])
    values = {name: np.array(rows) for name, rows in powers.items()}
    made = results_of(time, values, units=dict.fromkeys(values, "W"))
    assert summaries.result_text(made) == "mean power 1.900 W (pto, 19.00 J in 10 s)"
