"""Inputs that nobody feeds: which are told, by what, and which are meant to be so."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from support.described import described

from m4e_adapters.wind import WindConfig
from m4e_fmi.cosim import Component, FmuFile, Simulation, System
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.missing import loose_ends
from m4e_fmi.fmu.importer.reading import Description

GIVEN: dict[str, Any] = YAML(typ="safe").load(Path(__file__).with_name("loose_ends.yaml"))
FMUS = {
    name: described(name, *((n, *text.partition(" ")[::2]) for n, text in variables.items()))
    for name, variables in GIVEN["fmus"].items()
}
CART, LOOP = FMUS["cart"], GIVEN["cases"]["a complete loop"]["connections"]


def told(
    fmus: Mapping[str, Description],
    connections: Sequence[str],
    start: Mapping[str, Any] | None = None,
    **more: Any,
) -> list[str]:
    parts = tuple(Component(n, FmuFile(Path(n)), (start or {}).get(n, {})) for n in fmus)
    system = System("s", parts, tuple(connections), Simulation(1.0, 0.1), **more)
    return loose_ends(system, fmus, connect(system, fmus))


@pytest.mark.parametrize("name", GIVEN["cases"])
def test_what_is_told(name: str) -> None:
    case: dict[str, Any] = {"connections": (), "told": (), **GIVEN["cases"][name]}
    given = {n: FMUS[fmu] for n, fmu in case.pop("fmus").items()}
    texts = case.pop("told")
    lines = told(given, **case)
    assert bool(lines) == bool(texts)
    assert all(text in lines[0] for text in texts)
    assert len(lines) <= 1


def test_arrays_are_told_once_and_many_inputs_in_one_line() -> None:
    arrays = [(f"u[{k}]", "input", "m") for k in range(100)]
    many = described(
        "many", *arrays, *((f"v{k}", "input", "m") for k in range(50)), ("y", "output", "N")
    )
    (line,) = told({"cart": CART, "many": many}, ["many.y -> cart.joint.rail.effort"])
    assert line.startswith("many: 51 inputs are connected to nothing")
    assert "u[…] (0 m), v0 (0 m), v1 (0 m), v2 (0 m) and 47 more" in line


def test_a_load_that_is_not_zero_is_told() -> None:
    moved = replace(CART.variables["body.cart.force_x"], start="5.0")
    cart = replace(CART, variables={**CART.variables, moved.name: moved})
    given = {"cart": cart, "control": FMUS["control"]}
    (line,) = told(given, LOOP, {"control": {"wanted": 0.0}})
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
