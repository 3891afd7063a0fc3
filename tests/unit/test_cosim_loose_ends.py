"""Inputs that nobody feeds: which are told, by what, and which are meant to be so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.described import described

from m4e_fmi.cosim import Component, FmuFile, Simulation, System
from m4e_fmi.cosim.connect import connect
from m4e_fmi.cosim.loose_ends import loose_ends
from m4e_fmi.fmu.reading import Description

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
    assert line.startswith("control takes inputs, but none of its outputs leads anywhere")
    assert "'control.effort -> cart.joint.rail.effort' seems to be left out" in line
    # an output of the system leads somewhere
    assert told(pair("cart", "control"), LOOP[0], outputs={"u": "control.effort"}) == []
    # over another component
    lag = described("lag", ("u", "input", "m"), ("y", "output", "m"))
    way = ("cart.joint.rail.q -> lag.u", "lag.y -> control.angle")
    assert len(told({**pair("cart", "control"), "lag": lag}, *way)) == 1


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
        "line is connected with nothing: it does not act on the others, nor they on it"
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
