"""Inputs that nobody feeds: which are told, by what, and which are meant to be so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.described import described

from m4e_adapters.wind import WindConfig
from m4e_fmi.cosim import Component, FmuFile, Simulation, System
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.connections.missing.loose_ends import loose_ends
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.fmu.importer.reading import Description

CART = described(
    "cart",
    ("joint.rail.effort", "input", "N"),
    ("body.cart.force_x", "input", "N"),
    ("body.cart.moment_y", "input", "N.m"),
    ("point.tip.force_x", "input", "N"),
    ("point.tip.x", "output", "m"),
    ("point.tip.vx", "output", "m/s"),
    ("joint.rail.q", "output", "m"),
)
CONTROL = described(
    "control",
    ("angle", "input", "m"),
    ("wanted", "input", "m"),
    ("effort", "output", "N"),
)
LINE = described(
    "line", ("end.x", "input", "m"), ("end.vx", "input", "m/s"), ("end.force_x", "output", "N")
)
METER = described("meter", ("x", "input", "m"), ("power", "output", "W"))
ALL = {"cart": CART, "control": CONTROL, "line": LINE}
LOOP = ("cart.joint.rail.q -> control.angle", "control.effort -> cart.joint.rail.effort")
WANTED = {"control": {"wanted": 0.0}}


def told(
    descriptions: dict[str, Description],
    *connections: str,
    start: dict[str, dict] = WANTED,
    **more,
) -> list[str]:
    parts = tuple(
        Component(name, FmuFile(Path(name)), start.get(name, {})) for name in descriptions
    )
    system = System("s", parts, connections, Simulation(1.0, 0.1), **more)
    return loose_ends(system, descriptions, connect(system, descriptions))


def pair(*names: str) -> dict[str, Description]:
    return {name: ALL[name] for name in names}


def test_a_complete_loop_is_silent() -> None:
    assert told(pair("cart", "control"), *LOOP) == []
    assert told(ALL, *LOOP, "cart.tip <-> line.end") == []


def test_an_input_of_a_controller_that_nobody_feeds() -> None:
    (line,) = told(pair("cart", "control"), LOOP[1])
    assert line == (
        "control.angle is connected to nothing and runs on its start value 0 m: connect it, or set "
        "it under start: if that is meant"
    )
    (line,) = told(pair("cart", "control"), LOOP[1], start={})
    assert line.startswith("control: 2 inputs are connected to nothing and run on their start ")
    assert "angle (0 m), wanted (0 m): connect them" in line


def test_a_start_value_or_an_input_of_the_system_is_meant() -> None:
    parts = pair("cart", "control")
    assert len(told(parts, *LOOP, start={})) == 1
    assert told(parts, *LOOP, start={"control": {"wanted": 0.5}}) == []
    assert told(parts, *LOOP, start={}, inputs={"wish": ("control.wanted",)}) == []


def test_a_controller_whose_output_leads_nowhere() -> None:
    (line,) = told(pair("cart", "control"), LOOP[0])
    assert line.startswith("control takes inputs, but none of its outputs is connected")
    assert "'control.effort -> cart.joint.rail.effort' seems to be left out" in line
    # an output of the system leads somewhere
    assert told(pair("cart", "control"), LOOP[0], outputs={"u": "control.effort"}) == []
    # over another component
    lag = described("lag", ("u", "input", "m"), ("y", "output", "m"))
    way = ("cart.joint.rail.q -> lag.u", "lag.y -> control.angle")
    assert len(told({**pair("cart", "control"), "lag": lag}, *way)) == 1


def test_an_output_of_another_name_is_not_suggested_for_one_of_many_loads() -> None:
    control = described("control", ("angle", "input", "m"), ("f", "output", "N"))
    (line,) = told({"cart": CART, "control": control}, LOOP[0], start={})
    assert "none of its outputs is connected, and loads of cart are connected to nothing" in line
    assert "->" not in line
    # of the only load in its unit it is
    torque = described("control", ("angle", "input", "m"), ("f", "output", "N.m"))
    (line,) = told({"cart": CART, "control": torque}, LOOP[0], start={})
    assert "'control.f -> cart.body.cart.moment_y' seems to be left out" in line
    # what has no unit might be anything
    plain = described("control", ("angle", "input", "m"), ("f", "output", ""))
    (line,) = told({"cart": CART, "control": plain}, LOOP[0], start={})
    assert "->" not in line


WATER = described(
    "water",
    *((f"cart.{name}", "input", unit) for name, unit in (("x", "m"), ("vx", "m/s"))),
    *((f"mast.{name}", "output", "N") for name in ("force_x", "heeling_force_x")),
    ("cart.force_x", "output", "N"),
    ("added_mass", "calculatedParameter", "kg"),
)
HULL = described(
    "hull",
    ("added_mass", "parameter", "kg"),
    *((f"body.{body}.force_x", "input", "N") for body in ("cart", "mast")),
    *((f"body.{body}.x", "output", "m") for body in ("cart", "mast")),
    *((f"body.{body}.vx", "output", "m/s") for body in ("cart", "mast")),
)
AFLOAT = {"hull": HULL, "water": WATER}
CARRIED, MAST = "water.added_mass -> hull.added_mass", "hull.mast <-> water.mast"
MISSING = "'hull.body.cart <-> water.cart' seems to be left out"


def test_a_connector_beside_others_that_are_connected() -> None:
    assert told(AFLOAT, CARRIED, MAST, "hull.cart <-> water.cart", start={}) == []
    (line,) = told(AFLOAT, CARRIED, MAST, start={})
    assert line.startswith("water: 2 inputs are connected to nothing and run on their start values")
    assert f"connect them ({MISSING}), or set them under start:" in line


def test_a_connector_with_start_values_whose_forces_lead_nowhere() -> None:
    fixed = {"water": {"cart.x": 0.0, "cart.vx": 0.0}}
    (line,) = told(AFLOAT, CARRIED, MAST, start=fixed)
    assert line == (
        f"water.cart leads nowhere, and hull.body.cart takes nothing: {MISSING}; if it only "
        "watches, name its outputs under outputs:"
    )
    watched = {"outputs": {"force": "water.cart.force_x"}}
    assert told(AFLOAT, CARRIED, MAST, start=fixed, **watched) == []


def test_a_connector_of_outputs_only() -> None:
    rest = (CARRIED, "hull.cart <-> water.cart")
    (line,) = told(AFLOAT, *rest, start={})
    assert line.startswith("water.mast leads nowhere, and hull.body.mast takes nothing")
    assert "'hull.body.mast <-> water.mast' seems to be left out" in line


def test_of_two_connectors_that_fit_none_is_suggested() -> None:
    parts = {"hull": HULL, "other": replace(HULL), "water": WATER}
    lines = told(parts, CARRIED, MAST, "water.added_mass -> other.added_mass", start={})
    assert [line for line in lines if line.startswith("water: 2 inputs")]
    assert not [line for line in lines if "hull.body.cart <-> water.cart" in line]


def test_a_connector_of_other_units_is_not_suggested() -> None:
    odd = described("water", ("cart.x", "input", "kg"), ("mast.force_x", "output", "N"))
    (line,) = told({"hull": HULL, "water": odd}, MAST, start={})
    assert line.startswith("water.cart.x is connected to nothing")
    assert "<->" not in line


def test_a_meter_may_lead_nowhere() -> None:
    assert told({"cart": CART, "meter": METER}, "cart.point.tip.x -> meter.x") == []


@pytest.mark.parametrize(
    ("left_out", "text"),
    [
        ("line.end.force_x -> cart.point.tip.force_x", "cart.point.tip and line.end are connected"),
        ("cart.point.tip.x -> line.end.x", "line.end.x is connected to nothing"),
        ("cart.point.tip.vx -> line.end.vx", "line.end.vx is connected to nothing"),
    ],
)
def test_half_a_connector(left_out: str, text: str) -> None:
    whole = (
        "line.end.force_x -> cart.point.tip.force_x",
        "cart.point.tip.x -> line.end.x",
        "cart.point.tip.vx -> line.end.vx",
    )
    parts = pair("cart", "line")
    assert told(parts, *whole) == []
    (line,) = told(parts, *(c for c in whole if c != left_out))
    assert text in line


def test_components_that_are_connected_with_nothing() -> None:
    assert told(ALL, *LOOP) == [
        "line is connected with nothing: it does not interact with the others "
        "('cart.point.tip <-> line.end' seems to be left out)"
    ]
    assert told(pair("cart", "line")) == ["cart, line: no component is connected with another"]
    assert told({"cart": CART}) == []


def test_arrays_are_told_once_and_many_inputs_in_one_line() -> None:
    many = described(
        "many",
        *((f"u[{k}]", "input", "m") for k in range(100)),
        *((f"v{k}", "input", "m") for k in range(50)),
        ("y", "output", "N"),
    )
    (line,) = told({"cart": CART, "many": many}, "many.y -> cart.joint.rail.effort")
    assert line.startswith("many: 51 inputs are connected to nothing")
    assert "u[…] (0 m), v0 (0 m), v1 (0 m), v2 (0 m) and 47 more" in line


def test_a_load_that_is_not_zero_is_told() -> None:
    moved = replace(CART.variables["body.cart.force_x"], start="5.0")
    cart = replace(CART, variables={**CART.variables, moved.name: moved})
    (line,) = told({"cart": cart, "control": CONTROL}, *LOOP)
    assert "cart.body.cart.force_x is connected to nothing and runs on its start value 5 N" in line


@pytest.mark.parametrize("direction", [{}, {"direction": 0.0}])
def test_an_input_that_its_configuration_gives_is_not_told(direction: dict[str, float]) -> None:
    point = {"area": 1.0, "coefficient": 1.0, "at": [0, 0, 5]}
    config = {"dimensions": 3, "speed": 15.0, "points": {"tip": point}, **direction}
    wind = described(
        "wind", ("wind.speed", "input", "m/s"), ("wind.direction", "input", "rad"),
        ("tip.x", "input", "m"), ("tip.force_x", "output", "N"),
    )  # fmt: skip
    found = {"cart": CART, "wind": wind}
    parts = (
        Component("cart", FmuFile(Path("cart"))),
        Component("wind", Kind("wind", WindConfig.model_validate(config))),
    )
    system = System("s", parts, ("cart.tip <-> wind.tip",), Simulation(1.0, 0.1))
    lines = "".join(loose_ends(system, found, connect(system, found)))
    assert ("wind.wind.direction is connected to nothing" in lines) == (not direction)
    assert "wind.speed" not in lines
