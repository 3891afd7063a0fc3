"""The sheet of a system."""

from __future__ import annotations

from m4e_fmi.cosim import Component, Kind, System
from m4e_fmi.notebook.sheet import Sheet


def system_sheet(system: System) -> Sheet:
    """Tables of components and connections, the simulation."""
    times = system.simulation
    sheet = Sheet(
        f"System {system.name}",
        system.description,
        f"{times.start_time:g} s to {times.stop_time:g} s in steps of {times.step_size:g} s",
        times.algorithm,
    )
    sheet.table(
        ("component", "made from", "step", "start values"),
        [(c.name, _source(c), c.step_size or "", _started(c)) for c in system.components],
    )
    sheet.lines("connections", system.connections)
    sheet.lines("scenario", system.scenario)
    sheet.lines("notes", system.notes)
    return sheet


def _source(component: Component) -> str:
    source = component.source
    return f"kind {source.name}" if isinstance(source, Kind) else source.path.name


def _started(component: Component) -> str:
    return ", ".join(f"{name} = {value}" for name, value in component.start.items())
