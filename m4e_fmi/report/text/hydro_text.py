"""Hydrodynamic coefficients, their memory and their consistency, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from m4e_fmi.analysis.hydrodynamic_data import HydrodynamicData

COUPLED = 0.05  # of the motions' own, from which a coupling has a row
MOST_COUPLINGS = 12


def hydro_text(data: HydrodynamicData) -> str:
    """Sources, a row for each motion and for large couplings, the memory, its cost, findings."""
    count = len(data.omega)
    lines = [
        f"{data.title}: {len(data.motions)} motions, {count} frequencies from "
        f"{data.omega[0]:.4g} to {data.omega[-1]:.4g} rad/s",
        *(f"  {note}" for note in data.notes),
        "",
        *_motions(data),
        *_couplings(data),
        "",
        *_memories(data),
        "",
        "consistency",
    ]
    for name, text, warns in data.findings:
        lines.append(f"  {'warning: ' if warns else ''}{name}: {text}")
    return "\n".join(lines)


def hydro_json(data: HydrodynamicData) -> dict[str, object]:
    """All numbers: SI, directions in deg, matrices by force and motion."""
    return {
        "title": data.title,
        "motions": [m.name for m in data.motions],
        "omega": data.omega.tolist(),
        "added_mass": data.added_mass.tolist(),
        "radiation_damping": data.damping.tolist(),
        "added_mass_inf": data.added_mass_inf.tolist(),
        "hydrostatic_stiffness": data.stiffness.tolist(),
        "directions": data.directions.tolist(),
        "excitation_real": np.real(data.excitation).tolist(),
        "excitation_imaginary": np.imag(data.excitation).tolist(),
        "memories": [
            {
                "motions": [data.motions[k].name for k in memory.motions],
                "poles": memory.poles,
                "states": memory.states,
                "error": memory.error,
                "damping_error": memory.damping_error,
            }
            for memory in data.memories
        ],
        "states": data.states,
        "operations": data.operations,
        "findings": [
            {"name": name, "text": text, "warning": warns} for name, text, warns in data.findings
        ],
        "notes": list(data.notes),
    }


def _motions(data: HydrodynamicData) -> Iterator[str]:
    yield (
        f"  {'motion':<20} {'A∞':>11} {'A at first':>11} {'largest B':>11} {'at':>7} "
        f"{'stiffness':>11} {'largest |X|':>11} {'at':>7}"
    )
    yield f"  {'[kg, kg.m2, N, N.m, m, rad, s]':<50} {'':>6} [rad/s] {'':>23} [rad/s]"
    for k, motion in enumerate(data.motions):
        damping, force = data.damping[:, k, k], np.abs(data.excitation[:, :, k]).max(axis=1)
        most, top = int(damping.argmax()), int(force.argmax())
        yield (
            f"  {motion.name:<20} {data.added_mass_inf[k, k]:11.4g} "
            f"{data.added_mass[0, k, k]:11.4g} {damping[most]:11.4g} {data.omega[most]:7.3g} "
            f"{data.stiffness[k, k]:11.4g} {force[top]:11.4g} {data.omega[top]:7.3g}"
        )


def _couplings(data: HydrodynamicData) -> list[str]:
    """The largest couplings, over the motions' own."""
    own = np.sqrt(np.abs(data.damping.diagonal(axis1=1, axis2=2)).max(axis=0))
    size = np.outer(own, own)
    share = np.abs(data.damping).max(axis=0) / np.where(size > 0, size, np.inf)
    mass = np.sqrt(np.abs(data.added_mass_inf.diagonal()))
    masses = np.outer(mass, mass)
    other = np.abs(data.added_mass_inf) / np.where(masses > 0, masses, np.inf)
    trifle = own**2 < 1e-6 * (own**2).max(initial=0.0)
    share[trifle], share[:, trifle] = 0.0, 0.0
    pairs = [
        (max(share[i, j], other[i, j]), i, j)
        for i in range(len(own))
        for j in range(i + 1, len(own))
        if not (trifle[i] or trifle[j])
    ]
    pairs = [p for p in sorted(pairs, reverse=True) if p[0] > COUPLED]
    if not pairs:
        return []
    lines = ["", f"  {'coupling':<40} {'A∞':>11} {'of own':>8} {'largest |B|':>11} {'of own':>8}"]
    for _, i, j in pairs[:MOST_COUPLINGS]:
        name = f"{data.motions[i].name}, {data.motions[j].name}"
        lines.append(
            f"  {name:<40} {data.added_mass_inf[i, j]:11.4g} {100 * other[i, j]:6.3g} % "
            f"{np.abs(data.damping[:, i, j]).max():11.4g} {100 * share[i, j]:6.3g} %"
        )
    if len(pairs) > MOST_COUPLINGS:
        lines.append(f"  and {len(pairs) - MOST_COUPLINGS} more above {100 * COUPLED:g} %")
    return lines


def _memories(data: HydrodynamicData) -> Iterator[str]:
    if not data.memories:
        yield "  no memory: the forces of radiation could not be fitted, or there are none"
        return
    yield f"  {'memory of':<50} {'order':>6} {'states':>7} {'error':>8} {'of damping':>11}"
    for memory in data.memories:
        names = ", ".join(data.motions[k].name for k in memory.motions)
        yield (
            f"  {names:<50} {memory.poles:6d} {memory.states:7d} {100 * memory.error:6.2g} % "
            f"{100 * memory.damping_error:9.2g} %"
        )
    yield (
        f"  cost: {data.states} states, {data.operations} operations for all forces at a time, in "
        "the waves of the component"
    )
