"""Why a model's equations have no finite solution in some state, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from m4e_fmi.model import Model
from m4e_fmi.model.checks import findings_with
from m4e_fmi.multibody.assembly import Assembly, Scalars, assemble, links_with_added_mass
from m4e_fmi.multibody.closed_form import mass_matrix
from m4e_fmi.multibody.declaration import inputs_of, state_names
from m4e_fmi.multibody.topology import Topology, TreeLink, topology

LARGEST = 1e150
"""Largest size of a number that can still be squared: floats end at 1e308."""

SINGULAR = 1e-14
"""Smallest over largest eigenvalue of a scaled mass matrix that rounding cannot have made."""


def diagnosis(model: Model, values: Mapping[str, float], time: float) -> str:
    """The fault of a model at `time` [s] and `values` in words; "" if none is found.

    `values` has the parameters, the inputs that act, and the states, by their names in the program.
    """
    for name, value in values.items():
        if not abs(value) < LARGEST:
            return f"{name} is {value:.3g}"
    given = {n: v for n, v in values.items() if n in model.parameters}
    for finding in findings_with(model, given)(given):
        return f"{'.'.join(map(str, finding.location))}: {finding.message}"
    tree = topology(model)
    scalars = _scalars(model, tree, values, time)
    for name, load in model.loads.items():
        try:
            assemble(replace(model, loads={name: load}), tree, scalars)
        except (ArithmeticError, ValueError) as error:
            return f"load {name} cannot be computed: {error}"
    assembly = assemble(model, tree, scalars)
    for link, wrench in zip(tree.links, assembly.wrenches, strict=True):
        largest = max(abs(part) for part in wrench)
        if not largest < LARGEST:
            return f"the load on body {link.body} is {largest:.3g} N or N·m"
    weak = _weak_link(assembly)
    if weak is None:
        return ""
    return (
        f"the mass matrix is singular: nothing resists a motion of body {weak.body} in joint "
        f"{weak.joint_name}"
    )


def _scalars(model: Model, tree: Topology, values: Mapping[str, float], time: float) -> Scalars:
    """Numbers to assemble with; variables that `values` does not have are zero."""
    q, u = [0.0] * len(tree.coordinate_names), [0.0] * len(tree.velocity_names)
    for link in tree.links:
        positions, velocities = state_names(link)
        for name, k in zip(positions, link.coordinates, strict=True):
            q[k] = values.get(name, 0.0)
        for name, k in zip(velocities, link.speeds, strict=True):
            u[k] = values.get(name, 0.0)
    wet = range(1, len(tree.components) * len(links_with_added_mass(model, tree)) + 1)
    return Scalars(
        q,
        u,
        time,
        {name: values.get(name, 0.0) for name in (*model.parameters, *model.lacking)},
        **inputs_of(model, tree, lambda v: values.get(v.name, 0.0)),
        added_mass=[[values.get(f"added_mass[{i},{j}]", 0.0) for j in wet] for i in wet],
    )


def _weak_link(assembly: Assembly) -> TreeLink | None:
    """The link whose coordinate the mass matrix resists least, if it is singular."""
    size = len(assembly.tree.velocity_names)
    M = np.zeros((size, size))
    for j, row in enumerate(mass_matrix(assembly)):
        for k, entry in row.items():
            M[j, k] = entry
    if not np.isfinite(M).all():
        return None
    diagonal = np.diag(M)
    weakest = int(np.argmin(diagonal))
    if diagonal[weakest] > 0:
        scale = 1 / np.sqrt(diagonal)
        eigenvalues, vectors = np.linalg.eigh(scale[:, None] * (M + M.T) / 2 * scale)
        if eigenvalues[0] > SINGULAR * eigenvalues[-1]:
            return None
        weakest = int(np.argmax(np.abs(scale * vectors[:, 0])))
    return next(link for link in assembly.tree.links if weakest in link.speeds)
