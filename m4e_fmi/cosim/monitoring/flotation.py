"""Floating bodies at the start of a run: weight against buoyancy, pose against reference pose.

A connector with a parameter `buoyancy_force_z` is that of a floating body in water: its inputs'
start values are the pose that its coefficients are for, and the parameter is what the still water
carries there. The body itself is in another FMU, which tells its
vertical acceleration a = (f − w)/m: f is the force of the water, m = 1/(∂a/∂f) the mass that it has
to move (added mass and whatever hangs on the body included), and w the load that it has to carry:
weight and all other forces. So w = f − m a. At the start, w is compared with the buoyancy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from m4e_fmi.cosim.connections.connect import Link, Port, Wiring
from m4e_fmi.cosim.exchange.network import Network

BUOYANCY = ".buoyancy_force_z"
OTHERS = ("z", "theta", "force_z", "neutral_mass")
"""Variables of such a connector, besides."""
UNBALANCED = 0.01
"""Share of the buoyancy by which the load may differ from it before that is told."""
SHARE_OF_DRAFT = 0.01
"""Displacement at the start that is told, over the mean draft."""
WATER = 1e3
"""Density [kg/m3], near enough for the size of a body by the mass that it displaces."""
TILT = math.radians(1.0)
"""Angle [rad] at the start that is told."""
HELD = 2.0
"""Mass to be moved over that of the body, neutral and with added mass, from which on a joint or
another body holds it: then that carries the weight."""


def start_warnings(network: Network, wiring: Wiring) -> tuple[str, ...]:
    """What seems wrong with the floating bodies of a network at its start; a line each."""
    sources = {link.target: link for link in wiring.links}
    found = []
    for component, instance in network.instances.items():
        known = instance.description.variables
        for name in known:
            body = name.removesuffix(BUOYANCY)
            link = sources.get(Port(component, f"{body}.z"))
            if body == name or link is None:
                continue
            if all(f"{body}.{other}" in known for other in OTHERS):
                found += _pose(network, component, body)
                found += _balance(network, link, body, sources)
    return tuple(found)


def _pose(network: Network, component: str, body: str) -> Iterator[str]:
    """The start pose, where it is another than the one that the coefficients are for."""
    variables = network.instances[component].description.variables
    for symbol in ("z", "theta"):
        variable = variables[f"{body}.{symbol}"]
        now, meant = network.read(f"{component}.{body}.{symbol}"), float(variable.start or 0.0)
        limit = TILT if symbol == "theta" else SHARE_OF_DRAFT * _draft(network, component, body)
        if abs(now - meant) > limit:
            yield (
                f"{component}.{body}.{symbol} starts at {now:.4g} {variable.unit}, coefficients "
                f"are for {meant:.4g} {variable.unit}: right for a release, else make start and "
                "center_of_gravity agree"
            )


def _balance(network: Network, link: Link, body: str, sources: dict[Port, Link]) -> Iterator[str]:
    """The vertical load at the start, where the still water carries something else."""
    water, source = link.target.component, link.source
    instance = network.instances[source.component]
    described = instance.description
    base = source.variable.removesuffix(".z")
    force, acceleration = f"{base}.force_z", f"{base}.az"
    given = sources.get(Port(source.component, force))
    if not described.directional_derivatives or acceleration not in described.variables:
        return
    if given is None or given.source != Port(water, f"{body}.force_z"):
        return
    mobility = instance.directional_derivative(acceleration, force)
    neutral = network.read(f"{water}.{body}.neutral_mass")
    if mobility * HELD * (neutral + _added_mass(network, water, body)) <= 1.0:
        return
    buoyancy = network.read(f"{water}.{body}{BUOYANCY}")
    load = (
        network.read(str(given.source))
        - network.read(f"{source.component}.{acceleration}") / mobility
    )
    if abs(load - buoyancy) <= UNBALANCED * abs(buoyancy):
        return
    stiffness = _stiffness(network, water, body)
    settles = ""
    if stiffness > 0:
        way = (buoyancy - load) / stiffness
        settles = f": it {'rises' if way > 0 else 'sinks'} by {abs(way):.3g} m from there"
    yield (
        f"{source.component}.{base}: weight and connected forces are {load / 1e3:.5g} kN at the "
        f"start, the still water carries {buoyancy / 1e3:.5g} kN in the pose that the coefficients "
        f"are for{settles}; if it shall float there, "
        + _remedy(network, f"{water}.{body}", f"{source.component}.{base}", 1.0 - load / buoyancy)
    )


def _remedy(network: Network, hull: str, body: str, missing: float) -> str:
    """The mass with which a body is in balance; `missing` is the load's lack, over the buoyancy."""
    neutral = network.read(f"{hull}.neutral_mass")
    component, _, base = body.partition(".")
    wanted = f"{base}.neutral_mass"
    if wanted not in network.instances[component].description.variables:
        return (
            f"say 'mass: neutral' in its model: {hull}.neutral_mass ({neutral:.6g} kg) is its mass"
        )
    sign, change = "+-"[missing < 0], abs(missing) * neutral
    return (
        f"its neutral mass ({neutral:.6g} kg) leaves out the other forces: "
        f"'{hull}.neutral_mass {sign} {change:.6g} -> {body}.neutral_mass' includes them"
    )


def _draft(network: Network, component: str, body: str) -> float:
    """Mean draft [m]: displaced volume over waterplane.

    Of a submerged body, which has no waterplane, the side of the cube that it displaces.
    """
    stiffness = _stiffness(network, component, body)
    if stiffness > 0:
        return network.read(f"{component}.{body}{BUOYANCY}") / stiffness
    return math.cbrt(network.read(f"{component}.{body}.neutral_mass") / WATER)


def _added_mass(network: Network, component: str, body: str) -> float:
    """That of the body in heave at infinite frequency [kg]; 0 if there is none."""
    known = network.instances[component].description.variables
    bodies = [name.removesuffix(BUOYANCY) for name in known if name.endswith(BUOYANCY)]
    heave = 3 * bodies.index(body) + 2
    name = f"added_mass[{heave},{heave}]"
    return network.read(f"{component}.{name}") if name in known else 0.0


def _stiffness(network: Network, component: str, body: str) -> float:
    """Hydrostatic stiffness in heave [N/m]; 0 if there is none."""
    name = f"{body}.hydrostatic_stiffness[2,2]"
    if name not in network.instances[component].description.variables:
        return 0.0
    return network.read(f"{component}.{name}")
