"""Datasets of Capytaine as netCDF files, of versions 2 and 3.

Dimensions are found by name, in any order: one of omega, freq, period, wavenumber and wavelength,
influenced_dof, radiating_dof, wave_direction [rad], complex (re, im). Waves are e^{−iωt}. Motions
are named Surge … Yaw, of several bodies with the body's name and two underscores before it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.file_data import (
    SIX,
    FileBody,
    FileData,
    Point,
    refused,
)
from m4e_adapters.hydrodynamics.coefficient_files.netcdf import Tree, opened_netcdf
from m4e_adapters.hydrodynamics.geometry.motions import SPACE
from m4e_fmi.errors import InputError

FREQUENCIES = ("omega", "freq", "period", "wavenumber", "wavelength")
INFLUENCED, RADIATING = "influenced_dof", "radiating_dof"
MOTION_NAMES = [motion.name for motion in SPACE]
NEEDED = ("added_mass", "radiation_damping", "omega", "wave_direction", "rho", "g", "water_depth")
NEMOH = "a file of Nemoh is to be converted: BEMIO and Capytaine read and write its tables"


def read_capytaine(path: Path) -> FileData:
    """The data of a file; InputError with all its problems."""
    with opened_netcdf(path) as tree:
        missing = [name for name in NEEDED if not tree.has(name)]
        if not tree.has("excitation_force"):
            parts = ("diffraction_force", "Froude_Krylov_force")
            missing += [name for name in parts if not tree.has(name)]
        if not tree.has("hydrostatic_stiffness"):
            missing.append("hydrostatic_stiffness")
        if missing:
            text = f"{path}: there is no {', '.join(missing)}"
            remedy = (
                "a dataset of Capytaine has them after BEMSolver.fill_dataset with wave directions "
                f"and hydrostatics; {NEMOH}"
            )
            raise refused(text, remedy)
        return _data(tree)


def _data(tree: Tree) -> FileData:
    if tree.has("forward_speed") and np.any(tree.array("forward_speed") != 0):
        raise refused(f"{tree.path}: the bodies have a forward speed", "compute them at rest")
    names, places = _places(tree)
    n, density, gravity = SIX * len(names), tree.number("rho"), tree.number("g")
    (axis,) = [d for d in tree.dimensions("added_mass") if d in FREQUENCIES][:1] or [""]
    if not axis:
        text = f"{tree.path}: added_mass has no dimension {', '.join(FREQUENCIES)}"
        raise refused(text, NEMOH)
    matrix = (axis, INFLUENCED, RADIATING)
    rows, columns = places[INFLUENCED], places[RADIATING]

    def spread(name: str) -> np.ndarray:
        values = _ordered(tree, name, matrix)
        found = np.zeros((len(values), n, n))
        found[:, rows[:, None], columns] = values
        return found

    stiffness = np.zeros((n, n))
    stiffness[rows[:, None], columns] = _ordered(tree, "hydrostatic_stiffness", matrix[1:])
    omega = tree.array("omega").ravel()
    force = _excitation(tree, axis)
    excitation = np.zeros((*force.shape[:2], n), dtype=complex)
    excitation[:, :, rows] = force
    return FileData(
        path=tree.path,
        format="Capytaine",
        bodies=_bodies(tree, names, places[RADIATING], stiffness / (density * gravity), density),
        omega=omega,
        added_mass=spread("added_mass") / density,
        damping=spread("radiation_damping") / density,
        added_mass_inf=None,
        directions=np.degrees(tree.array("wave_direction").ravel()),
        excitation=excitation / (density * gravity),
        density=density,
        gravity=gravity,
        depth=tree.number("water_depth"),
    )


def _places(tree: Tree) -> tuple[list[str], dict[str, np.ndarray]]:
    """Names of the bodies, and where each degree of freedom is among their motions."""
    words = {name: tree.texts(name) for name in (RADIATING, INFLUENCED)}
    bodies: dict[str, None] = {}
    split: dict[str, list[tuple[str, str]]] = {}
    for name, dofs in words.items():
        split[name] = [_split(dof) for dof in dofs]
        bodies.update(dict.fromkeys(body for body, _ in split[name]))
    unknown = [d for d in words[INFLUENCED] if _split(d)[1] not in MOTION_NAMES]
    if unknown:
        text = f"{tree.path}: {', '.join(unknown[:5])} are not motions of rigid bodies"
        raise refused(text, f"only {', '.join(MOTION_NAMES)} are read")
    names = list(bodies)
    found = {
        name: np.array([SIX * names.index(b) + MOTION_NAMES.index(m) for b, m in pairs])
        for name, pairs in split.items()
    }
    if names == [""]:
        own = tree.texts("body_name") if tree.has("body_name") else []
        names = [own[0] if len(own) == 1 and own[0] else "body1"]
    return names, found


def _split(dof: str) -> tuple[str, str]:
    """Body and motion of a degree of freedom."""
    body, _, motion = dof.rpartition("__")
    return body, motion.lower()


def _ordered(tree: Tree, name: str, wanted: Sequence[str]) -> np.ndarray:
    """A variable with its dimensions in the order `wanted`; others must have one entry."""
    values, own = tree.array(name), list(tree.dimensions(name))
    lacking = [d for d in wanted if d not in own]
    if lacking:
        raise refused(f"{tree.path}: {name} has no dimension {', '.join(lacking)}")
    for place in reversed(range(len(own))):
        if own[place] in wanted:
            continue
        if values.shape[place] != 1:
            text = f"{tree.path}: {name} has {values.shape[place]} values of {own[place]}"
            raise refused(text, f"keep one of them: dataset.sel({own[place]}=…)")
        values = values.squeeze(place)
        del own[place]
    return values.transpose([own.index(d) for d in wanted])


def _excitation(tree: Tree, axis: str) -> np.ndarray:
    """Forces (nω, nβ, dof) [N/m, N.m/m], complex."""
    wanted = ("complex", axis, "wave_direction", INFLUENCED)
    if tree.has("excitation_force"):
        total = _ordered(tree, "excitation_force", wanted)
    else:
        total = _ordered(tree, "diffraction_force", wanted)
        total = total + _ordered(tree, "Froude_Krylov_force", wanted)
    parts = [word.lower() for word in tree.texts("complex")] if tree.has("complex") else []
    real, imaginary = (parts.index(p) if p in parts else k for k, p in enumerate(("re", "im")))
    return total[real] + 1j * total[imaginary]


def _bodies(
    tree: Tree, names: Sequence[str], places: np.ndarray, stiffness: np.ndarray, density: float
) -> tuple[FileBody, ...]:
    points = {
        name: _points(tree, name, len(names))
        for name in ("rotation_center", "center_of_mass", "center_of_buoyancy")
    }
    volumes = _volumes(tree, names, places, density)
    there = set(places.tolist())
    return tuple(
        FileBody(
            name=name,
            stiffness=stiffness[SIX * k : SIX * k + SIX, SIX * k : SIX * k + SIX],
            missing=tuple(m for i, m in enumerate(MOTION_NAMES) if SIX * k + i not in there),
            reference=points["rotation_center"].get(k),
            center_of_gravity=points["center_of_mass"].get(k),
            center_of_buoyancy=points["center_of_buoyancy"].get(k),
            volume=volumes.get(k),
        )
        for k, name in enumerate(names)
    )


def _points(tree: Tree, name: str, count: int) -> Mapping[int, Point]:
    """Points (x, y, z) [m] by body, of those that have one."""
    if not tree.has(name):
        return {}
    values = tree.array(name)
    if values.size != 3 * count:
        return {}
    rows = values.reshape(count, 3).tolist()
    return {k: (x, y, z) for k, (x, y, z) in enumerate(rows) if np.isfinite([x, y, z]).all()}


def _volumes(
    tree: Tree, names: Sequence[str], places: np.ndarray, density: float
) -> Mapping[int, float]:
    """Displaced volumes [m3] by body: of disp_mass, else of the mass in inertia_matrix."""
    if tree.has("disp_mass"):
        values = tree.array("disp_mass").ravel()
        if len(values) == len(names):
            return {k: v / density for k, v in enumerate(values.tolist())}
    if not tree.has("inertia_matrix"):
        return {}
    try:
        matrix = _ordered(tree, "inertia_matrix", (INFLUENCED, RADIATING))
    except InputError:
        return {}
    masses = dict(zip(places.tolist(), matrix.diagonal().tolist(), strict=True))
    heaves = {k: masses.get(SIX * k + 2) for k in range(len(names))}
    return {k: mass / density for k, mass in heaves.items() if mass}
