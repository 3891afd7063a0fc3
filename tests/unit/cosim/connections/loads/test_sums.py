"""Several sources of one input: those that add up, and those that do not."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.described import described

from m4e_fmi.cosim import Component, FmuFile, Simulation, System
from m4e_fmi.cosim.connections.connect import connect, sum_components
from m4e_fmi.cosim.connections.links import Wiring
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description

BODY = described(
    "buoy",
    ("body.float.x", "output", "m"),
    ("body.float.vx", "output", "m/s"),
    ("body.float.force_x", "input", "N"),
    ("joint.arm.effort", "input", "N.m"),
    ("added_mass[1,1]", "parameter", "kg"),
    ("body.float.mass", "parameter", "kg"),
    ("level", "input", "m"),
    ("bare", "input", ""),
)


def water(force: str = "N") -> Description:
    return described(
        "water",
        ("float.x", "input", "m"),
        ("float.vx", "input", "m/s"),
        ("float.force_x", "output", force),
        ("torque", "output", "N.m"),
        ("added_mass[1,1]", "calculatedParameter", "kg"),
        ("height", "output", "m"),
    )


FMUS = {"buoy": BODY, "hull": water(), "legs": water("kN"), "skirt": water()}
BOTH = ("buoy.float <-> hull.float", "legs.float <-> buoy.float")


def system(*connections: str) -> System:
    components = tuple(Component(name, FmuFile(Path(f"{name}.fmu"))) for name in FMUS)
    return System("s", components, connections, Simulation(stop_time=1, step_size=0.1))


def wired(*connections: str) -> Wiring:
    return connect(system(*connections), FMUS)


def texts(wiring: Wiring) -> set[str]:
    return {str(link) for link in wiring.all_links}


def test_forces_go_through_a_sum() -> None:
    wiring = wired(*BOTH)
    name = "buoy_body_float_sum"
    assert texts(wiring) >= {
        f"hull.float.force_x -> {name}.hull.force_x",
        f"legs.float.force_x -> {name}.legs.force_x",
        f"{name}.sum.force_x -> buoy.body.float.force_x",
        "buoy.body.float.x -> hull.float.x",
        "buoy.body.float.x -> legs.float.x",
    }
    (link,) = (k for k in wiring.links if k.source.component == "legs")
    assert link.factor == 1000.0
    assert {str(k) for k in wiring.written} >= {
        "hull.float.force_x -> buoy.body.float.force_x",
        "legs.float.force_x -> buoy.body.float.force_x",
    }
    assert not any(name in str(k) for k in wiring.written)
    assert wiring.notes == (
        f"buoy.body.float.force_x takes the sum of hull.float, legs.float: {name}",
    )


def test_each_connection_has_its_power() -> None:
    bonds = wired(*BOTH).bonds
    assert [bond.name for bond in bonds] == list(BOTH)
    assert [bond.axes[0].force.source.component for bond in bonds] == ["hull", "legs"]
    assert {str(bond.axes[0].onto) for bond in bonds} == {"buoy.body.float.force_x"}
    assert all(bond.axes[0].share == 1.0 for bond in bonds)


def test_constant_added_masses_are_added_once() -> None:
    wiring = wired("hull.added_mass -> buoy.added_mass", "legs.added_mass -> buoy.added_mass")
    assert {str(k) for k in wiring.initial_links} == {
        "hull.added_mass[1,1] -> buoy_added_mass_sum.hull.added_mass[1,1]",
        "legs.added_mass[1,1] -> buoy_added_mass_sum.legs.added_mass[1,1]",
        "buoy_added_mass_sum.sum.added_mass[1,1] -> buoy.added_mass[1,1]",
    }
    assert not wiring.links


def test_sources_in_part_have_sums_of_their_own() -> None:
    """Two components give a force, three a moment at a joint; one of them by a factor."""
    wiring = wired(
        *BOTH,
        "hull.torque -> buoy.joint.arm.effort",
        "legs.torque * 2 -> buoy.joint.arm.effort",
        "skirt.torque -> buoy.joint.arm.effort, delayed",
    )
    assert wiring.sums == ("buoy_body_float_sum", "buoy_joint_arm_sum")
    into = {k.source.component: k for k in wiring.links if "arm_sum" in k.target.component}
    assert (into["legs"].factor, into["skirt"].delayed) == (2.0, True)


def test_the_components_are_named_once() -> None:
    whole = system(*BOTH)
    (component,) = sum_components(whole, FMUS)
    assert isinstance(component.source, Kind)
    config = component.source.config.model_dump()
    assert config["inputs"] == {"hull": 1.0, "legs": 1.0}
    assert config["signals"] == {"force_x": "N"}
    name = component.name
    of_sum = described(
        name,
        ("hull.force_x", "input", "N"),
        ("legs.force_x", "input", "N"),
        ("sum.force_x", "output", "N"),
    )
    assert sum_components(whole, {**FMUS, name: of_sum}) == ()
    other = {**FMUS, name: described(name, ("u", "input", "N"))}
    (renamed,) = sum_components(whole, other)
    assert renamed.name == f"{name}_2"


@pytest.mark.parametrize(
    "connections",
    [
        ("hull.height -> buoy.level", "legs.height -> buoy.level"),
        (
            "hull.added_mass[1,1] -> buoy.body.float.mass",
            "legs.added_mass[1,1] -> buoy.body.float.mass",
        ),
    ],
)
def test_other_signals_have_one_source(connections: tuple[str, str]) -> None:
    with pytest.raises(InputError, match=r"has two sources(.|\n)*added masses add up") as caught:
        wired(*connections)
    assert len(caught.value.problems) == 1
    assert sum_components(system(*connections), FMUS) == ()


def test_one_source_by_two_connections_counts_once() -> None:
    assert (
        wired("buoy.float <-> hull.float", "hull.float.force_x -> buoy.body.float.force_x").sums
        == ()
    )
