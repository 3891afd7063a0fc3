"""The coupling errors of a run by a second one at half the step: a reference for the certificate.

Two runs of order p, y at the step H and z at H/2, differ by most of the error of the first:

    error of y = |y − z| · 2^p/(2^p − 1)
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.cosim import CouplingErrorReport, Outcome, Prepared, System, prepare, run
from m4e_fmi.cosim.error.report import ONE_LENGTH, certificate, monitored_places
from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.system.component_steps import pace
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND


class Trace:
    """An observer that keeps the monitored outputs."""

    def __init__(self) -> None:
        self.points: dict[int, np.ndarray] = {}
        self.network: Network | None = None

    def __call__(self, time: float, network: Network) -> None:
        self.network = network
        self.points[round(time * NS_PER_SECOND)] = network.values[monitored_places(network)]


def checked(
    given: System | Prepared, *, build_directory: str | Path = "build", **options: Any
) -> tuple[Outcome, CouplingErrorReport]:
    """The outcome of a run, and its coupling errors by one at half the step.

    Adaptive steps are compared with those at an eighth of the tolerance. `options` are of `run`.
    """
    system = given
    if isinstance(system, System):
        system = prepare(system, build_directory=build_directory)
    observers = options.pop("observers", [])
    coarse, fine = Trace(), Trace()
    outcome = run(system, observers=[*observers, coarse], **options)
    run(_finer(system), certify=False, observers=[fine])
    return outcome, _compared(system, outcome, coarse, fine)


def _finer(prepared: Prepared) -> Prepared:
    """The same at half the step, which components that make several steps in each halve too.

    Sampled ones keep their step: it is what they are, and not how they are computed.
    """
    system, parts = prepared.system, []
    settings, tolerance = system.simulation, system.simulation.coupling_tolerance
    for part in system.components:
        rate = prepared.rates.get(part.name)
        assert rate is None or rate.shortens
        halved = prepared.descriptions[part.name].internal_step is None
        if rate and rate.is_longer:
            halved = part.name in prepared.halved
        own = rate.step / 2 if rate and halved and part.step_size is not None else part.step_size
        parts.append(replace(part, step_size=own))
    simulation = replace(
        settings,
        step_size=settings.step_size / 2,
        output_interval=settings.output_interval or settings.step_size,
        coupling_tolerance=None if tolerance is None else tolerance / 8,
    )
    finer = replace(system, components=tuple(parts), simulation=simulation)
    rates = pace(finer, prepared.descriptions)
    return replace(prepared, system=finer, rates=rates, recorded={})


def _compared(
    prepared: Prepared, outcome: Outcome, coarse: Trace, fine: Trace
) -> CouplingErrorReport:
    """The errors of a run by the traces of it and of the finer one."""
    network, halved = coarse.network, prepared.halved
    assert network is not None
    order = 1 if halved else outcome.order
    common = [time for time in coarse.points if time in fine.points]
    first, second = (np.array([one.points[t] for t in common]) for one in (coarse, fine))
    errors = np.abs(first - second).max(axis=0) * 2.0**order / (2.0**order - 1)
    return certificate(
        network,
        prepared.system.connections,
        errors=errors,
        halved=errors / 2.0**order,
        ranges=np.ptp(second, axis=0),
        leaps=np.abs(np.diff(first, axis=0)).max(axis=0, initial=0.0) if network.sampled else None,
        longer={name: "" if name in halved else ONE_LENGTH for name in prepared.longer},
        adaptive=prepared.system.simulation.coupling_tolerance is not None,
    )
