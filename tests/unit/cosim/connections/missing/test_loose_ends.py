"""Inputs that nobody feeds: which are told, by what, and which are meant to be so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.described import described

from m4e_adapters.wind import WindConfig
from m4e_fmi.cosim import Component, FmuFile, Simulation, System
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.connections.missing.loose_ends import loose_ends
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.fmu.importer.reading import Description

Parts = Mapping[str, Description]

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
LINE = described(
    "line", ("end.x", "input", "m"), ("end.vx", "input", "m/s"), ("end.force_x", "output", "N")
)
LAG = described("lag", ("u", "input", "m"), ("y", "output", "m"))
MANY = described(
    "many",
    *((f"u[{k}]", "input", "m") for k in range(100)),
    *((f"v{k}", "input", "m") for k in range(50)),
    ("y", "output", "N"),
)
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


def control(*outputs: tuple[str, str]) -> Description:
    """A controller with these outputs and units."""
    given = [(name, "output", unit) for name, unit in outputs or (("effort", "N"),)]
    return described("control", ("angle", "input", "m"), ("wanted", "input", "m"), *given)


def parts(**more: Description) -> Parts:
    return {"cart": CART, "control": control(), **more}


LOOP = ("cart.joint.rail.q -> control.angle", "control.effort -> cart.joint.rail.effort")
TIP = "cart.tip <-> line.end"
SENSED = ("cart.point.tip.x -> line.end.x", "cart.point.tip.vx -> line.end.vx")
PULL = "line.end.force_x -> cart.point.tip.force_x"
WANTED: dict[str, dict[str, Any]] = {"control": {"wanted": 0.0}}
AFLOAT: Parts = {"hull": HULL, "water": WATER}
CARRIED, MAST = "water.added_mass -> hull.added_mass", "hull.mast <-> water.mast"
MISSING = "'hull.body.cart <-> water.cart' seems to be left out"
FIXED = {"water": {"cart.x": 0.0, "cart.vx": 0.0}}
NOWHERE = "control takes inputs, but none of its outputs is connected"


def told(
    given: Parts, *connections: str, start: Mapping[str, Any] = WANTED, **more: Any
) -> list[str]:
    components = tuple(Component(n, FmuFile(Path(n)), start.get(n, {})) for n in given)
    system = System("s", components, connections, Simulation(1.0, 0.1), **more)
    return loose_ends(system, given, connect(system, given))


@pytest.mark.parametrize(
    ("given", "connections", "more"),
    [
        (parts(), LOOP, {}),
        (parts(line=LINE), (*LOOP, TIP), {}),
        (parts(), LOOP, {"start": {"control": {"wanted": 0.5}}}),
        (parts(), LOOP, {"start": {}, "inputs": {"wish": ("control.wanted",)}}),
        # an output of the system leads somewhere
        (parts(), LOOP[:1], {"outputs": {"u": "control.effort"}}),
        (AFLOAT, (CARRIED, MAST, "hull.cart <-> water.cart"), {"start": {}}),
        (AFLOAT, (CARRIED, MAST), {"start": FIXED, "outputs": {"force": "water.cart.force_x"}}),
        # a meter may lead nowhere
        (
            {"cart": CART, "meter": described("m", ("x", "input", "m"), ("power", "output", "W"))},
            ("cart.point.tip.x -> meter.x",), {},
        ),
        ({"cart": CART, "line": LINE}, (PULL, *SENSED), {}),
        ({"cart": CART}, (), {}),
    ],
)  # fmt: skip
def test_what_is_meant_is_silent(
    given: Parts, connections: tuple[str, ...], more: dict[str, Any]
) -> None:
    assert told(given, *connections, **more) == []


@pytest.mark.parametrize(
    ("given", "connections", "start", "texts"),
    [
        (parts(), LOOP[1:], WANTED, [
            "control.angle is connected to nothing and runs on its start value 0 m: connect it, "
            "or set it under start: if that is meant",
        ]),
        (parts(), LOOP[1:], {}, [
            "control: 2 inputs are connected to nothing and run on their start ",
            "angle (0 m), wanted (0 m): connect them",
        ]),
        (parts(), LOOP, {}, ["control.wanted is connected to nothing"]),
        (parts(), LOOP[:1], WANTED, [
            NOWHERE, "'control.effort -> cart.joint.rail.effort' seems to be left out",
        ]),
        (  # over another component
            parts(lag=LAG), ("cart.joint.rail.q -> lag.u", "lag.y -> control.angle"), WANTED,
            [NOWHERE],
        ),
        # of another name it might be for any of many loads; for the only one of its unit it is
        (parts(control=control(("f", "N"))), LOOP[:1], WANTED, [
            f"{NOWHERE}, and loads of cart are connected to nothing", "not: ->",
        ]),
        (parts(control=control(("f", "N.m"))), LOOP[:1], WANTED, [
            "'control.f -> cart.body.cart.moment_y' seems to be left out",
        ]),
        (parts(control=control(("f", ""))), LOOP[:1], WANTED, [NOWHERE, "not: ->"]),
        (AFLOAT, (CARRIED, MAST), {}, [
            "water: 2 inputs are connected to nothing and run on their start values",
            f"connect them ({MISSING}), or set them under start:",
        ]),
        (AFLOAT, (CARRIED, MAST), FIXED, [
            "water.cart leads nowhere, and hull.body.cart takes nothing: "
            f"{MISSING}; if it only watches, name its outputs under outputs:",
        ]),
        (AFLOAT, (CARRIED, "hull.cart <-> water.cart"), {}, [
            "water.mast leads nowhere, and hull.body.mast takes nothing",
            "'hull.body.mast <-> water.mast' seems to be left out",
        ]),
        (  # of other units
            {"hull": HULL, "water": described(
                "water", ("cart.x", "input", "kg"), ("mast.force_x", "output", "N")
            )}, (MAST,), {}, ["water.cart.x is connected to nothing", "not: <->"],
        ),
        ({"cart": CART, "line": LINE}, SENSED, {}, ["cart.point.tip and line.end are connected"]),
        ({"cart": CART, "line": LINE}, (PULL, SENSED[1]), {}, ["line.end.x is connected to not"]),
        ({"cart": CART, "line": LINE}, (PULL, SENSED[0]), {}, ["line.end.vx is connected to not"]),
        (parts(line=LINE), LOOP, WANTED, [
            "line is connected with nothing: it does not interact with the others "
            "('cart.point.tip <-> line.end' seems to be left out)",
        ]),
        ({"cart": CART, "line": LINE}, (), {}, [
            "cart, line: no component is connected with another",
        ]),
        ({"cart": CART, "many": MANY}, ("many.y -> cart.joint.rail.effort",), {}, [
            "many: 51 inputs are connected to nothing",
            "u[…] (0 m), v0 (0 m), v1 (0 m), v2 (0 m) and 47 more",
        ]),
    ],
)  # fmt: skip
def test_one_loose_end_is_one_line(
    given: Parts, connections: tuple[str, ...], start: dict[str, Any], texts: list[str]
) -> None:
    """With the connection that seems to be left out, if there is one that fits."""
    (line,) = told(given, *connections, start=start)
    for text in texts:
        assert (text.removeprefix("not: ") in line) == (not text.startswith("not: "))


def test_of_two_connectors_that_fit_none_is_suggested() -> None:
    given = {**AFLOAT, "other": replace(HULL)}
    lines = told(given, CARRIED, MAST, "water.added_mass -> other.added_mass", start={})
    assert [line for line in lines if line.startswith("water: 2 inputs")]
    assert not [line for line in lines if "hull.body.cart <-> water.cart" in line]


def test_a_load_that_is_not_zero_is_told() -> None:
    moved = replace(CART.variables["body.cart.force_x"], start="5.0")
    cart = replace(CART, variables={**CART.variables, moved.name: moved})
    (line,) = told(parts(cart=cart), *LOOP)
    assert "cart.body.cart.force_x is connected to nothing and runs on its start value 5 N" in line


@pytest.mark.parametrize("direction", [{}, {"direction": 0.0}])
def test_an_input_that_its_configuration_gives_is_not_told(direction: dict[str, float]) -> None:
    point = {"area": 1.0, "coefficient": 1.0, "at": [0, 0, 5]}
    config = {"dimensions": 3, "speed": 15.0, "points": {"tip": point}, **direction}
    wind = described(
        "wind", ("wind.speed", "input", "m/s"), ("wind.direction", "input", "rad"),
        ("tip.x", "input", "m"), ("tip.force_x", "output", "N"),
    )  # fmt: skip
    components = (
        Component("cart", FmuFile(Path("cart"))),
        Component("wind", Kind("wind", WindConfig.model_validate(config))),
    )
    system = System("s", components, ("cart.tip <-> wind.tip",), Simulation(1.0, 0.1))
    found = {"cart": CART, "wind": wind}
    lines = "".join(loose_ends(system, found, connect(system, found)))
    assert ("wind.wind.direction is connected to nothing" in lines) == (not direction)
    assert "wind.speed" not in lines
