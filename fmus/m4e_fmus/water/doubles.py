"""Loads of the water that count twice, as two components on one body have them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations, pairwise, permutations

import numpy as np

from m4e_fmi.cosim.system.component import Kind, kind_of
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Link, Port, Variables, Wiring
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.fmu import Description
from m4e_fmi.report.drawing.hulls import Hull

DRAG = ("drag_", "linear_drag_")
"""Beginnings of the last names of a hull's drag coefficients; `drag_force_…` are outputs."""
DOWN = np.array([0.01234, 0.02718, -1.0])
"""Direction of rays that seldom meet an edge; downwards, as hulls may be open at the top."""


def double_load_problems(
    system: System, variables: Variables, links: Iterable[Link]
) -> Iterable[Problem]:
    """Bodies on which linear loads act together with the same loads at the true pose.

    That is told of two components which take the height of one body.
    """
    for source, takers in moved_together(links).items():
        for link, other in permutations(takers, 2):
            body, one, two = (
                str(p).removesuffix(".z") for p in (source, link.target, other.target)
            )
            place = ("connections", other.connection)
            # `link` leads to the hull with the pressure at its true pose, `other` to linear loads
            exact, linear = (k.target.variable.removesuffix("z") for k in (link, other))
            known = variables[link.target.component].keys()
            loads = variables[other.target.component].keys()
            in_waves = {f"{exact}wetted_volume", f"{exact}froude_krylov_force_z"} <= known
            doubled = []
            if f"{exact}wetted_volume" in known and f"{linear}buoyancy_force_z" in loads:
                doubled.append("hydrostatics")
            parts = {f"{linear}excitation_force_z", f"{linear}froude_krylov_force_z"}
            if in_waves and not parts.isdisjoint(loads):
                doubled.append("froude_krylov")
            if doubled:
                message = f"{' and '.join(doubled)} of {body} count twice, in {one} and {two}"
                switches = ", ".join(f"{name}: none" for name in doubled)
                remedy = f"write 'loads: {{{switches}}}' at {other.target.component}"
                yield system.problem(place, message, remedy)
            drifts = (f"{linear}drift_force_", f"{linear}drift_moment_")
            if in_waves and any(name.startswith(drifts) for name in loads):
                message = f"second-order drift of {body} counts twice: waves on the wetted hull "
                message += f"in {one} make some of that in {two}"
                remedy = f"remove 'drift' of the body at {other.target.component}, or the waves of "
                yield system.problem(place, message, f"{remedy}{link.target.component}")


def moved_together(links: Iterable[Link]) -> dict[Port, list[Link]]:
    """Links to heights that components take, by the height of the body that they follow."""
    moved: dict[Port, list[Link]] = {}
    for link in links:
        if link.source.variable.endswith(".z") and link.target.variable.endswith(".z"):
            moved.setdefault(link.source, []).append(link)
    return moved


def double_drag(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> Iterator[str]:
    """A line on each two components that move with one body and both have drag on it."""
    for source, takers in moved_together(wiring.links).items():
        acting = [k.target for k in takers if _has_drag(system, descriptions, k.target)]
        for one, other in combinations(acting, 2):
            body, first, second = (str(p).removesuffix(".z") for p in (source, one, other))
            yield (
                f"{first} and {second} both have drag on {body}: right for different parts of it; "
                "of the same part leave it to one of them"
            )


def _has_drag(system: System, descriptions: Mapping[str, Description], port: Port) -> bool:
    """True if the component gives drag on the body whose height is `port`.

    A hull's coefficients are parameters of the body; members have their own.
    """
    body = port.variable.removesuffix("z")
    variables = descriptions[port.component].variables
    if f"{body}drag_force_z" not in variables:
        return False
    start = next(c.start for c in system.components if c.name == port.component)
    coefficients = [
        variable
        for name, variable in variables.items()
        if name.startswith(tuple(body + part for part in DRAG))
        and variable.causality == "parameter"
    ]
    values = (value_of(v, start.get(v.name, float(v.start or 0.0))) for v in coefficients)
    return not coefficients or any(value != 0.0 for value in values)


def double_buoyancy(system: System, wiring: Wiring) -> Iterator[str]:
    """A line on each two components on one body of which one has parts within a hull of the other.

    Parts of a surface, such as members, are within it where any of their corners is.
    """
    for source, takers in moved_together(wiring.links).items():
        ports = [link.target for link in takers] if len(takers) > 1 else []
        surfaces = {port: _displaced(system, port) for port in ports}
        for one, other in permutations(surfaces, 2):
            names = [
                name
                for name, part in surfaces[one].items()
                if any(_reach_into(part, hull) for hull in surfaces[other].values())
            ]
            if names:
                body, first, second = (str(p).removesuffix(".z") for p in (source, one, other))
                yield (
                    f"{', '.join(names)} of {first}: in part or in full within {second}, so that "
                    f"buoyancy on {body} counts twice there; end members at the hull, or write "
                    "'buoyancy: false' (and 'added_mass: 0, inertia: 0') at them"
                )


def _displaced(system: System, port: Port) -> Mapping[str, Hull]:
    """Surfaces of what has buoyancy on the body whose height is `port`; none if not known."""
    source = next(c.source for c in system.components if c.name == port.component)
    if not isinstance(source, Kind):
        return {}
    try:
        found = kind_of(source.name).displaced(source.config, folder=system.folder) or {}
    except InputError:  # told where the component is built
        return {}
    return found.get(port.variable.removesuffix(".z"), {})


def _reach_into(part: Hull, hull: Hull) -> bool:
    """True if a corner of `part` is within `hull`: a ray meets its surface an odd number of times.

    (T. Möller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools 2,
    1997.)
    """
    triangles = np.array([(face[0], *pair) for face in hull.faces for pair in pairwise(face[1:])])
    corner, *others = (hull.vertices[triangles[:, k]] for k in range(3))
    one, two = (other - corner for other in others)
    across = np.cross(DOWN, two)
    volume = np.einsum("ij,ij->i", one, across)
    inverse = 1.0 / np.where(volume == 0.0, np.inf, volume)
    low, high = hull.vertices.min(axis=0), hull.vertices.max(axis=0)
    near = part.vertices[np.all((part.vertices > low) & (part.vertices < high), axis=1)]
    for point in near:
        away = point - corner
        normal = np.cross(away, one)
        first = np.einsum("ij,ij->i", away, across) * inverse
        second = normal @ DOWN * inverse
        ahead = np.einsum("ij,ij->i", two, normal) * inverse > 0.0
        met = ahead & (first > 0.0) & (second > 0.0) & (first + second < 1.0)
        if int(met.sum()) % 2:
            return True
    return False
