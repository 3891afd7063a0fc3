"""Checks of a mesh: does it bound a volume below the water, of panels that are of use."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from m4e_adapters.hydrodynamics.geometry.clearance import overlap
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_fmi.errors import InputError

FLAT = 1e-6  # area of a panel over the square of its longest side, of one that is a line
LONGEST = 1000.0  # m, of hulls
Wrong = Callable[[str, str], InputError]


def place(point: Sequence[float] | np.ndarray) -> str:
    """Words for a place, `point` (3,) [m]."""
    x, y, z = point
    return f"near x = {x:.4g}, y = {y:.4g}, z = {z:.4g} m"


def check_as_drawn(panels: Panels, name: str, *, scale: float) -> None:
    """InputError for a mesh that is far too long, probably in mm, or has panels without area."""
    if panels.size > LONGEST:
        told = "" if scale == 1.0 else f" (with scale {scale:g})"
        raise InputError.single(
            f"body {name!r}: the mesh measures {panels.size:.4g} m{told}, hulls have up to "
            f"{LONGEST:g} m",
            "of a mesh in mm write 'scale: 0.001' beside it",
        )
    corners = panels.corners
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    flat = np.flatnonzero(np.linalg.norm(panels.normals, axis=1) < FLAT * longest**2)
    if len(flat):
        raise InputError.single(
            f"body {name!r}: {len(flat)} panels have no area, the first "
            f"{place(panels.centers[flat[0]])}",
            "remove them, or mesh the surface again: their corners lie in a line",
        )


def checked(panels: Panels, name: str) -> Panels:
    """`panels` if they bound a volume below the waterline; InputError says where they do not."""

    def wrong(message: str, remedy: str) -> InputError:
        return InputError.single(f"body {name!r}: {message}", remedy)

    check_edges(panels, wrong)
    check_shells(panels, wrong)
    return panels


def check_shells(panels: Panels, wrong: Wrong, *, lowered: float = 0.0) -> None:
    """The error that `wrong` makes of closed shells that are inverted, or inside of others.

    They are below the water, or would be if they were `lowered` [m].
    """
    down = np.array([0.0, 0.0, lowered])
    parts = [Panels(shell.vertices - down, shell.faces) for shell in panels.shells()]
    volumes = {id(shell): hydrostatics_of(shell).volume for shell in parts}
    shells = sorted(parts, key=lambda shell: abs(volumes[id(shell)]))
    outwards = [shell if volumes[id(shell)] > 0 else shell.reversed for shell in shells]
    for first, second in combinations(outwards, 2):
        if (point := overlap(first, second)) is not None:
            raise wrong(
                f"a closed shell is inside the hull {place(point + down)}",
                "remove it: a hull is the surface that the water touches; join intersecting parts "
                "into one surface",
            )
    for shell in shells:
        if volumes[id(shell)] <= 0:
            raise wrong(
                "the mesh is inverted: the normals point out of the water "
                f"{place(shell.centers[0] + down)}, the volume within is "
                f"{volumes[id(shell)]:.4g} m3",
                "reverse the order of the vertices of every panel there: normals point into the "
                "water",
            )


def check_edges(panels: Panels, wrong: Wrong) -> None:
    """The error that `wrong` makes where an edge below the water is not one of two panels."""

    def at(edge: tuple[int, int]) -> str:
        return place(panels.vertices[list(edge)].mean(axis=0))

    edges = panels.edges()
    height = panels.vertices[:, 2]
    unshared = [e for e, sides in edges.items() if len(sides) == 1 and min(height[list(e)]) < 0]
    if unshared:
        raise wrong(
            f"the mesh is not watertight: {len(unshared)} edges below the water belong to one "
            f"panel only, the first {at(unshared[0])}",
            "close the holes (only the waterline may be open), or join panels that do not share "
            "their vertices",
        )
    many = [edge for edge, sides in edges.items() if len(sides) > 2]
    if many:
        raise wrong(
            f"more than two panels meet in an edge {at(many[0])}",
            "remove inner walls and doubled panels",
        )
    twisted = [edge for edge, sides in edges.items() if len(sides) == 2 and sum(sides)]
    if twisted:
        raise wrong(
            f"neighbouring panels face opposite ways {at(twisted[0])}",
            "turn the panels so that all normals point into the water",
        )
