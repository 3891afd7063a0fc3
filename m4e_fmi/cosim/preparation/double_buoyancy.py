"""Parts of a body that displace the same water in two components.

A kind may offer ``displaced(config, *, folder)``: the surfaces of what has buoyancy in it, in the
axes of each body, by body and name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise, permutations

import numpy as np

from m4e_fmi.cosim.connections.links import Port, Wiring
from m4e_fmi.cosim.preparation.double_drag import moved_together
from m4e_fmi.cosim.system.component import Kind, kind_module
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError
from m4e_fmi.report.drawing.space.hulls import Hull

DISPLACED = "displaced"
DOWN = np.array([0.01234, 0.02718, -1.0])
"""Direction of rays that seldom meet an edge; downwards, as hulls may be open at the top."""


def double_buoyancy(system: System, wiring: Wiring) -> Iterator[str]:
    """A line on each two components on one body of which one has parts within a hull of the other.

    Parts of a surface, such as members, are within it where any of their corners is.
    """
    for source, takers in moved_together(wiring).items():
        surfaces = {port: _displaced(system, port) for port in takers} if len(takers) > 1 else {}
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
    find = getattr(kind_module(source.name), DISPLACED, None) if isinstance(source, Kind) else None
    if find is None or not isinstance(source, Kind):
        return {}
    try:
        found: Mapping[str, Mapping[str, Hull]] = find(source.config, folder=system.folder)
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
