"""Overview of a prepared system as text: components, connections, delays, loops, loose ends."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from typing import TYPE_CHECKING

from m4e_fmi.cosim.connections.links import Link
from m4e_fmi.cosim.connections.missing.loose_ends import is_idle_load, start_text, unfed
from m4e_fmi.cosim.connections.recording import thinned, volume
from m4e_fmi.cosim.connections.timing import Timing, component_cycles
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.system.system import System

if TYPE_CHECKING:
    from m4e_fmi.cosim.connections.prepared import Prepared


def overview(prepared: Prepared) -> str:
    """Components, connections, loops and unconnected inputs of a prepared system, as text."""
    system, wiring, structure = prepared.system, prepared.wiring, prepared.structure
    lines = [f"system {system.name}", "components, in the order they step:"]
    lines += [f"  {name}  {prepared.descriptions[name].path}" for name in structure.execution_order]
    if prepared.rates:
        lines.append("components with their own step size:")
        lines += [f"  {name}  {own}" for name, own in prepared.rates.items()]
    if prepared.hosts:
        lines.append(f"in processes of their own: {', '.join(prepared.hosts)}")
    lines += prepared.notes
    lines += [f"warning: {line}" for line in prepared.warnings]
    lines += ["connections:", *_connections(prepared)]
    cycles = component_cycles(prepared.descriptions, wiring.links)
    if cycles:
        lines.append("components that interact:")
        lines += [
            "  " + ", ".join(n for n in structure.execution_order if n in cycle) for cycle in cycles
        ]
    if structure.loops:
        lines.append("algebraic loops, solved at every communication point:")
        lines += [f"  {' -> '.join(map(str, (*loop, loop[0])))}" for loop in structure.loops]
    if wiring.signals:
        lines += ["signals of buses:", *(f"  {signal}" for signal in wiring.signals)]
    lines.append("unconnected inputs, which keep their start values:")
    lines += _unconnected(prepared) or ["  none"]
    lines.append(_times(system))
    _, note = thinned(system.simulation, prepared.columns)
    lines.append(note or f"results: {volume(system.simulation, prepared.columns)[1]}")
    return "\n".join(lines)


def outline(system: System, waiting: Collection[str]) -> str:
    """The system as its file has it, while the FMUs of the components `waiting` are not built."""
    lines = [f"system {system.name}", "components:"]
    for component in system.components:
        source = component.source
        told = source.name if isinstance(source, Kind) else source.path
        later = "  (not built yet)" if component.name in waiting else ""
        lines.append(f"  {component.name}  {told}{later}")
    lines += ["connections:", *(f"  {text}" for text in system.connections)]
    lines.append(_times(system))
    lines.append(
        f"building {', '.join(waiting)} takes long and is left to `m4e-fmi run`: variables, loops "
        "and what is connected to nothing are shown when that is done"
    )
    return "\n".join(lines)


def _times(system: System) -> str:
    simulation = system.simulation
    times = f"{simulation.start_time:g} s to {simulation.stop_time:g} s"
    return f"{times}, step {simulation.step_size:g} s, {simulation.algorithm}"


def _connections(prepared: Prepared) -> list[str]:
    """Each connection with what it carries, and under it how its inputs follow their sources."""
    timings = prepared.timings
    lines = []
    for index, text in enumerate(prepared.system.connections):
        own = [link for link in prepared.wiring.links if link.connection == index]
        once = [link for link in prepared.wiring.initial_links if link.connection == index]
        count = len(own) + len(once)
        kinds = dict.fromkeys(link.kind for link in (*own, *once) if not link.is_real)
        told = ", ".join([f"{count} variable{'s' * (count != 1)}", *kinds])
        lines.append(f"  {text}  ({told})")
        for timing in Timing:
            late = [link for link in own if timings[link] is timing]
            if late:
                lines.append(f"      {_named(late, len(own))}{timing.value}")
        if once:
            lines.append(f"      {_named(once, count)}transferred once, at initialisation")
        converted = [link for link in (*own, *once) if not link.is_plain]
        if converted:
            lines.append(f"      converted: {', '.join(map(_conversion, converted))}")
    return lines


def _unconnected(prepared: Prepared) -> list[str]:
    """Unconnected inputs with their start values; loads of bodies that are 0, by their number."""
    lines, idle = [], Counter[str]()
    given = {c.name: c.start for c in prepared.system.components}
    free = set(unfed(prepared.system, prepared.wiring))
    for port in prepared.wiring.unconnected:
        if port in free and is_idle_load(port, prepared.descriptions):
            idle[port.component] += 1
            continue
        own = start_text(prepared.descriptions[port.component].variables[port.variable])
        lines.append(f"  {port} = {given[port.component].get(port.variable, own)}")
    return lines + [
        f"  {component}: {count} force{'s' * (count > 1)}, moments or efforts on its bodies, which "
        "are 0"
        for component, count in idle.items()
    ]


def _named(links: list[Link], count: int) -> str:
    """The links by their sources, if they are not all there are."""
    if len(links) == count:
        return ""
    return ", ".join(str(link.source) for link in links) + ": "


def _conversion(link: Link) -> str:
    shift = "" if link.offset == 0.0 else f" {'+-'[link.offset < 0]} {abs(link.offset):g}"
    return f"{link.target} = {link.factor:g} * {link.source}{shift}"
