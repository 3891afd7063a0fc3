"""Fits of groups of motions, each kept by the content of its data."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version

import numpy as np
from numpy.typing import ArrayLike

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.flow import cache
from m4e_adapters.hydrodynamics.memory.group_fit import fit_group
from m4e_adapters.hydrodynamics.memory.radiation_group import Misfit, RadiationGroup
from m4e_adapters.hydrodynamics.memory.reach import Reach
from m4e_fmi.code_hash import package_hash

LIBRARIES = ("numpy", "scipy")  # whose versions count


def kept_group(
    data: Coefficients,
    motions: tuple[int, ...],
    signal: np.ndarray,
    sound: np.ndarray,
    *,
    reach: Reach,
    order: int | None,
    progress: Callable[[str], object],
) -> RadiationGroup:
    """As `group_fit.fit_group`, computed once for the same data.

    `signal` (n, n), booleans: pairs of motions that count. `sound` (nω,), booleans: frequencies
    that count.
    """
    content: dict[str, ArrayLike] = {
        "code": [package_hash("m4e_adapters.hydrodynamics.memory")],
        "libraries": [f"{name} {version(name)}" for name in LIBRARIES],
        "motions": motions,
        "order": -1 if order is None else order,
        "signal": signal,
        "sound": sound,
        "fitted": reach.fitted,
        "resolved": reach.resolved,
        "omega": data.omega,
        "added_mass": data.added_mass,
        "radiation_damping": data.radiation_damping,
        "added_mass_inf": data.added_mass_inf,
        "limits": data.memory_limits,
    }
    key = cache.content_key(content)
    arrays = cache.found(key, progress)
    if arrays is not None:
        return _unpacked(arrays)
    group = fit_group(data, motions, signal, sound, reach=reach, order=order)
    cache.keep(key, _packed(group), progress)
    return group


def _packed(group: RadiationGroup) -> dict[str, np.ndarray]:
    def misfit(m: Misfit) -> np.ndarray:
        return np.array([m.error, m.damping_error, *m.damping_at])

    return {
        "motions": np.array(group.motions),
        "poles": group.poles,
        "residues": group.residues,
        "surplus": group.surplus,
        "inertia": group.inertia,
        "misfit": misfit(group.misfit),
        "misfit_of_all": misfit(group.misfit_of_all),
        "resolved": group.resolved,
        "ends": group.ends,
        "doubtful": np.array(group.doubtful),
        "scattered": np.array(group.scattered),
    }


def _unpacked(arrays: dict[str, np.ndarray]) -> RadiationGroup:
    def misfit(name: str) -> Misfit:
        error, damping_error, motion, at = arrays[name].tolist()
        return Misfit(error, damping_error, (int(motion), at))

    return RadiationGroup(
        motions=tuple(arrays["motions"].tolist()),
        poles=arrays["poles"],
        residues=arrays["residues"],
        surplus=arrays["surplus"],
        inertia=arrays["inertia"],
        misfit=misfit("misfit"),
        misfit_of_all=misfit("misfit_of_all"),
        resolved=arrays["resolved"],
        ends=arrays["ends"],
        doubtful=tuple(arrays["doubtful"].tolist()),
        scattered=bool(arrays["scattered"]),
    )
