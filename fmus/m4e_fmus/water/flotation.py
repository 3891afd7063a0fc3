"""Equilibrium of each floating body at the start of a run: weight, buoyancy, trim, stability, pose.

A connector with a parameter `buoyancy_force_z` is that of a floating body in water: its inputs'
start values are the pose that its coefficients are for, and the parameter is what the still water
carries there. The body itself is in another FMU, whose accelerations tell the load that it has to
carry (`start_balance`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Port, Wiring
from m4e_fmi.fmu import Description
from m4e_fmus.water.hulls import BUOYANCY, AtStart, FloatingHull
from m4e_fmus.water.start_balance import ACCELERATIONS, Balance, balances

ANGLES = ("phi", "theta", "psi")
OTHERS = ("x", "z", "theta", "force_z", "neutral_mass")
"""Variables of such a connector, besides."""
UNBALANCED = 0.01
"""Share of the buoyancy by which the load may differ from it before that is told."""
AT_REST = UNBALANCED / 100
"""Acceleration that is none, over gravity: of a body with an added mass of up to 100 masses."""
SHARE_OF_DRAFT = 0.01
"""Displacement at the start that is told, over the mean draft."""
ASIDE = 0.1
"""Distance along x or y at the start that is told, over the size of the body."""
TILT = math.radians(1.0)
"""Angle [rad] at the start, or of the trim, that is told."""
NOISE = 1e-3
"""Metacentric height, over the size of the body, that the panels leave uncertain."""


def flotation(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring, start: AtStart
) -> Iterator[str]:
    """Warnings of the floating bodies of a system at its `start`, one line each."""
    del system, descriptions
    hulls = list(_hulls(start, wiring))
    yield from (line for hull in hulls for line in _pose(hull))
    for balance in balances(start, wiring, hulls):
        if not _is_at_rest(balance):
            yield from _weight(balance)
            yield from _trim(balance)
        yield from _stability(balance)


def _is_at_rest(balance: Balance) -> bool:
    """True if nothing accelerates the bodies at the start, wherever they are."""
    gravity = abs(balance.buoyancy / balance.neutral_mass)
    return all(
        abs(hull.network.read(f"{hull.holder}.{ACCELERATIONS[symbol]}"))
        * (hull.size if symbol.startswith("moment") else 1.0)
        <= AT_REST * gravity
        for hull in balance.hulls
        for symbol in hull.symbols
    )


def _hulls(network: AtStart, wiring: Wiring) -> Iterator[FloatingHull]:
    """The bodies in water that take their motion from a connection."""
    sources = {link.target: link for link in wiring.links}
    for component, instance in network.instances.items():
        known = instance.description.variables
        for name in known:
            body = name.removesuffix(BUOYANCY)
            link = sources.get(Port(component, f"{body}.z"))
            if body == name or link is None:
                continue
            if all(f"{body}.{other}" in known for other in OTHERS):
                yield FloatingHull(network, component, body, link)


def _pose(hull: FloatingHull) -> Iterator[str]:
    """The start pose, where it is another than the one that the coefficients are for."""
    variables = hull.network.instances[hull.component].description.variables
    limits = dict.fromkeys(("x", "y"), ASIDE * hull.size) | {"z": SHARE_OF_DRAFT * hull.draft}
    limits |= dict.fromkeys(ANGLES, TILT)
    for symbol in (symbol for symbol in limits if f"{hull.body}.{symbol}" in variables):
        variable = variables[f"{hull.body}.{symbol}"]
        now = hull.network.read(f"{hull.name}.{symbol}")
        meant = _meant(hull, symbol, now)
        away = now - meant
        if symbol in ANGLES:
            away = math.remainder(away, math.tau)
        if abs(away) > limits[symbol]:
            yield (
                f"{hull.name}.{symbol} starts at {now:.4g} {variable.unit}, coefficients "
                f"are for {meant:.4g} {variable.unit}: right for a release, else make start and "
                f"{'heading' if symbol == 'psi' else 'center_of_gravity'} agree"
            )


def _meant(hull: FloatingHull, symbol: str, now: float) -> float:
    """Where the coefficients are for: the start value, turned with the heading if that is set."""
    variables = hull.network.instances[hull.component].description.variables
    if symbol == "psi" and "heading" in variables:
        return hull.heading
    if symbol in ("x", "y") and f"{hull.body}.sway" in variables:
        surge, sway = (hull.network.read(f"{hull.name}.{name}") for name in ("surge", "sway"))
        c, s = math.cos(hull.heading), math.sin(hull.heading)
        return now - (c * surge - s * sway if symbol == "x" else s * surge + c * sway)
    return float(variables[f"{hull.body}.{symbol}"].start or 0.0)


def _weight(balance: Balance) -> Iterator[str]:
    """The vertical force that is out of balance at the start, in the reference pose."""
    buoyancy, force = balance.buoyancy, balance.force
    if force is None or abs(force) <= UNBALANCED * abs(buoyancy):
        return
    change = force / buoyancy * balance.neutral_mass
    remedy = (
        f"to float there, {abs(change):.6g} kg {'more' if force > 0 else 'less'}: change mass, or "
        "the connected forces"
    )
    hull = balance.hulls[0]
    wanted = f"{hull.holder}.neutral_mass"
    known = hull.network.instances[hull.link.source.component].description.variables
    if len(balance.hulls) == 1 and f"{hull.base}.neutral_mass" in known:
        excess = hull.network.read(wanted) + change - hull.neutral_mass
        sign = "+-"[excess < 0]
        remedy += f"; that is '{hull.name}.neutral_mass {sign} {abs(excess):.6g} -> {wanted}'"
    if -change >= balance.neutral_mass:
        remedy = "the other forces exceed the buoyancy: check their connections and start values"
    yield (
        f"{_holders(balance)}: weight and connected forces are {(buoyancy - force) / 1e3:.5g} kN "
        f"at the start, the still water carries {buoyancy / 1e3:.5g} kN in the pose that the "
        f"coefficients are for; {remedy}"
    )


def _holders(balance: Balance) -> str:
    """The bodies as their component calls them."""
    first, *others = [hull.holder for hull in balance.hulls]
    return " and ".join([first, *(name.partition(".")[2] for name in others)])


def _trim(balance: Balance) -> Iterator[str]:
    """The moment at the start, where the still water does not carry it."""
    moment, hull = balance.moment, balance.hulls[0]
    if moment is None:
        return
    least, tilt = UNBALANCED * abs(balance.buoyancy) * hull.size, ""
    if balance.is_alone and hull.turn_stiffness > NOISE * abs(balance.buoyancy) * hull.size:
        least = TILT * hull.turn_stiffness
        angle = math.degrees(abs(moment) / hull.turn_stiffness)
        tilt = f": the {hull.plane.tilt} is {angle:.3g} deg"
    if abs(moment) <= least:
        return
    about = "its centre of gravity" if len(balance.hulls) == 1 else "the middle of all"
    yield (
        f"{_holders(balance)}: a moment of {moment / 1e3:.5g} kN.m about {about} is out of balance "
        f"at the start, that of the buoyancy at an arm of {abs(moment / balance.buoyancy):.3g} m"
        f"{tilt}; put the centre of all masses on the vertical of the centre of buoyancy, or "
        "balance the moments of the connected forces"
    )


def _stability(balance: Balance) -> Iterator[str]:
    """A free body without others on it that nothing turns back."""
    hull = balance.hulls[0]
    if not balance.is_alone or balance.moment is None:
        return
    height = hull.turn_stiffness / balance.buoyancy
    if height < -NOISE * hull.size:
        yield (
            f"{hull.holder}: it is unstable in {hull.plane.turn}, with a stiffness of "
            f"{hull.turn_stiffness:.4g} N.m/rad, weight included (GM = {height:.3g} m): without "
            "other forces it capsizes: lower center_of_gravity"
        )
