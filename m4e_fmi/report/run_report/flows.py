"""Power between components, from the record of a run or from the works of a program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.report.run_report.record import FlowEnergy, Record, RecordEnd
from m4e_fmi.report.web.samples import Curve
from m4e_fmi.results.results_file import Results

if TYPE_CHECKING:
    from m4e_fmi.simulate.audit import EnergyAudit

Floats = NDArray[np.float64]
POWERS = "connections"
"""The component under which powers over connections are listed."""
WORK, LOAD, OF_INPUTS, TOTAL = ".work", "load.", "inputs.work", ".energy.total"


@dataclass(frozen=True)
class Flows:
    """Flows for flows.js: `data`, and the powers of connections as further `curves`."""

    data: Mapping[str, object]
    curves: tuple[Curve, ...] = ()


def flows_of(results: Results, record: Record, end: RecordEnd) -> Flows | None:
    """The power flows of results; None if they tell of none."""
    if record.flows:
        return _of_connections(results, record, end)
    works = list(_works(results))
    if not works:
        return None
    rows = "Works are integrated with the motion, under the same error control."
    closes = energy_closes(balance_of(results))
    balance = closes and f"What is stored is kinetic and potential energy; the balance {closes}."
    return Flows({"flows": works, "balance": balance, "rows": rows, "stored": _stored(results)})


def _of_connections(results: Results, record: Record, end: RecordEnd) -> Flows:
    """Flows over the connections, from source to body, with the run's own energies if known."""
    energies: Sequence[FlowEnergy | None] = end.energies
    if len(energies) != len(record.flows):
        energies = [None] * len(record.flows)
    numbers = {name for name, one in results.series.items() if one.recorded.is_real}
    flows, curves, apart = list[dict[str, object]](), list[Curve](), [0.0]
    for flow, own in zip(record.flows, energies, strict=True):
        name = f"power over {flow.connection}"
        ports = [port for product in flow.products for port in (product.force, product.velocity)]
        known = bool(ports) and numbers.issuperset(ports)
        if known:
            power = sum(
                product.factor
                * results[product.force].values.astype(float)
                * results[product.velocity].values.astype(float)
                for product in flow.products
            )
            text = f"Power from {flow.source} into {flow.target}: forces times velocities"
            curves.append(Curve(name, POWERS, flow.connection, "W", text, np.asarray(power, float)))
            if own and own.exchanged > own.noise and np.isfinite(own.exchanged):
                given = float(np.trapezoid(curves[-1].values, results.time))
                apart.append(abs(given - own.given) / own.exchanged)
        added = f" (the sum of {', '.join(flow.adds)})" if flow.adds else ""
        flows.append(
            {
                "name": flow.connection,
                "source": flow.source + added,
                "target": flow.target,
                "power": name if known else "",
                "whole": own.given if own and np.isfinite(own.given) else None,
            }
        )
    rows = (
        "Over the whole run this differs from the run's own integrals at every step by up to "
        f"{100 * max(apart):.2g} % of the energy exchanged."
    )
    if not end.energies:
        rows = ""
    data = {"flows": flows, "balance": _stated(end), "rows": rows, "stored": _stored(results)}
    return Flows(data, tuple(curves))


def _stated(end: RecordEnd) -> str:
    """How well the energies over the connections add up, as the run has stated."""
    if not end.energies:
        return ""
    lost = sum(one.received - one.given for one in end.energies)
    exchanged = sum(one.exchanged for one in end.energies) or 1.0
    return (
        "These are the run's own integrals at every step, given by the force's source; what bodies "
        f"received differs by {100 * lost / exchanged:+.2g} % of the energy exchanged, which the "
        "coupling lost (−) or made (+): Numerics has it for each connection."
    )


def _stored(results: Results) -> dict[str, str]:
    """Variables with the kinetic and potential energy of components and parts, by these."""
    return {
        name.removesuffix(TOTAL): name
        for name, series in results.series.items()
        if name.endswith(TOTAL) and series.unit == "J"
    }


def _works(results: Results) -> Iterator[dict[str, object]]:
    """The works of loads and inputs of a program, each from its load into what moves."""
    for component, members in results.components.items():
        for name, series in members.items():
            if series.unit != "J" or not name.endswith(WORK):
                continue
            owner, _, load = name.removesuffix(WORK).rpartition(LOAD)
            if name.endswith(OF_INPUTS):
                owner, load = name.removesuffix(OF_INPUTS), "inputs"
            elif f"{LOAD}{load}{WORK}" not in name:
                continue
            target = ".".join(filter(None, (component, owner.rstrip("."))))
            yield {
                "name": f"{component}.{name}",
                "source": f"{target}: {load}" if len(results.components) > 1 else load,
                "target": target,
                "energy": f"{component}.{name}",
                "whole": None,
            }


def balance_of(results: Results) -> EnergyAudit | None:
    """The energies and works of a simulation, added up; None of other results."""
    from m4e_fmi.simulate.audit import energy_audit

    if not any(name.endswith(WORK) for name in results.series):
        return None
    try:
        return energy_audit({name: one.values for name, one in results.series.items()})
    except KeyError:  # energies were not recorded
        return None


def energy_closes(audit: EnergyAudit | None) -> str:
    """How well energies and works add up, in words; "" without them."""
    if audit is None:
        return ""
    share = f"{100 * audit.relative:.1e} % of the largest energy exchanged"
    return f"closes to {share}, {audit.scale:.6g} J"
