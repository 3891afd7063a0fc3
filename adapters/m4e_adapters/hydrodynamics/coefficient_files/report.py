"""Coefficients, the memory fitted to them and their consistency, for `m4e-fmi hydro`."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.build import coefficients_from_config, program_of
from m4e_adapters.hydrodynamics.coefficient_files.consistency import Relation, findings
from m4e_adapters.hydrodynamics.coefficient_files.from_file import read_for
from m4e_adapters.hydrodynamics.coefficient_files.reading import read_coefficient_file
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.memory.convolution import ConvolutionGroup
from m4e_adapters.hydrodynamics.memory.group_fit import RadiationGroup
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory, fit_radiation
from m4e_fmi.analysis.hydrodynamic_data import FittedMemory, HydrodynamicData, Motion
from m4e_fmi.errors import InputError

Group = RadiationGroup | ConvolutionGroup
TIMES, FREQUENCIES = 400, 400
LONGEST = 60.0  # s of the memory that is shown
DECAYED = 0.01  # of its largest value, to which the memory is shown


def config_of_file(
    path: Path, *, progress: Callable[[str], object], depth: float | None = None
) -> HydrodynamicsConfig:
    """The configuration of all bodies of a file, in space and still water.

    The water has a `depth` [m], by default that of the file, else it is deep. `progress` is told
    what is assumed where the file lacks a body's centre or volume.
    """
    data = read_coefficient_file(path)
    bodies: dict[str, dict[str, object]] = {}
    for k, body in enumerate(data.bodies):
        name = re.sub(r"\W", "_", body.name, flags=re.ASCII)
        keys: dict[str, object] = {}
        if body.center_of_gravity is None:
            center = body.reference or (0.0, 0.0, 0.0)
            keys["center_of_gravity"] = list(center)
            progress(
                f"note: no centre of gravity of {body.name!r} in the file: {center} is assumed"
            )
        if not body.volume:
            masses = data.added_mass_inf if data.added_mass_inf is not None else data.added_mass[-1]
            own = masses.diagonal()[6 * k : 6 * k + 3]
            volume = max(float(own.max()), float(np.finfo(float).tiny))
            keys["volume"] = volume
            progress(
                f"note: no displaced volume of {body.name!r} in the file: {volume:.4g} m3, its "
                "largest added mass, is assumed, to see how far its memory reaches"
            )
        bodies[name if re.match(r"[A-Za-z_]", name) else f"body{k + 1}"] = keys
    water = {} if depth is None else {"depth": depth}
    return HydrodynamicsConfig.model_validate(
        {"dimensions": 3, "coefficients": path.name, "bodies": bodies, "water": water}
    )


def hydrodynamic_data(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> HydrodynamicData:
    """The coefficients of a configuration, computed or from a file, and the fit to them."""
    notes: list[str] = []

    def report(text: str) -> None:
        progress(text)
        if not re.search(r"\d+ of \d+$", text):
            notes.append(text)

    if config.coefficients is None:
        c = coefficients_from_config(config, folder=folder, progress=report)
        found: Sequence[Relation] = findings(c)
    else:
        read = read_for(config, folder=folder)
        notes += read.notes
        c, found = read.coefficients, read.findings
        c = c if config.body_to_body else c.without_interaction()
    fitted, faults = _fitted(c, config, report)
    program = program_of(config, c, name=name, folder=folder, memory=fitted, progress=progress)
    fit_omega = np.linspace(0.0, float(c.omega[-1]), FREQUENCIES + 1)[1:]
    transfer = _of_all(fitted, len(fit_omega), lambda group: group.transfer(fit_omega))
    time = _times(fitted, c)
    directions, table = _excitation(c)
    return HydrodynamicData(
        title=name,
        motions=tuple(
            Motion(own, kind.force_unit, kind.unit)
            for own, kind in zip(c.motions, c.body_motions * len(c.bodies), strict=True)
        ),
        omega=c.omega,
        added_mass=c.added_mass,
        damping=c.radiation_damping,
        added_mass_inf=c.added_mass_inf,
        stiffness=c.hydrostatic_stiffness,
        fit_omega=fit_omega,
        fit_added_mass=fitted.added_mass_inf + np.imag(transfer) / fit_omega[:, None, None],
        fit_damping=np.real(transfer),
        time=time,
        memory=_cosine_transform(c, time),
        fit_memory=_memory(fitted, time),
        directions=directions,
        excitation=table,
        memories=tuple(
            FittedMemory(
                motions=group.motions,
                poles=group.order,
                states=group.order * len(group.motions),
                error=group.error,
                damping_error=group.misfit.damping_error,
            )
            for group in fitted.groups
        ),
        states=len(program.states),
        operations=len(program.operations(program.results)),
        findings=[*((f.name, f.text, f.warns) for f in found), *faults],
        notes=tuple(notes),
    )


def _fitted(
    c: Coefficients, config: HydrodynamicsConfig, report: Callable[[str], object]
) -> tuple[RadiationMemory, list[tuple[str, str, bool]]]:
    """The memory; where no fit is possible none, and that as a finding."""
    try:
        convolution = config.radiation.memory == "convolution"
        order = config.radiation.order
        return fit_radiation(c, order=order, convolution=convolution, progress=report), []
    except InputError as error:
        faults = [("memory", f"{p.message}: {p.remedy}", True) for p in error.problems]
        return RadiationMemory((), c.added_mass_inf), faults


def _of_all(
    fitted: RadiationMemory, count: int, values: Callable[[Group], np.ndarray]
) -> np.ndarray:
    """The `values` (count, k, k) of each group in the place of its motions, (count, n, n)."""
    found = np.zeros((count, *fitted.added_mass_inf.shape), dtype=complex)
    for group in fitted.groups:
        found[:, *np.ix_(group.motions, group.motions)] = values(group)
    return found


def _memory(fitted: RadiationMemory, time: np.ndarray) -> np.ndarray:
    return np.real(_of_all(fitted, len(time), lambda group: group.impulse_response(time)))


def _times(fitted: RadiationMemory, c: Coefficients) -> np.ndarray:
    """From 0 to where the fitted memory has decayed."""
    time = np.linspace(0.0, LONGEST, TIMES + 1)
    own = np.abs(_memory(fitted, time).diagonal(axis1=1, axis2=2))
    alive = np.flatnonzero((own > DECAYED * own.max(axis=0)).any(axis=1) & (own.max() > 0))
    end = time[alive[-1]] if len(alive) else 2 * np.pi / float(c.omega[0])
    return np.linspace(0.0, end, TIMES + 1)


def _cosine_transform(c: Coefficients, time: np.ndarray) -> np.ndarray:
    """K(t) = (2/π) ∫ B cos ωt dω of B, linear between its frequencies and 0 at ω = 0."""
    omega = np.concatenate([[0.0], c.omega])
    damping = np.concatenate([np.zeros((1, *c.radiation_damping.shape[1:])), c.radiation_damping])
    t = time[1:, None]
    steps = np.diff(omega)
    slopes = np.diff(damping, axis=0) / steps[:, None, None]
    # by parts: −(1/t) ∫ B' sin ωt dω, and the step at the last frequency
    swing = (np.cos(t * omega[1:]) - np.cos(t * omega[:-1])) / t**2
    found = np.tensordot(swing, slopes, axes=1)
    found += (np.sin(t * omega[-1]) / t)[:, :, None] * damping[-1]
    first = np.tensordot(steps, 0.5 * (damping[1:] + damping[:-1]), axes=1)
    return (2.0 / np.pi) * np.concatenate([first[None], found])


def _excitation(c: Coefficients) -> tuple[np.ndarray, np.ndarray]:
    """Directions (nβ,) [deg], at most four, and the excitation (nω, nβ, n) for them."""
    if len(c.directions):
        chosen = np.unique(np.linspace(0, len(c.directions) - 1, 4).round().astype(int))
        return c.directions[chosen], c.by_direction[:, chosen]
    if not c.has_harmonics:
        return np.array([c.wave_direction]), c.excitation[:, None]
    directions = np.array([0.0, 30.0, 60.0, 90.0])
    orders = np.arange(c.harmonics.shape[1]) - c.harmonics.shape[1] // 2
    turns = np.exp(1j * np.outer(np.radians(directions), orders))
    relative = np.einsum("bj,wjn->wbn", turns, c.harmonics)
    ways = np.stack([c.way(c.omega, beta) for beta in directions.tolist()], axis=1)
    return directions, relative * ways
