"""What a person wants to know first, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.cosim.results import Results
from m4e_fmi.report.panels import panels

if TYPE_CHECKING:
    from m4e_fmi.cosim import Outcome
    from m4e_fmi.simulate import Simulation


def run_summary(outcome: Outcome) -> str:
    """Power, extremes, steps, time and energy balance of a run that wrote results."""
    loaded = outcome.results()
    settings = outcome.prepared.system.simulation
    span = float(loaded.time[-1] - loaded.time[0])
    factor = span / outcome.wall_time if outcome.wall_time else float("inf")
    lines = [
        f"simulated {span:g} s in {outcome.wall_time:.1f} s ({factor:.1f} × real time): "
        f"{outcome.steps} steps of {settings.step_size:g} s, {settings.algorithm}",
        *_extremes(loaded),
    ]
    if outcome.energy:
        lines += ["energy over the connections: given by the force, received by the body"]
        width = max(len(bond.connection) for bond in outcome.energy)
        lines += [
            f"  {bond.connection:<{width}}  {bond.given / 1e3:12.3f} kJ  "
            f"{bond.received / 1e3:12.3f} kJ  difference {100 * bond.relative:+.4f} %"
            for bond in outcome.energy
        ]
    return "\n".join(lines)


def _extremes(results: Results) -> list[str]:
    series = {
        f"{component}.{name}": one
        for component, members in results.components.items()
        for name, one in members.items()
    }
    lines = []
    for panel in panels(series):
        for name, one in panel.series.items():
            values = panel.scale * one.values
            low, mean, high = np.min(values), np.mean(values), np.max(values)
            lines.append(
                f"  {name:<36} min {low:10.3f}  mean {mean:10.3f}  max {high:10.3f}  {panel.unit}"
            )
    return lines


def simulation_summary(simulation: Simulation) -> str:
    """Steps, time and final state of an in-process simulation."""
    factor = simulation.time[-1] / simulation.wall_time
    lines = [
        f"{simulation.program.name}: {simulation.time[-1]:g} s in {simulation.wall_time:.2f} s "
        f"({factor:.0f} × real time), {simulation.accepted} steps, {simulation.rejected} rejected, "
        f"{simulation.evaluations} evaluations",
        "state at the end:",
    ]
    lines += [
        f"  {state.name:<32} {simulation[state.name][-1]: .9g} {state.unit}"
        for state in simulation.program.states
    ]
    energy = simulation.values.get("energy.total")
    if energy is not None:
        lines.append(f"total energy {energy[0]:.6g} J at the start, {energy[-1]:.6g} J at the end")
    return "\n".join(lines)
