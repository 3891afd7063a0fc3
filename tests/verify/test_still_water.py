"""Still water makes no energy: hulls of all shapes on springs, as matrices and in time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import capytaine
import numpy as np
import pytest
from support.published_coefficients import linear_system, transfer

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, coefficients_from_config, fit_radiation
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_fmi.cosim import CouplingErrorReport, load, load_system, run

PANELS = 250
HULLS: dict[str, dict[str, Any]] = {
    "cylinder": {"a": ({"cylinder": {"radius": 4, "draft": 3}}, [0, -1.2])},
    "slender cylinder": {"a": ({"cylinder": {"radius": 2, "draft": 12}}, [0, -7])},
    "sphere": {"a": ({"sphere": {"radius": 5}}, [0, -2])},
    "box": {"a": ({"box": {"length": 20, "width": 8, "draft": 2}}, [0, -0.5])},
    "flap": {"a": ({"box": {"length": 1.8, "width": 18, "draft": 9}}, [0, -4])},
    "two boxes": {
        "a": ({"box": {"length": 6, "width": 10, "draft": 2, "center_x": -5}}, [-5, -0.5]),
        "b": ({"box": {"length": 6, "width": 10, "draft": 3, "center_x": 5}}, [5, -1]),
    },
    "float and spar": {
        "a": ({"cylinder": {"radius": 5, "draft": 2, "center_x": -8}}, [-8, -0.5]),
        "b": ({"cylinder": {"radius": 2, "draft": 10, "center_x": 8}}, [8, -6]),
    },
    "submerged sphere": {"a": ({"mesh": "ball.stl"}, [0, -8])},
}
FREQUENCIES = (0.3, 0.7, 1.2, 2.0, 3.9)
"""rad/s, of the springs with mass and added mass."""


def coefficients(name: str, folder: Path) -> Coefficients:
    """Potential flow about a hull, by Capytaine."""
    if name.startswith("submerged"):
        mesh = capytaine.mesh_sphere(radius=4.0, center=(0.0, 0.0, -8.0), resolution=(12, 20))
        write_stl(folder / "ball.stl", mesh.vertices[mesh.faces])
    bodies = {
        body: {"shape": shape, "center_of_gravity": center}
        | ({} if "mesh" in shape else {"panels": PANELS})
        for body, (shape, center) in HULLS[name].items()
    }
    config = HydrodynamicsConfig.model_validate({"bodies": bodies})
    return coefficients_from_config(config, folder=folder, progress=lambda _: None)


def write_stl(path: Path, panels: np.ndarray) -> None:
    """Panels (n, 4, 3) as triangles."""
    lines = ["solid hull"]
    for panel in panels:
        for corners in (panel[[0, 1, 2]], panel[[0, 2, 3]]):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
            lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid hull", ""]))


@pytest.mark.parametrize("name", HULLS)
def test_no_motion_of_a_hull_on_springs_grows(name: str, tmp_path: Path) -> None:
    data = coefficients(name, tmp_path)
    told: list[str] = []
    memory = fit_radiation(data, progress=told.append)
    print(name, *told, sep="\n  ")
    k = transfer(memory, np.linspace(0.0, 400.0, 20001))
    assert np.linalg.eigvalsh(np.real(k)).min() >= -1e-12 * np.abs(k).max()
    own = data.buoyancy[1::3] / data.gravity
    mass = np.diag(np.concatenate([[m, m, 12 * m] for m in own]))
    largest = []
    for frequency in FREQUENCIES:
        springs = frequency**2 * np.diag((mass + memory.added_mass_inf).diagonal())
        values, vectors = np.linalg.eigh(data.hydrostatic_stiffness)
        floats = (vectors * np.maximum(values, 0.0)) @ vectors.T  # what would capsize is held
        matrix = linear_system(
            memory, mass=mass, stiffness=springs + floats, damping=np.zeros_like(mass)
        )
        roots = np.linalg.eigvals(matrix)
        largest.append(roots.real.max() / np.abs(roots).max())
    print("  largest real part over the largest root:", " ".join(f"{x:.1e}" for x in largest))
    assert max(largest) <= 1e-9


MODEL = """\
name: hull
gravity: 9.81
bodies:
  a: {{mass: {mass!r}, inertia: 1.0e+6, added_mass: true}}
joints:
  heave: {{type: prismatic, child: a, direction: [0, 1], initial: {{q: {start!r}}}}}
loads:
  spring: {{type: joint_effort, joint: heave, effort: "-{spring!r}*(joint.heave.q - ({z!r}))"}}
"""
SYSTEM = """\
name: still
components:
  hull: {{model: hull.model.yaml}}
  water:
    kind: hydrodynamics
    bodies:
      a: {{shape: {shape}, center_of_gravity: {center}, panels: 250}}
connections:
  - hull.a <-> water.a
  - water.added_mass -> hull.added_mass
simulation: {{stop_time: 10800, step_size: 0.05, output_interval: 1.0}}
"""


@pytest.mark.parametrize(
    ("name", "frequency"),
    [("cylinder", 3.98), ("sphere", 1.2), ("box", 2.0), ("slender cylinder", 0.7), ("flap", 3.0)],
)
def test_three_hours_of_still_water(name: str, frequency: float, tmp_path: Path) -> None:
    data = coefficients(name, tmp_path)
    ((shape, center),) = HULLS[name].values()
    mass = float(data.buoyancy[1] / data.gravity)
    spring = frequency**2 * (mass + float(data.added_mass_inf[1, 1]))
    spring -= min(float(data.hydrostatic_stiffness[1, 1]), 0.9 * spring)
    start = center[1] + 0.1
    text = MODEL.format(mass=mass, spring=spring, z=float(center[1]), start=start)
    (tmp_path / "hull.model.yaml").write_text(text)
    (tmp_path / "system.yaml").write_text(SYSTEM.format(shape=shape, center=center))
    outcome = run(load_system(tmp_path / "system.yaml"), results=tmp_path / "r.nc")
    results = load(tmp_path / "r.nc")
    away = np.abs(results["hull.joint.heave.q"].values - center[1])
    assert isinstance(outcome.certificate, CouplingErrorReport)
    stated = outcome.certificate.errors[0].error * 2 * away.max()
    hours = [
        away[(results.time >= t) & (results.time <= t + 600)].max() for t in range(0, 10800, 600)
    ]
    print(f"{name}: {hours[0]:.4g} m first, {hours[-1]:.4g} m last, stated error {stated:.1e} m")
    assert (np.diff(hours) <= stated).all()
    assert hours[-1] <= 0.1 + stated
