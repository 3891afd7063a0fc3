"""Numbers in summaries: four significant digits, in units of a fitting size."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.report.digits import aligned, percent, quantity
from m4e_fmi.report.panels import by_unit, panels
from m4e_fmi.results.series import Series


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.4, "400.0 mW"),
        (0.0, "0.000 W"),
        (2.5, "2.500 W"),
        (-1234.6, "-1.235 kW"),
        (98_765_432.0, "98.77 MW"),
        (4e-4, "0.0004000 W"),
        (1e-17, "1.000e-17 W"),
        (float("inf"), "inf GW"),
    ],
)
def test_the_unit_follows_the_size(value: float, text: str) -> None:
    assert quantity(value, "W") == text


def test_values_of_a_line_have_equally_many_decimals() -> None:
    assert aligned(-1.23456, 0.00049, 12.3456) == ["-1.23", "0.00", "12.35"]
    assert aligned(-0.001, 0.0, 12345.6) == ["0", "0", "12346"]


def series(name: str, unit: str, largest: float) -> Series:
    return Series(name, unit, name, largest * np.sin(np.linspace(0.0, 6.0, 50)))


def test_a_small_power_has_a_panel_of_its_own() -> None:
    """Large, similar, a hundredth, and a rounding error, which makes no panel."""
    sizes = {"wave.power": 5e5, "pto.power": 3e4, "pump.power": 2e3, "valve.power": 1e-9}
    found = {name: series(name, "W", size) for name, size in sizes.items()}
    for shown in (by_unit(found), panels({**found, "z": series("body.m.z", "m", 1.0)})[1:]):
        assert [(panel.unit, list(panel.series)) for panel in shown] == [
            ("kW", ["wave.power", "pto.power", "valve.power"]),
            ("kW", ["pump.power"]),
        ]
        assert max(shown[1].curves["pump.power"]) == pytest.approx(2.0, rel=1e-2)


def test_other_units_stay_together() -> None:
    found = {name: series(name, "m", size) for name, size in (("a.s", 1.0), ("b.s", 1e-4))}
    (panel,) = by_unit(found)
    assert (panel.unit, panel.scale, list(panel.series)) == ("m", 1.0, ["a.s", "b.s"])


def test_the_power_of_all_inputs_hides_no_take_off() -> None:
    """It has no panel beside the others, and is all that there is without them."""
    work, taken = series("float.inputs.power", "W", 5e6), series("pto.power", "W", 2e5)
    moved = series("body.m.z", "m", 1.0)
    (_, powers) = panels({one.name: one for one in (moved, work, taken)})
    assert list(powers.series) == ["pto.power"]
    assert list(by_unit({work.name: work})[0].series) == ["float.inputs.power"]


def test_a_share_that_is_rounded_to_nothing_has_no_sign() -> None:
    assert [percent(x) for x in (-2e-9, 0.0, 4e-8, -1.48e-4)] == [*["0.0000 %"] * 3, "-0.0148 %"]
