"""Model and water of two hulls and a tower, for connections of their added mass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.calm_water import RHO, G, calm

from m4e_adapters.hydrodynamics import Coefficients, hydrodynamics_program
from m4e_fmi.cosim import System, load_system
from m4e_fmi.fmu import build_fmu, read_description
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program

FREE = "{type: floating, child: small}"
MODEL = """\
name: m
dimensions: {dimensions}
bodies:
  small: {{mass: 1e5, inertia: {inertia}, added_mass: {small}}}
  big: {{mass: 1e5, inertia: {inertia}, added_mass: {big}}}
  tower: {{mass: 1e5, inertia: {inertia}, added_mass: {tower}}}
joints:
  a: {joint}
  b: {{type: floating, child: big}}
  c: {{type: fixed, parent: big, child: tower}}
"""
BOTH = ("m.big <-> hydro.big", "hydro.small <-> m.small")
MATRIX = "hydro.added_mass -> m.added_mass"


def model(
    folder: Path,
    dimensions: int = 2,
    *,
    flags: str = "small big",
    joint: str = FREE,
    fmi: str = "2",
) -> Description:
    """Of a model whose free bodies count in the order small, big; `flags` have added mass."""
    path = folder / "m.model.yaml"
    flagged = {name: str(name in flags.split()).lower() for name in ("small", "big", "tower")}
    inertia = {2: "1e6", 3: "[1e6, 1e6, 1e6]"}[dimensions]
    path.write_text(MODEL.format(dimensions=dimensions, inertia=inertia, joint=joint, **flagged))
    return read_description(
        build_fmu(model_program(load_model(path)), folder / "m.fmu", native=fmi == "3", fmi=fmi)
    )


def in_space(bodies: tuple[str, ...]) -> Coefficients:
    n, omega = len(bodies), np.linspace(0.2, 3.0, 15)
    added = np.diag([2e4, 4e4, 6e4, 2e5, 3e5, 1e5] * n)
    return Coefficients(
        bodies=bodies,
        centers=np.zeros((n, 3)),
        omega=omega,
        added_mass=np.tile(added, (len(omega), 1, 1)),
        radiation_damping=np.zeros((len(omega), 6 * n, 6 * n)),
        added_mass_inf=added,
        excitation=np.zeros((len(omega), 6 * n), dtype=complex),
        hydrostatic_stiffness=RHO * G * np.diag([0.0, 0.0, 50.0, 200.0, 200.0, 0.0] * n),
        buoyancy=1e5 * G * np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0] * n),
        density=RHO,
    )


def water(folder: Path, *bodies: str, dimensions: int = 2, fmi: str = "2") -> Description:
    coefficients = calm(bodies) if dimensions == 2 else in_space(bodies)
    program = hydrodynamics_program(coefficients, name="hydro")
    return read_description(build_fmu(program, folder / "hydro.fmu", native=fmi == "3", fmi=fmi))


def raft_system(m: Description, hydro: Description, *connections: str) -> System:
    """The system of these FMUs, in the file system.yaml; `hydro` twice if `other` is connected."""
    parts = {"m": m, "hydro": hydro}
    if any("other." in text for text in connections):
        parts["other"] = hydro
    components = [f"  {name}: {{fmu: {parts[name].path}}}" for name in parts]
    lines = ["name: s", "components:", *components, "connections:"]
    lines += [f'  - "{text}"' for text in connections]
    path = m.path.parent / "system.yaml"
    path.write_text("\n".join([*lines, "simulation: {stop_time: 1, step_size: 0.1}"]))
    return load_system(path)
