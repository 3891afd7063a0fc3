"""Floating bodies in space that do not float as they were said to, whatever their heading.

A barge of 100 t displacement with stiffnesses of 1962 and 3924 kN.m/rad in roll and pitch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics import Coefficients, hydrodynamics_program
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program

MODEL = """\
name: barge
dimensions: 3
gravity: [0, 0, -9.81]
bodies: {{hull: {{mass: 100e3, inertia: [1e6, 2e6, 3e6], added_mass: true}}}}
joints: {{sea: {{type: floating, child: hull, initial: {{z: -1.0, psi: {psi}, {more}}}}}}}
loads:
  cargo: {{type: body_force, body: hull, axes: body, force: [0, 0, {lift}], moment: {moment}}}
"""
RHO, G = 1000.0, 9.81


def coefficients(roll: float = 200.0) -> Coefficients:
    omega = np.linspace(0.2, 3.0, 15)
    added = np.diag([2e4, 4e4, 6e4, 2e5, 3e5, 1e5])
    return Coefficients(
        bodies=("hull",),
        centers=np.array([[0.0, 0.0, -1.0]]),
        omega=omega,
        added_mass=np.tile(added, (len(omega), 1, 1)),
        radiation_damping=np.zeros((len(omega), 6, 6)),
        added_mass_inf=added,
        excitation=np.zeros((len(omega), 6), dtype=complex),
        hydrostatic_stiffness=RHO * G * np.diag([0.0, 0.0, 50.0, roll, 400.0, 0.0]),
        buoyancy=100e3 * G * np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        density=RHO,
    )


def warnings(
    folder: Path, *, moment: str = "[0, 0, 0]", heading: float = 37.0, roll: float = 200.0,
    more: str = "y: 0", lift: float = 0.0,
) -> tuple[str, ...]:  # fmt: skip
    """Of the start of a barge that lies in the heading of the water's coefficients."""
    text = MODEL.format(psi=math.radians(heading), moment=moment, more=more, lift=lift)
    water = hydrodynamics_program(coefficients(roll), name="hydro", heading=Heading(heading))
    return told(folder, text, water)


def told(
    folder: Path,
    model: str,
    water: Program,
    *,
    start: Mapping[str, float] | None = None,
    rename: Mapping[str, str] | None = None,
    connections: tuple[str, ...] = (),
) -> tuple[str, ...]:
    """Warnings of a model in water with start values of the water, and other names in its FMU."""
    folder.mkdir(exist_ok=True)
    path = folder / "barge.model.yaml"
    path.write_text(model, "utf-8")
    program, there = model_program(load_model(path)), folder / "hydro.fmu"
    barge = build_fmu(program, folder / "barge.fmu", native=True)
    hydro = build_fmu(water, there, native=True, rename=rename or {})
    system = System(
        name="float",
        components=(
            Component("barge", FmuFile(barge)),
            Component("hydro", FmuFile(hydro), start=start or {}),
        ),
        connections=(
            "barge.hull <-> hydro.hull",
            "hydro.added_mass -> barge.added_mass",
            *connections,
        ),
        simulation=Simulation(0.1, 0.05),
    )
    return run(prepare(system), results=folder / "r.nc").warnings


@pytest.mark.parametrize("heading", [0.0, 37.0, 120.0, 217.0, -200.0])
def test_a_body_in_balance_is_not_told_of(tmp_path: Path, heading: float) -> None:
    assert warnings(tmp_path, heading=heading) == ()


@pytest.mark.parametrize("heading", [0.0, 37.0, -140.0])
def test_a_moment_across_is_told_as_heel_and_one_along_as_trim(
    tmp_path: Path, heading: float
) -> None:
    """98.1 kN.m in the body's axes: 0.05 rad of heel, 0.025 rad of trim."""
    (heel,) = warnings(tmp_path / "heel", heading=heading, moment="[98.1e3, 0, 0]")
    assert "a moment of 98.1 kN.m about its centre of gravity" in heel
    assert "the heel is 2.86 deg" in heel
    (trim,) = warnings(tmp_path / "trim", heading=heading, moment="[0, 98.1e3, 0]")
    assert "a moment of 98.1 kN.m about its centre of gravity" in trim
    assert "the trim is 1.43 deg" in trim


def test_a_body_that_capsizes_over_its_side_is_told(tmp_path: Path) -> None:
    (line,) = warnings(tmp_path, roll=-30.0)
    assert line.startswith("barge.body.hull: it is unstable in roll, with a stiffness of -2.943e+")


def test_the_weight_is_told_once(tmp_path: Path) -> None:
    (line,) = warnings(tmp_path, lift=9.81e4)
    assert "weight and connected forces are 882.9 kN" in line


def test_a_start_aside_or_turned_is_told(tmp_path: Path) -> None:
    (line,) = warnings(tmp_path / "side", more="y: 3")
    assert line.startswith("hydro.hull.y starts at 3 m, coefficients are for 0 m")
    (line,) = warnings(tmp_path / "list", more="phi: 0.1")
    assert line.startswith("hydro.hull.phi starts at 0.1 rad")


LEVEL = MODEL.format(psi=0.0, moment="[392.4e3, 0, 0]", more="y: 0", lift=0.0)
HINGED = """\
name: barge
dimensions: 3
gravity: [0, 0, -9.81]
bodies: {hull: {mass: 100e3, inertia: [1e6, 2e6, 3e6], added_mass: true}}
joints: {sea: {type: revolute, child: hull, parent_to_joint: [0, 0, -1], axis: [1, 1, 0]}}
loads: {cargo: {type: body_force, body: hull, force: [0, 0, 0], moment: [98.1e3, 0, 0]}}
"""


