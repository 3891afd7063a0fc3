"""Loads of the water that count twice, as two components on one body have them."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import permutations

from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Link, Port, Variables
from m4e_fmi.errors import Problem


def double_load_problems(
    system: System, variables: Variables, links: Iterable[Link]
) -> Iterable[Problem]:
    """Bodies on which linear loads act together with the same loads at the true pose.

    That is told of two components which take the height of one body.
    """
    moved: dict[Port, list[Link]] = {}  # to heights that components take, by that of the body
    for link in links:
        if link.source.variable.endswith(".z") and link.target.variable.endswith(".z"):
            moved.setdefault(link.source, []).append(link)
    for source, takers in moved.items():
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
