"""Floating bodies in space that do not float as they were said to, whatever their heading.

A barge of 100 t displacement with stiffnesses of 1962 and 3924 kN.m/rad in roll and pitch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML

from m4e_adapters.hydrodynamics import Coefficients, hydrodynamics_program
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program

MODEL = """\
name: barge
dimensions: 3
gravity: [0, 0, -9.81]
bodies: {{hull: {{mass: 100e3, inertia: {inertia}, added_mass: true}}}}
joints: {{sea: {{type: floating, child: hull, initial: {{z: -1.0, psi: {psi}, {more}}}}}}}
loads:
  cargo: {{type: body_force, body: hull, axes: body, force: [0, 0, {lift}], moment: {moment}}}
"""
HINGED = """\
name: barge
dimensions: 3
gravity: [0, 0, -9.81]
bodies: {hull: {mass: 100e3, inertia: [1e6, 2e6, 3e6], added_mass: true}}
joints: {sea: {type: revolute, child: hull, parent_to_joint: [0, 0, -1], axis: [1, 1, 0]}}
loads: {cargo: {type: body_force, body: hull, force: [0, 0, 0], moment: [98.1e3, 0, 0]}}
"""
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
  foot: {{type: {foot}, parent: hull, child: mast, joint_to_child: [0, 0, {height}]}}
  axle: {{type: revolute, axis: [0, 1, 0], parent: mast, child: pulley}}
"""
FIXED, HINGE = "fixed", "revolute, axis: [1, 0, 0]"
RHO, G = 1000.0, 9.81


def coefficients(roll: float) -> Coefficients:
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


def told(
    folder: Path,
    model: str,
    *connections: str,
    heading: float = 0.0,
    roll: float = 200.0,
    start: Mapping[str, float] | None = None,
) -> tuple[str, ...]:
    """Warnings of the start of a model in water, whose coefficients are for a heading [deg]."""
    folder.mkdir(exist_ok=True)
    (folder / "barge.model.yaml").write_text(model, "utf-8")
    program = model_program(load_model(folder / "barge.model.yaml"))
    water = hydrodynamics_program(coefficients(roll), name="hydro", heading=Heading(heading))
    barge = build_fmu(program, folder / "barge.fmu", native=True)
    hydro = build_fmu(water, folder / "hydro.fmu", native=True)
    parts = (Component("barge", FmuFile(barge)), Component("hydro", FmuFile(hydro), start or {}))
    links = ("barge.hull <-> hydro.hull", "hydro.added_mass -> barge.added_mass", *connections)
    return run(System("float", parts, links, Simulation(0.1, 0.05))).warnings


def barge(
    *, heading: float = 0.0, moment: str = "[0, 0, 0]", more: str = "y: 0", lift: float = 0.0,
    inertia: str = "[1e6, 2e6, 3e6]",
) -> str:  # fmt: skip
    return MODEL.format(
        psi=math.radians(heading), moment=moment, more=more, lift=lift, inertia=inertia
    )


CASES: list[dict[str, Any]] = YAML(typ="safe").load(Path(__file__).with_name("floating.yaml"))[
    "space"
]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_first_warning_of_a_start(tmp_path: Path, case: dict[str, Any]) -> None:
    given, texts = case["given"], case.get("told", ())
    water = {"heading": given.get("heading", 0.0), **case.get("water", {})}
    lines = told(tmp_path, barge(**given), **water)
    assert bool(lines) == bool(texts)
    assert all(text in lines[0] for text in texts)


def test_a_hinge_that_is_neither_along_nor_across_forbids_both(tmp_path: Path) -> None:
    assert told(tmp_path, HINGED) == ()


def carrying(folder: Path, *links: str, mass: str = "90e3", foot: str, height: float) -> list[str]:
    """Of the start of a barge with a mast of 10 t, whose centre is `height` over its foot."""
    return [*told(folder, CARRYING.format(mass=mass, foot=foot, height=height), *links)]


@pytest.mark.parametrize("foot", [FIXED, HINGE])
def test_nothing_is_told_of_the_stability_with_bodies_that_are_carried(
    foot: str, tmp_path: Path
) -> None:
    """10 t at 25 m, which capsize the hull, or do not: that depends on the joint."""
    assert carrying(tmp_path, foot=foot, height=25.0) == []


def test_masses_are_advised_without_what_is_carried(tmp_path: Path) -> None:
    wanted = "barge.body.hull.neutral_mass"
    line, *_ = carrying(tmp_path, mass="neutral", foot=FIXED, height=15.0)
    offset = f"hydro.hull.neutral_mass - 10001 -> {wanted}"
    assert f"10001 kg less: change mass, or the connected forces; that is '{offset}'" in line
    assert carrying(tmp_path, offset, mass="neutral", foot=FIXED, height=15.0) == []
    heavy = f"hydro.hull.neutral_mass - 5001 -> {wanted}"
    line, *_ = carrying(tmp_path, heavy, mass="neutral", foot=FIXED, height=15.0)
    assert f"that is '{offset}'" in line
    # the neutral mass of 100 t already: 10 t and 1 kg are too much
    line, *_ = carrying(tmp_path, mass="100e3", foot=FIXED, height=15.0)
    assert "weight and connected forces are 1079" in line
    assert "to float there, 10001 kg less" in line
