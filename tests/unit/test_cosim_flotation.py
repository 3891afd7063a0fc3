"""Floating bodies that do not float where they were said to: told with both numbers.

A buoy of 100 t displacement and 50 m2 of waterplane, in water without waves or radiation.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics import Coefficients, hydrodynamics_program
from m4e_fmi.cosim import Component, FmuFile, Outcome, Simulation, System, run
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program

RHO, G, AREA, DISPLACED = 1000.0, 9.81, 50.0, 100e3
MODEL = """\
name: buoy
gravity: 9.81
parameters: {m: {value: 100, unit: t}}
bodies: {float: {mass: m, inertia: 1e6, added_mass: true}}
joints: {sea: {type: floating, child: float, initial: {z: -1.0}}}
"""
CONNECTIONS = ("buoy.float <-> hydro.float", "hydro.added_mass -> buoy.added_mass")


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmus")
    model = folder / "buoy.model.yaml"
    model.write_text(MODEL)
    return {
        "buoy": build_fmu(model_program(load_model(model)), folder / "buoy.fmu", native=True),
        "hydro": water(folder / "hydro.fmu", AREA),
        "deep": water(folder / "deep.fmu", 0.0),
    }


def water(path: Path, area: float) -> Path:
    """The FMU of the water around the buoy, for a waterplane [m2]; 0 of a submerged one."""
    omega, added = np.linspace(0.2, 3.0, 15), np.diag([2e4, 6e4, 3e5])
    program = hydrodynamics_program(
        Coefficients(
            bodies=("float",),
            centers=np.array([[0.0, -1.0]]),
            omega=omega,
            added_mass=np.tile(added, (len(omega), 1, 1)),
            radiation_damping=np.zeros((len(omega), 3, 3)),
            added_mass_inf=added,
            excitation=np.zeros((len(omega), 3), dtype=complex),
            hydrostatic_stiffness=RHO * G * np.diag([0.0, area, 200.0]),
            buoyancy=np.array([0.0, DISPLACED * G, 0.0]),
            density=RHO,
        ),
        name="hydro",
    )
    return build_fmu(program, path, native=True)


def floated(
    fmus: dict[str, Path],
    folder: Path,
    *connections: str,
    water: str = "hydro",
    **start: float | str,
) -> Outcome:
    system = System(
        name="float",
        components=(
            Component("buoy", FmuFile(fmus["buoy"])),
            Component("hydro", FmuFile(fmus[water])),
        ),
        connections=(*CONNECTIONS, *connections),
        simulation=Simulation(8.0, 0.05),
    )
    names = {"m": "buoy.m", "z": "buoy.body.float.z", "theta": "buoy.body.float.theta"}
    changed = system.changed(start={names[key]: value for key, value in start.items()})
    return run(changed, results=folder / "r.nc")


def test_a_body_in_balance_is_not_told_of(fmus: dict[str, Path], tmp_path: Path) -> None:
    assert floated(fmus, tmp_path).warnings == ()
    assert floated(fmus, tmp_path, m="100.9 t").warnings == ()


def test_weight_and_buoyancy_that_differ_are_told(fmus: dict[str, Path], tmp_path: Path) -> None:
    """Added mass moves with the body, and is no weight; the start may be anywhere."""
    for z in (-1.0, -0.99):
        (told,) = floated(fmus, tmp_path, m="90 t", z=z).warnings
        assert told.startswith(
            "buoy.body.float: weight and connected forces are 882.9 kN at the start, the still "
            "water carries 981 kN"
        )
        assert "it rises by 0.2 m from there" in told  # 10 t over 1 t/m3 over 50 m2
        assert "hydro.float.neutral_mass (100000 kg)" in told


def test_the_neutral_mass_can_be_connected(fmus: dict[str, Path], tmp_path: Path) -> None:
    outcome = floated(fmus, tmp_path, "hydro.float.neutral_mass -> buoy.m")
    assert outcome.warnings == ()
    z = outcome.results()["buoy.body.float.z"].values
    assert z == pytest.approx(np.full(len(z), -1.0), abs=1e-9)


def test_another_start_than_the_reference_pose_is_told(
    fmus: dict[str, Path], tmp_path: Path
) -> None:
    warnings: list[str] = []
    system = floated(fmus, tmp_path, z=-0.5).prepared
    run(system, warn=warnings.append)
    assert warnings == [
        "warning: hydro.float.z starts at -0.5 m, coefficients are for -1 m: right for a release, "
        "else make start and center_of_gravity agree"
    ]
    (told,) = floated(fmus, tmp_path, theta="5 deg").warnings
    assert "hydro.float.theta starts at 0.08727 rad" in told


def test_a_submerged_body_that_starts_elsewhere_is_told_too(
    fmus: dict[str, Path], tmp_path: Path
) -> None:
    """It has no draft: a hundredth of its size, the side of a cube of 100 m3, is told."""
    assert floated(fmus, tmp_path, water="deep", z=-1.04).warnings == ()
    (told,) = floated(fmus, tmp_path, water="deep", z=-1.06).warnings
    assert told.startswith("hydro.float.z starts at -1.06 m, coefficients are for -1 m")


def test_motions_that_are_not_small_are_told_once(fmus: dict[str, Path], tmp_path: Path) -> None:
    """Half the mean draft of 2 m is left at once from 1.1 m below, 15 deg by a turn of 16; a body
    that is too heavy leaves it later: the first time is told."""
    start, sinks = floated(fmus, tmp_path, z=-2.1).warnings
    assert "starts at -2.1 m" in start
    assert sinks.startswith("hydro.float.heave is -1.1 m at t = 0 s, outside -1 to 1 m")
    assert "within 0.5 of the mean draft" in sinks
    start, turns = floated(fmus, tmp_path, theta="16 deg").warnings
    assert "hydro.float.pitch is 0.2793 rad at t = 0 s, outside -0.2618 to 0.2618 rad" in turns
    heavy = floated(fmus, tmp_path, m="156 t").warnings  # sinks by up to 2.24 m
    (left,) = (line for line in heavy if "heave" in line)
    outcome = floated(fmus, tmp_path, m="156 t").results()
    heave = outcome["hydro.float.heave"].values
    first = int(np.argmax(np.abs(heave) > 1.0))
    assert f"is {heave[first]:.4g} m at t = {outcome.time[first]:.9g} s" in left


def test_a_hinge_carries_the_weight(fmus: dict[str, Path], tmp_path: Path) -> None:
    """A body that stands on a hinge need not be in balance by itself."""
    text = MODEL.replace(
        "sea: {type: floating, child: float, initial: {z: -1.0}}",
        "hinge: {type: revolute, child: float, parent_to_joint: [0, -5], joint_to_child: [0, 4], "
        "initial: {q: 0.01}}",
    )
    (tmp_path / "flap.model.yaml").write_text(text)
    program = model_program(load_model(tmp_path / "flap.model.yaml"))
    flap = build_fmu(program, tmp_path / "flap.fmu", native=True)
    told = floated({**fmus, "buoy": flap}, tmp_path, m="300 t").warnings
    assert not any("still water carries" in text for text in told)
