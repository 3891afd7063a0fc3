"""The sphere of IEA OES Task 10 with WAMIT's radiation, and the pressure on its wetted part."""

from __future__ import annotations

from pathlib import Path

from support.published_coefficients import sphere

from m4e_adapters.hydrodynamics.config import Loads
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_fmi.fmu import build_fmu

MODEL = """
name: ball
gravity: 9.81
bodies: {ball: {mass: 261.8e3, inertia: 1.69e6, added_mass: true}}
joints: {sea: {type: floating, child: ball, initial: {z: %g}}}
"""
SYSTEM = """
name: nonlinear_sphere
components:
  body: {model: ball.model.yaml}
  water: {fmu: water.fmu}
  hull:
    kind: hull_pressure
    water: {density: 1000, gravity: 9.81}
    bodies: {ball: {shape: {sphere: {radius: 5}}, center_of_gravity: [0, -2], panels: 1000}}
  forces: {kind: sum, inputs: [water, hull], signals: {force_x: N, force_z: N, moment_y: N.m}}
connections:
%s
  - water.ball <-> forces.water
  - hull.ball <-> forces.hull
  - forces.sum <-> body.ball
  - water.added_mass -> body.added_mass
simulation: {stop_time: %g, step_size: 0.1}
"""
EQUILIBRIUM = -2.0  # m, height of the centre of gravity


def write_system(
    folder: Path, *, release: float, stop_time: float, hydrostatics: str = "none"
) -> Path:
    """The system file of a decay from `release` [m] above the equilibrium, with what it needs."""
    loads = Loads.model_validate({"hydrostatics": hydrostatics})
    water = hydrodynamics_program(sphere(), name="water", loads=loads)
    build_fmu(water, folder / "water.fmu", native=True)
    (folder / "ball.model.yaml").write_text(MODEL % (EQUILIBRIUM + release))
    motion = "\n".join(
        f"  - body.body.ball.{name} -> {component}.ball.{name}"
        for component in ("water", "hull")
        for name in ("x", "z", "theta", "vx", "vz", "omega")
    )
    path = folder / "sphere.system.yaml"
    path.write_text(SYSTEM % (motion, stop_time))
    return path
