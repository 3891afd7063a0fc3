"""Connection texts: what they connect, in which units (mistakes: tests/corpus/connections.yaml)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.described import described

from m4e_fmi.cosim import Component, FmuFile, Port, Simulation, System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import Wiring
from m4e_fmi.fmu.importer.reading import Description

SIMULATION = Simulation(stop_time=1, step_size=0.1)


def wired(descriptions: dict[str, Description], *connections: str) -> Wiring:
    components = tuple(Component(name, FmuFile(Path(f"{name}.fmu"))) for name in descriptions)
    return connect(System("s", components, connections, SIMULATION), descriptions)


BUOY = described(
    "buoy",
    ("body.float.x", "output", "m"),
    ("body.float.vx", "output", "m/s"),
    ("body.float.ax", "output", "m/s2"),
    ("body.float.force_x", "input", "N"),
    ("point.float.x", "output", "m"),
    ("point.fairlead.x", "output", "m"),
    ("point.fairlead.force_x", "input", "N"),
    ("added_mass[1,1]", "parameter", "kg"),
    ("added_mass[1,2]", "parameter", "kg"),
    ("level", "parameter", "kg"),
)
LEVEL = replace(BUOY.variables["level"], variability="tunable")
BUOY = replace(BUOY, variables={**BUOY.variables, "level": LEVEL})
HYDRO = described(
    "hydro",
    ("float.x", "input", "m"),
    ("float.vx", "input", "m/s"),
    ("float.force_x", "output", "N"),
    ("added_mass[1,1]", "calculatedParameter", "kg"),
    ("added_mass[1,2]", "calculatedParameter", "kg"),
    ("power", "output", "W"),
    ("short", "output", "mm"),
    ("plain", "output", ""),
    ("hot", "calculatedParameter", "degC"),
    ("warm", "parameter", "K"),
)
BOTH = {"buoy": BUOY, "hydro": HYDRO}


def test_a_connector_connects_equal_names_both_ways() -> None:
    wiring = wired(BOTH, "buoy.body.float <-> hydro.float")
    assert {str(link) for link in wiring.links} == {
        "buoy.body.float.x -> hydro.float.x",
        "buoy.body.float.vx -> hydro.float.vx",
        "hydro.float.force_x -> buoy.body.float.force_x",
    }
    assert wiring.unconnected == (Port("buoy", "point.fairlead.force_x"),)
    (bond,) = wiring.bonds
    axis = bond.axes[0]
    assert bond.name == "buoy.body.float <-> hydro.float"
    assert str(axis.force.source) == "hydro.float.force_x"
    assert str(axis.velocity.source) == "buoy.body.float.vx"
    assert axis.position is not None


@pytest.mark.parametrize(
    ("connection", "links", "once"),
    [
        # by its last part, if that is unique
        ("line.end <-> buoy.fairlead", ["line.end.force_x -> buoy.point.fairlead.force_x"], []),
        (
            "hydro.added_mass -> buoy.added_mass",
            [],
            [f"hydro.added_mass[1,{k}] -> buoy.added_mass[1,{k}]" for k in (1, 2)],
        ),
        # a variable without unit fits any
        (
            "hydro.plain -> buoy.body.float.force_x",
            ["hydro.plain -> buoy.body.float.force_x"],
            [],
        ),
        # at every point, as the parameter is tunable
        ("hydro.plain -> buoy.level, delayed", ["hydro.plain -> buoy.level"], []),
        ("hydro.added_mass[1,1] -> buoy.level", [], ["hydro.added_mass[1,1] -> buoy.level"]),
    ],
)
def test_what_is_connected(connection: str, links: list[str], once: list[str]) -> None:
    line = described("line", ("end.force_x", "output", "N"))
    wiring = wired({**BOTH, "line": line}, connection)
    assert [str(link) for link in wiring.links] == links
    assert [str(link) for link in wiring.initial_links] == once
    assert [link.delayed for link in wiring.links] == ["delayed" in connection] * len(links)


@pytest.mark.parametrize(
    ("connection", "factor", "offset"),
    [
        ("hydro.short -> hydro.float.x", 1e-3, 0.0),
        ("hydro.short * 2.5 + 1 -> hydro.float.x", 2.5e-3, 1.0),
        ("hydro.short * -2.5e1 - .5 -> hydro.float.x", -2.5e-2, -0.5),
        ("hydro.short * 2 -> hydro.float.x, units ignored", 2.0, 0.0),
        ("hydro.power -> buoy.body.float.force_x, units ignored", 1.0, 0.0),
        ("hydro.hot -> hydro.warm", 1.0, 273.15),
        ("hydro.hot * 2 + 1 -> hydro.warm", 2.0, 547.3),
    ],
)
def test_units_are_converted_before_factor_and_offset(
    connection: str, factor: float, offset: float
) -> None:
    wiring = wired(BOTH, connection)
    (link,) = (*wiring.links, *wiring.initial_links)
    assert (link.factor, link.offset) == pytest.approx((factor, offset), rel=1e-15)


def test_forces_and_velocities_may_be_connected_one_by_one() -> None:
    """The power is the same; what the body takes of the force is known where a factor is given."""
    back = ("buoy.body.float.vx -> hydro.float.vx", "buoy.body.float.x -> hydro.float.x")
    wiring = wired(BOTH, *back, "hydro.float.force_x * -0.5 -> buoy.body.float.force_x")
    (bond,) = wiring.bonds
    (axis,) = bond.axes
    assert str(axis.velocity.source) == "buoy.body.float.vx"
    assert axis.position is not None
    assert axis.share == -0.5
    assert bond.name == "hydro.float.force_x * -0.5 -> buoy.body.float.force_x"
    assert not wired(BOTH, *back, "hydro.float.force_x + 3 -> buoy.body.float.force_x").bonds
    assert not wired(BOTH, "hydro.float.force_x -> buoy.body.float.force_x").bonds


def test_an_effort_works_on_the_rate_of_its_joint() -> None:
    rail = [("joint.rail.effort", "input", "N"), ("joint.rail.u", "output", "m/s")]
    pto = [("rod.effort", "output", "N"), ("rod.u", "input", "m/s")]
    both = {"buoy": described("buoy", *rail), "pto": described("pto", *pto)}
    (bond,) = wired(both, "buoy.joint.rail <-> pto.rod").bonds
    (axis,) = bond.axes
    assert (str(axis.force.source), str(axis.velocity.source)) == (
        "pto.rod.effort",
        "buoy.joint.rail.u",
    )
    assert axis.position is None


def test_a_connector_carries_what_is_calculated_into_a_parameter() -> None:
    """Once, beside its inputs and outputs; a connection by '->' is asked before it."""
    buoy = described(
        "buoy",
        ("body.float.x", "output", "m"),
        ("body.float.mass", "parameter", "kg"),
        ("mass", "parameter", "kg"),
    )
    hydro = described(
        "hydro",
        ("float.x", "input", "m"),
        ("float.mass", "calculatedParameter", "t"),
        ("float.drag", "parameter", "kg"),
        ("mass", "calculatedParameter", "kg"),
        ("other", "calculatedParameter", "kg"),
    )
    both = {"buoy": buoy, "hydro": hydro}
    for connection in ("buoy.float <-> hydro.float", "hydro.float <-> buoy.float"):
        wiring = wired(both, connection)
        assert [str(link) for link in wiring.links] == ["buoy.body.float.x -> hydro.float.x"]
        (link,) = wiring.initial_links
        assert str(link) == "hydro.float.mass -> buoy.body.float.mass"
        assert link.factor == 1000.0
    wiring = wired(both, "buoy.float <-> hydro.float", "hydro.other + 5 -> buoy.body.float.mass")
    (link,) = wiring.initial_links
    assert (str(link.source), link.offset) == ("hydro.other", 5.0)
