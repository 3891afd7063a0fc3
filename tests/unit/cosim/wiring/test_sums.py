"""Several sources of one input: those that add up, and those that do not."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.described import described

from m4e_fmi.cosim import Component, FmuFile, Simulation, System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import Port, Wiring
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
)


def water(force: str = "N") -> Description:
    return described(
        "water",
        ("float.x", "input", "m"),
        ("float.vx", "input", "m/s"),
        ("float.force_x", "output", force),
        ("torque", "output", "N.m"),
        ("added_mass[1,1]", "calculatedParameter", "kg"),
    )


FMUS = {"buoy": BODY, "hull": water(), "legs": water("kN"), "skirt": water()}
BOTH = ("buoy.float <-> hull.float", "legs.float <-> buoy.float")


def system(*connections: str) -> System:
    components = tuple(Component(name, FmuFile(Path(f"{name}.fmu"))) for name in FMUS)
    return System("s", components, connections, Simulation(stop_time=1, step_size=0.1))


def wired(*connections: str) -> Wiring:
    return connect(system(*connections), FMUS)


def test_each_force_goes_to_the_body() -> None:
    """And each connection has its power."""
    wiring = wired(*BOTH)
    assert {str(link) for link in wiring.all_links} >= {
        "hull.float.force_x -> buoy.body.float.force_x",
        "legs.float.force_x -> buoy.body.float.force_x",
        "buoy.body.float.x -> hull.float.x",
        "buoy.body.float.x -> legs.float.x",
    }
    (link,) = (k for k in wiring.links if k.source.component == "legs")
    assert link.factor == 1000.0
    bonds = wiring.bonds
    assert [bond.name for bond in bonds] == list(BOTH)
    assert [bond.axes[0].force.source.component for bond in bonds] == ["hull", "legs"]
    assert all(bond.axes[0].share == 1.0 for bond in bonds)
    assert wiring.notes == ("buoy.body.float.force_x takes the sum of hull.float, legs.float",)


def test_constant_added_masses_are_added_once() -> None:
    wiring = wired("hull.added_mass -> buoy.added_mass", "legs.added_mass -> buoy.added_mass")
    assert {str(k) for k in wiring.initial_links} == {
        "hull.added_mass[1,1] -> buoy.added_mass[1,1]",
        "legs.added_mass[1,1] -> buoy.added_mass[1,1]",
    }
    assert not wiring.links


def test_links_of_one_input_keep_their_factors_and_delays() -> None:
    """Two components give a force, three a moment at a joint; one of them by a factor."""
    wiring = wired(
        *BOTH,
        "hull.torque -> buoy.joint.arm.effort",
        "legs.torque * 2 -> buoy.joint.arm.effort",
        "skirt.torque -> buoy.joint.arm.effort, delayed",
    )
    into = {k.source.component: k for k in wiring.into[Port("buoy", "joint.arm.effort")]}
    assert (into["legs"].factor, into["skirt"].delayed) == (2.0, True)
    assert len(wiring.notes) == 2


def test_what_does_not_add_up_has_one_source() -> None:
    """By two connections it is one still."""
    masses = [f"{part}.added_mass[1,1] -> buoy.body.float.mass" for part in ("hull", "legs")]
    with pytest.raises(InputError, match=r"has two sources(.|\n)*added masses add up"):
        wired(*masses)
    assert not wired(BOTH[0], "hull.float.force_x -> buoy.body.float.force_x").notes
