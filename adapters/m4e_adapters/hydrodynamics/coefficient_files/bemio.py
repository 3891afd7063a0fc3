"""Files of BEMIO, the HDF5 files that WEC-Sim reads.

Each body has its rows of the matrices of all: A/ρ, B/(ρω), K/(ρg), X/(ρg), A∞/ρ unless `scaled` is
1; waves are e^{+iωt}, and motions are about `cg`. Impulse responses and state spaces in the file
are not used: a memory is fitted to A and B. (WEC-Sim, `writeBEMIOH5.m`.)
"""

from __future__ import annotations

import math
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
from m4e_fmi.errors import InputError

PARAMETERS = "simulation_parameters"
INFINITE = ("infinite", "inf", "infinity")


def read_bemio(path: Path) -> FileData:
    """The data of a file; InputError with all its problems."""
    with opened_netcdf(path) as tree:
        count = sum(g.startswith("body") and g[4:].isdecimal() for g in tree.groups())
        if not count:
            text = f"{path}: there are no groups body1, body2, …"
            raise refused(text, "an .h5 file is to be of BEMIO (WEC-Sim)")
        problems, parts = [], []
        omega = tree.array(f"{PARAMETERS}/w").ravel()
        directions = tree.array(f"{PARAMETERS}/wave_dir").ravel()
        for k in range(count):
            try:
                parts.append(_body(tree, k, (len(omega), len(directions), SIX * count)))
            except InputError as error:
                problems += error.problems
        InputError.raise_for(problems)
        return _assembled(tree, omega, directions, parts)


class _Part:
    """The arrays of one body, shapes as read: SIX rows of the matrices of all."""

    def __init__(self, tree: Tree, group: str) -> None:
        coefficients = f"{group}/hydro_coeffs"
        self.added_mass = tree.array(f"{coefficients}/added_mass/all")
        self.damping = tree.array(f"{coefficients}/radiation_damping/all")
        name = f"{coefficients}/added_mass/inf_freq"
        self.added_mass_inf = tree.array(name) if tree.has(name) else None
        real, imaginary = (tree.array(f"{coefficients}/excitation/{p}") for p in ("re", "im"))
        self.excitation = real - 1j * imaginary
        self.stiffness = tree.array(f"{coefficients}/linear_restoring_stiffness")
        properties = f"{group}/properties"
        self.name = next(iter(tree.texts(f"{properties}/name")), group)
        self.center = _point(tree, f"{properties}/cg")
        self.buoyancy = _point(tree, f"{properties}/cb")
        self.volume = tree.number(f"{properties}/disp_vol")


def _body(tree: Tree, k: int, sizes: tuple[int, int, int]) -> _Part:
    """One body, its shapes checked: `sizes` are those of frequencies, directions and motions."""
    part, (count, ways, n) = _Part(tree, f"body{k + 1}"), sizes
    expected = {
        "added_mass": (SIX, n, count),
        "damping": (SIX, n, count),
        "excitation": (SIX, ways, count),
        "stiffness": (SIX, SIX),
    }
    own = {"added_mass": (SIX, SIX, count), "damping": (SIX, SIX, count)}
    for name, shape in expected.items():
        got = getattr(part, name).shape
        if got not in (shape, own.get(name, shape)):
            text = f"{tree.path}: {name} of body{k + 1} has the shape {got}, expected {shape}"
            remedy = "six motions of each body are read, no generalised modes"
            raise refused(text, remedy if got[:1] > (SIX,) else "it is cut off, or written wrongly")
    if part.added_mass.shape[1] != n:  # without body-to-body terms
        place = slice(SIX * k, SIX * k + SIX)
        for name in own:
            whole = np.zeros((SIX, n, count))
            whole[:, place] = getattr(part, name)
            setattr(part, name, whole)
        if part.added_mass_inf is not None and part.added_mass_inf.shape[1] != n:
            whole = np.zeros((SIX, n))
            whole[:, place] = part.added_mass_inf
            part.added_mass_inf = whole
    return part


def _point(tree: Tree, name: str) -> Point:
    values = tree.array(name).ravel()
    if len(values) != 3:
        raise refused(f"{tree.path}: {name} has {len(values)} values, expected x, y, z")
    x, y, z = values.tolist()
    return x, y, z


def _assembled(
    tree: Tree, omega: np.ndarray, directions: np.ndarray, parts: list[_Part]
) -> FileData:
    density, gravity = (tree.number(f"{PARAMETERS}/{name}") for name in ("rho", "g"))
    name = f"{PARAMETERS}/scaled"
    scaled = tree.number(name) if tree.has(name) else 0.0
    mass, damping, weight = 1.0, omega, 1.0
    if scaled:
        mass, damping, weight = 1 / density, 1 / density, 1 / (density * gravity)
    infinite = [part.added_mass_inf for part in parts if part.added_mass_inf is not None]
    return FileData(
        path=tree.path,
        format="BEMIO",
        bodies=tuple(
            FileBody(
                name=part.name,
                stiffness=part.stiffness * weight,
                reference=part.center,
                center_of_gravity=part.center,
                center_of_buoyancy=part.buoyancy,
                volume=part.volume,
            )
            for part in parts
        ),
        omega=omega,
        added_mass=np.concatenate([p.added_mass for p in parts]).transpose(2, 0, 1) * mass,
        damping=(np.concatenate([p.damping for p in parts]) * damping).transpose(2, 0, 1),
        added_mass_inf=np.concatenate(infinite) * mass if len(infinite) == len(parts) else None,
        directions=directions,
        excitation=np.concatenate([p.excitation for p in parts]).transpose(2, 1, 0) * weight,
        density=density,
        gravity=gravity,
        depth=_depth(tree),
        notes=(f"values of the file are {'dimensional' if scaled else 'per density'}",),
    )


def _depth(tree: Tree) -> float:
    """[m]; BEMIO writes the word "infinite" for deep water."""
    name = f"{PARAMETERS}/water_depth"
    words = tree.texts(name)
    if words and words[0].lower() in INFINITE:
        return math.inf
    return tree.number(name)
