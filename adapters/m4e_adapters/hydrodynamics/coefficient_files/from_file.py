"""Coefficients of a configuration from its file: bodies, water, centres, A∞, directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.consistency import (
    Relation,
    findings,
    ogilvie,
    surge_share,
)
from m4e_adapters.hydrodynamics.coefficient_files.directions import (
    Symmetry,
    symmetry_of,
    with_directions,
)
from m4e_adapters.hydrodynamics.coefficient_files.file_data import KEYS, SIX, FileData, refused
from m4e_adapters.hydrodynamics.coefficient_files.matching import (
    MatchedBody,
    matched_bodies,
    matched_water,
    told_bodies,
)
from m4e_adapters.hydrodynamics.coefficient_files.reading import read_coefficient_file
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.geometry.motions import places_in_space
from m4e_adapters.hydrodynamics.memory.soundness import check_added_mass_inf
from m4e_fmi.errors import InputError, Problem

WRONG_PHASE = 0.5  # of `surge_share`, from which the sign of the phases is certain


@dataclass(frozen=True)
class FromFile:
    """`coefficients` of a file, the `findings` on them, and lines on where they come from."""

    coefficients: Coefficients
    findings: tuple[Relation, ...]
    notes: tuple[str, ...]


def coefficients_from_file(
    config: HydrodynamicsConfig, *, folder: Path, progress: Callable[[str], object]
) -> Coefficients:
    """Coefficients of the configured bodies from the file that `coefficients` names.

    `progress` is told where all comes from, and the consistency of the data. InputError with all
    problems of the file and of what does not go with it.
    """
    found = read_for(config, folder=folder)
    for text in found.notes:
        progress(f"note: {text}")
    for finding in found.findings:
        start = "warning: " if finding.warns else ""
        progress(f"{start}consistency, {finding.name}: {finding.text}")
    return found.coefficients


def read_for(config: HydrodynamicsConfig, *, folder: Path) -> FromFile:
    """The coefficients for all directions that the file has; InputError as of the above."""
    assert config.coefficients is not None
    data = read_coefficient_file(folder / config.coefficients)
    problems: list[Problem] = []
    bodies = matched_bodies(config, data, problems)
    water = matched_water(config, data, problems)
    InputError.raise_for(dict.fromkeys(problems))
    moved = _about_centers(data, bodies)
    centers = np.array([body.center for body in bodies])
    symmetry = symmetry_of((moved.added_mass, moved.damping), centers)
    moved = _without(moved, symmetry)
    made, table, source = _assembled(moved, bodies, water, config.dimensions)
    phases = _phases(made, data, table)
    try:
        check_added_mass_inf(made, 0.5 * (made.added_mass_inf + made.added_mass_inf.T))
    except InputError as error:
        raise InputError([replace(p, keys=KEYS) for p in error.problems]) from None
    made, notes = with_directions(made, data.directions, table, symmetry)
    shown, count = ", ".join(f"{beta:g}" for beta in data.directions), len(data.bodies)
    said = (
        f"coefficients of {data.path.name} ({data.format}): {count} "
        f"{'body' if count == 1 else 'bodies'}, {len(data.omega)} frequencies from "
        f"{data.omega[0]:.4g} to {data.omega[-1]:.4g} rad/s, waves that travel at {shown} deg",
        *data.notes,
        *told_bodies(bodies, config, data),
        phases,
        _missing_water(data, water),
        source,
        symmetry.text,
        *notes,
    )
    kept = findings(made, added_mass_inf_of_file=data.added_mass_inf is not None)
    if not config.loads.excitation:
        made = made.without_excitation()
    return FromFile(made, tuple(kept), tuple(filter(None, said)))


def _about_centers(data: FileData, bodies: Sequence[MatchedBody]) -> FileData:
    """The data of the `bodies`, in their order, for motions about their centres of gravity."""
    places = np.concatenate([np.arange(SIX) + SIX * body.number for body in bodies])
    arms = np.eye(len(places))  # motions about reference points by those about centres of gravity
    for k, body in enumerate(bodies):
        x, y, z = body.arm.tolist()
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # rotation × arm
        arms[SIX * k : SIX * k + 3, SIX * k + 3 : SIX * k + 6] = turned

    def moved(values: np.ndarray) -> np.ndarray:
        return arms.T @ values[..., places[:, None], places] @ arms

    own = [arms[SIX * k : SIX * k + SIX, SIX * k : SIX * k + SIX] for k in range(len(bodies))]
    infinite = data.added_mass_inf
    return replace(
        data,
        bodies=tuple(
            replace(body.of_file, stiffness=arm.T @ body.stiffness @ arm)
            for body, arm in zip(bodies, own, strict=True)
        ),
        added_mass=moved(data.added_mass),
        damping=moved(data.damping),
        added_mass_inf=None if infinite is None else moved(infinite),
        excitation=data.excitation[..., places] @ arms,
    )


def _without(data: FileData, symmetry: Symmetry) -> FileData:
    """The data without what their symmetry forbids."""
    kept = ~symmetry.forbidden
    infinite = data.added_mass_inf
    return replace(
        data,
        bodies=tuple(
            replace(body, stiffness=body.stiffness * kept[:SIX, :SIX]) for body in data.bodies
        ),
        added_mass=data.added_mass * kept,
        damping=data.damping * kept,
        added_mass_inf=None if infinite is None else infinite * kept,
    )


def _assembled(
    data: FileData, bodies: Sequence[MatchedBody], water: Water, dimensions: int
) -> tuple[Coefficients, np.ndarray, str]:
    """The coefficients, the excitation (nω, nβ, n) [N/m, N.m/m], and where A∞ comes from."""
    motions = np.array(places_in_space(dimensions))
    kept = np.concatenate([SIX * k + motions for k in range(len(bodies))])
    pairs, weight = np.ix_(kept, kept), water.density * water.gravity
    stiffness = np.zeros((SIX * len(bodies),) * 2)
    for k, body in enumerate(data.bodies):
        own = slice(SIX * k, SIX * k + SIX)
        stiffness[own, own] = weight * body.stiffness
    mass = water.density * data.added_mass[:, *pairs]
    damping = water.density * data.damping[:, *pairs]
    if data.added_mass_inf is not None:
        infinite = water.density * data.added_mass_inf[pairs]
        source = "A∞ is that of the file"
    else:
        infinite, _ = ogilvie(data.omega, mass, damping)
        source = "the file has no A∞: it follows from A(ω) and B(ω) by Ogilvie's relation"
    table = weight * data.excitation[..., kept]
    made = Coefficients(
        bodies=tuple(body.name for body in bodies),
        centers=np.array([_point(body.center, dimensions) for body in bodies]),
        omega=data.omega,
        added_mass=mass,
        radiation_damping=damping,
        added_mass_inf=infinite,
        excitation=table[:, 0],
        hydrostatic_stiffness=stiffness[pairs],
        buoyancy=_buoyancy(bodies, stiffness, weight)[kept],
        wave_direction=float(data.directions[0]),
        density=water.density,
        depth=water.depth,
        gravity=water.gravity,
    )
    return made, table, source


def _point(center: Sequence[float], dimensions: int) -> tuple[float, ...]:
    x, y, z = center
    return (x, z) if dimensions == 2 else (x, y, z)


def _buoyancy(bodies: Sequence[MatchedBody], stiffness: np.ndarray, weight: float) -> np.ndarray:
    """Force and moment (6N,) [N, N.m] of the still water about the centres of gravity.

    Where the file has no centre of buoyancy, the moments are those that K46 and K56 say.
    """
    found = np.zeros(SIX * len(bodies))
    for k, body in enumerate(bodies):
        force = weight * body.volume
        own = slice(SIX * k, SIX * k + SIX)
        roll, pitch = stiffness[own, own][[4, 3], 5] * (-1, 1)
        if body.of_file.center_of_buoyancy is not None:
            x, y, _ = np.subtract(body.of_file.center_of_buoyancy, body.center)
            roll, pitch = y * force, -x * force
        found[own] = 0.0, 0.0, force, roll, pitch, 0.0
    return found


def _phases(made: Coefficients, data: FileData, table: np.ndarray) -> str:
    """A line on the conventions of the phases; InputError if long waves have others."""
    shares = []
    for k, beta in enumerate(data.directions.tolist()):
        if made.dimensions == 2 and abs(np.cos(np.radians(beta))) < 0.1:
            continue
        relative = table[:, k] * made.way(made.omega, beta).conj()
        shares.append(surge_share(made, relative, beta))
    known = [s for s in shares if np.isfinite(s)]
    share = float(np.mean(known)) if known else float("nan")
    if share > WRONG_PHASE:
        raise refused(
            "the excitation along long waves has the opposite sign: the phases are e^{+iωt} for "
            "e^{−iωt} (or the reverse), or the directions are those that waves come from",
            "write the file in the conventions of its format: waves travel to their direction",
        )
    of = "e^{−iωt}, as here" if data.format == "Capytaine" else "e^{+iωt}, turned to e^{−iωt}"
    checked = "confirmed by the force along long waves"
    if not share < -WRONG_PHASE:
        checked = "not checked: the force along long waves is too small"
    return f"phases of {data.format} are {of}: {checked}"


def _missing_water(data: FileData, water: Water) -> str:
    """A line on the water where the file says nothing: the system file's or default values."""
    depth = f"depth {water.depth:g} m" if np.isfinite(water.depth) else "deep water"
    texts = {
        "density": f"density {water.density:g} kg/m3",
        "depth": depth,
        "gravity": f"gravity {water.gravity:g} m/s2",
    }
    sources = {True: "of the system file", False: "by default"}
    missing = [key for key in texts if getattr(data, key) is None]
    told = [f"{texts[key]} {sources[key in water.model_fields_set]}" for key in missing]
    return f"the file has no {', '.join(missing)}: {', '.join(told)}" if told else ""