def test_a_product_of_inertia_makes_no_trim_of_a_heel(tmp_path: Path) -> None:
    """A roll moment accelerates the hull in pitch, too, and balances in roll alone."""
    text = LEVEL.replace("[1e6, 2e6, 3e6]", "[1.2e6, 2e6, 3e6, 6e5, 0, 0]")
    (heel,) = told(tmp_path, text, hydrodynamics_program(coefficients(), name="hydro"))
    assert "a moment of 392.4 kN.m about its centre of gravity" in heel
    assert "the heel is 11.5 deg" in heel


def test_a_hinge_that_is_neither_along_nor_across_forbids_both(tmp_path: Path) -> None:
    assert told(tmp_path, HINGED, hydrodynamics_program(coefficients(), name="hydro")) == ()


def test_the_heading_may_be_a_start_value(tmp_path: Path) -> None:
    """The pose that the coefficients are for is turned with it."""
    water = hydrodynamics_program(coefficients(), name="hydro")
    text = MODEL.format(psi=0.5, moment="[0, 0, 0]", more="y: 0", lift=0.0)
    assert told(tmp_path / "with", text, water, start={"heading": 0.5}) == ()
    yaw, *_ = told(tmp_path / "without", text, water)
    assert yaw.startswith("hydro.hull.psi starts at 0.5 rad, coefficients are for 0 rad")


def test_water_of_others_may_have_no_heading(tmp_path: Path) -> None:
    water = hydrodynamics_program(coefficients(), name="hydro")
    (heel,) = told(tmp_path, LEVEL, water, rename={"heading": "course"})
    assert "the heel is 11.5 deg" in heel


CARRYING = """\
name: barge
dimensions: 3
gravity: [0, 0, -9.81]
bodies:
  hull: {{mass: {mass}, inertia: [1e6, 2e6, 3e6], added_mass: true}}
  mast: {{mass: 10e3, inertia: [1e5, 1e5, 1e4]}}
  pulley: {{mass: 1.0, inertia: [1e-3, 1e-3, 1e-3]}}
joints:
  sea: {{type: floating, child: hull, initial: {{z: -1.0}}}}
  foot: {{type: {foot}, parent: hull, child: mast, parent_to_joint: [0, 0, {foot_z}],
    joint_to_child: [0, 0, {height}]}}
  axle: {{type: revolute, axis: [0, 1, 0], parent: mast, child: pulley}}
"""
FIXED, HINGE = "fixed", "revolute, axis: [1, 0, 0]"
FALLS = HINGE + ", initial: {q: 0.1}"


def carrying(folder: Path, *, mass: str = "90e3", foot: str = FIXED, height: float = 25.0,
    foot_z: float = 0.0, connections: tuple[str, ...] = (),
) -> tuple[str, ...]:  # fmt: skip
    """Of the start of a barge with a mast of 10 t, whose centre is `height` over its foot."""
    text = CARRYING.format(mass=mass, foot=foot, height=height, foot_z=foot_z)
    water = hydrodynamics_program(coefficients(), name="hydro")
    return told(folder, text, water, connections=connections)


@pytest.mark.parametrize("foot", [FIXED, HINGE])
def test_a_body_that_is_carried_counts_at_its_height(foot: str, tmp_path: Path) -> None:
    """10 t at 25 m: 1962 - 2453 kN.m/rad, and 1 kg of a pulley. At 15 m nothing capsizes."""
    line, *_ = carrying(tmp_path / "high", foot=foot)
    assert line.startswith(
        "barge.body.hull: with mast, pulley it is unstable in roll, with a stiffness of -4.907e+05"
    )
    assert "(GM = -0.5 m): without other forces it capsizes: lower the centres of gravity" in line
    assert carrying(tmp_path / "low", foot=foot, height=15.0) == ()


@pytest.mark.parametrize("foot", [FIXED, FALLS])
def test_a_neutral_mass_leaves_out_what_is_carried(foot: str, tmp_path: Path) -> None:
    """A hinged mast that stands beside its foot falls at the start, and has its weight still."""
    wanted = "barge.body.hull.neutral_mass"
    told_of, *_ = carrying(tmp_path, mass="neutral", foot=foot, height=15.0)
    offset = f"hydro.hull.neutral_mass - 10001 -> {wanted}"
    assert "leaves out what it carries and the other forces" in told_of
    assert f"'{offset}' includes them" in told_of
    right = carrying(tmp_path, mass="neutral", foot=foot, height=15.0, connections=(offset,))
    assert not any("still water carries" in line for line in right)
    heavy = f"hydro.hull.neutral_mass - 5001 -> {wanted}"
    told_of, *_ = carrying(tmp_path, mass="neutral", height=15.0, connections=(heavy,))
    assert f"'{offset}' includes them" in told_of


def test_a_mass_is_advised_without_that_of_what_is_carried(tmp_path: Path) -> None:
    """The hull has the neutral mass of 100 t already: 10 t and 1 kg are too much."""
    for foot in (FIXED, FALLS):
        told_of, *_ = carrying(tmp_path, mass="100e3", foot=foot, height=15.0)
        assert told_of.endswith(
            "if it is to float there, give it 10001 kg less (with mast, pulley now 110001 kg)"
        )
