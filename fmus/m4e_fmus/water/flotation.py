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
from m4e_fmus.water.start_balance import ACCELERATIONS, BodyBalance, balances
from m4e_fmus.water.surroundings import SAME, model_gravity

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
FAR = math.radians(15.0)
"""Trim [rad] whose value linear water does not tell."""
SAME_MASS = 1e-6
"""Relative difference of two masses that is rounding."""
NOISE = 1e-3
"""Metacentric height, over the size of the body, that the panels leave uncertain."""


def flotation(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring, start: AtStart
) -> Iterator[str]:
    """Warnings of the floating bodies of a system at its `start`, one line each."""
    hulls = list(_hulls(start, wiring))
    yield from (line for hull in hulls for line in _pose(hull))
    for balance in balances(start, wiring, hulls):
        if not _is_at_rest(balance):
            component = balance.hulls[0].link.source.component
            yield from _weight(balance, model_gravity(system, descriptions, component))
            yield from _trim(balance)
        yield from _stability(balance)


def _is_at_rest(balance: BodyBalance) -> bool:
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
            remedy = "right for a release, else make start and center_of_gravity agree"
            if symbol == "psi":
                remedy = "right for a release, else make start and heading agree"
            if symbol in ("x", "y"):
                remedy = "make start and center_of_gravity agree, or connect the body that is there"
            yield (
                f"{hull.name}.{symbol} starts at {now:.4g} {variable.unit}, coefficients "
                f"are for {meant:.4g} {variable.unit}: {remedy}"
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


def _weight(balance: BodyBalance, gravity: float | None) -> Iterator[str]:
    """The vertical force that is out of balance at the start, in the reference pose.

    `gravity` [m/s2] is that of the bodies' model, if it is known.
    """
    buoyancy, force = balance.buoyancy, balance.force
    if force is None or abs(force) <= UNBALANCED * abs(buoyancy):
        return
    verb, more = ("rise", "more") if force > 0 else ("sink", "less")
    settles = ""
    if balance.heave_stiffness > 0 and not balance.is_shared:
        way = abs(force) / balance.heave_stiffness
        settles = f": {f'it {verb}s' if balance.is_single else f'they {verb}'} by {way:.3g} m"
    change = force / buoyancy * balance.neutral_mass
    remedy = f"to float there, {abs(change):.6g} kg {more}: change mass, or the connected forces"
    of_water = buoyancy / balance.neutral_mass
    if gravity is not None and not math.isclose(gravity, of_water, rel_tol=SAME):
        remedy = f"make gravity of the model, {gravity:g} m/s2, that of the water, {of_water:.6g}"
    elif -change >= balance.neutral_mass:
        remedy = "the other forces exceed the buoyancy: check their connections and start values"
    elif balance.is_single:
        remedy += f"; {_neutral(balance.hulls[0], change)}"
    whole = _carrying(balance)
    yield (
        f"{_holders(balance)}{f' {whole}' if whole else ''}: weight and connected forces are "
        f"{(buoyancy - force) / 1e3:.5g} kN at the start, the still water carries "
        f"{buoyancy / 1e3:.5g} kN in the pose that the coefficients are for{settles}; {remedy}"
    )


def _neutral(hull: FloatingHull, change: float) -> str:
    """The connection of a neutral mass with which a body that needs a `change` [kg] floats."""
    wanted = f"{hull.holder}.neutral_mass"
    component = hull.link.source.component
    known = hull.network.instances[component].description.variables
    if f"{hull.base}.neutral_mass" not in known:
        return "'mass: neutral' is that of the displaced water, without other forces"
    excess = hull.network.read(wanted) + change - hull.neutral_mass
    given = f"{hull.name}.neutral_mass"
    if abs(excess) > SAME_MASS * hull.neutral_mass:
        given += f" {'+-'[excess < 0]} {abs(excess):.6g}"
    return f"that is '{given} -> {wanted}'"


def _holders(balance: BodyBalance) -> str:
    """The bodies as their component calls them."""
    first, *others = [hull.holder for hull in balance.hulls]
    return " and ".join([first, *(name.partition(".")[2] for name in others)])


def _carrying(balance: BodyBalance) -> str:
    """Names of the bodies that are carried, in words; no text if there are none."""
    names = [name.removeprefix("body.") for name in balance.carried]
    return f"with {', '.join(names)}" if names else ""


def _trim(balance: BodyBalance) -> Iterator[str]:
    """The moment at the start, where the still water does not carry it."""
    moment, stiffness = balance.moment, balance.pitch_stiffness
    if moment is None:
        return
    size = balance.hulls[0].size
    least = UNBALANCED * abs(balance.buoyancy) * size
    stable = stiffness > NOISE * abs(balance.buoyancy) * size
    if abs(moment) <= (TILT * stiffness if stable else least):
        return
    turns = "nothing turns it back"
    if stable:
        angle = abs(moment) / stiffness
        far = angle > FAR
        tilt = balance.hulls[0].plane.tilt
        turns = f"the {tilt} is {'above ' * far}{math.degrees(min(angle, FAR)):.3g} deg"
    about, remedy = "its centre of gravity", "put it on the vertical of the centre of buoyancy"
    if balance.carried:
        remedy = "place what it carries so that all weights balance over the centre of buoyancy"
    if not balance.is_single:
        about, remedy = "the middle of all", "make their masses those of the water they displace"
    yield (
        f"{_holders(balance)}: a moment of {moment / 1e3:.5g} kN.m about {about} is out of balance "
        f"at the start, that of the buoyancy at an arm of {abs(moment / balance.buoyancy):.3g} m: "
        f"{turns}; {remedy}, or balance the moments of the connected forces"
    )


def _stability(balance: BodyBalance) -> Iterator[str]:
    """A free body, or joined ones with all that they carry, that nothing turns back."""
    hull, stiffness = balance.hulls[0], balance.pitch_stiffness
    if balance.moment is None or balance.top_weight is None:
        return
    height = stiffness / balance.buoyancy
    if height < -NOISE * hull.size:
        whole = f"{_carrying(balance)} " if balance.carried else ""
        are, capsize, lower = "it is", "it capsizes", "lower center_of_gravity"
        if not balance.is_single:
            are, capsize = "they are", "they capsize"
        if balance.carried or not balance.is_single:
            lower = "lower the centres of gravity"
        yield (
            f"{_holders(balance)}: {whole}{are} unstable in {hull.plane.turn}, with a stiffness "
            f"of {stiffness:.4g} N.m/rad, weight included (GM = {height:.3g} m): without other "
            f"forces {capsize}: {lower}"
        )
