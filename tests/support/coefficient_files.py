"""Files of coefficients by others, unpacked, and systems that use them."""

from __future__ import annotations

import lzma
from collections.abc import Callable, Collection
from pathlib import Path

import numpy as np

from m4e_fmi.simulate import Simulation

DATA = Path(__file__).parents[1] / "data" / "hydrodynamics"
SPHERE, FLAP = DATA / "oes10_sphere.h5", DATA / "oswec.nc"
RM3_SERIES = DATA / "rm3_decay_wec_sim.csv"

RM3_MODEL = """\
name: wec
dimensions: 3
gravity: 9.81
bodies:
  float: {mass: neutral, inertia: [20907301, 21306090.66, 37085481.11], added_mass: true}
  spar: {mass: neutral, inertia: [94419614.57, 94407091.24, 28542224.82], added_mass: true}
joints:
  sea: {type: floating, child: float, initial: {z: 0.28}}
  depth: {type: floating, child: spar, initial: {z: -21.29}}
points: {above: {body: float, at: [0, 0, 0]}, below: {body: spar, at: [0, 0, 0]}}
loads: {pto: {type: tension_damper, points: [above, below], damping: 1.2e6}}
"""
RM3_SYSTEM = """\
name: rm3
components:
  wec: {model: wec.model.yaml}
  hydro:
    kind: hydrodynamics
    dimensions: 3
    coefficients: rm3.1
    water: {density: 1000, depth: deep, gravity: 9.81}
    bodies:
      float: {center_of_gravity: [0, 0, -0.72], volume: 725.834}
      spar: {center_of_gravity: [0, 0, -21.29], volume: 886.691}
connections:
  - wec.body.float <-> hydro.float
  - wec.body.spar <-> hydro.spar
  - hydro.added_mass -> wec.added_mass
simulation: {stop_time: 100, step_size: 0.05}
"""


def rm3_files(folder: Path, modes: Collection[int] = ()) -> Path:
    """WAMIT's three files of RM3 in a folder; the .1 file, with rows of some `modes` only."""
    for suffix, columns in (("1", (1, 2)), ("3", (2,))):
        text = lzma.decompress((DATA / "wamit" / f"rm3.{suffix}.xz").read_bytes()).decode()
        if modes:
            title, *rows = text.splitlines()
            kept = [r for r in rows if all(int(r.split()[c]) in modes for c in columns)]
            text = "\n".join([title, *kept, ""])
        (folder / f"rm3.{suffix}").write_text(text, "utf-8")
    (folder / "rm3.hst").write_bytes((DATA / "wamit" / "rm3.hst").read_bytes())
    return folder / "rm3.1"


def rm3_system(folder: Path, modes: Collection[int] = ()) -> Path:
    """A system of RM3, the float released 1 m above its rest; its coefficients beside it."""
    rm3_files(folder, modes)
    (folder / "wec.model.yaml").write_text(RM3_MODEL, "utf-8")
    path = folder / "system.yaml"
    path.write_text(RM3_SYSTEM, "utf-8")
    return path


def changed(path: Path, change: Callable[[list[str]], list[str]]) -> None:
    """Change the lines of a text file."""
    path.write_text("\n".join([*change(path.read_text("utf-8").splitlines()), ""]), "utf-8")


def check_heave_only(found: Simulation) -> None:
    """The heave of RM3's bodies is that of WEC-Sim, to 5e-4 m; nothing moves otherwise."""
    times, *others = np.loadtxt(RM3_SERIES, delimiter=",").T
    for body, other in zip(("float", "spar"), others, strict=True):
        heave = np.interp(times, found.time, found[f"wec.body.{body}.z"])
        assert np.sqrt(np.mean((heave - other) ** 2)) < 5e-4
        for motion in ("x", "y", "phi", "theta", "psi"):
            assert np.abs(found[f"wec.body.{body}.{motion}"]).max() < 1e-6
