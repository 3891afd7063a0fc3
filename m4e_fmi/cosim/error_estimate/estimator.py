"""Interface of an online estimate of the coupling error, and the estimator that a run uses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.report import ONE_LENGTH, Spans, monitored_places
from m4e_fmi.cosim.error_estimate.shadow_run import ShadowRun
from m4e_fmi.cosim.error_estimate.step_doubling import StepDoublingEstimator
from m4e_fmi.cosim.exchange.network import HALF, TWICE, Change, Network
from m4e_fmi.cosim.stepping.algorithm import Algorithm
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.time_loop.time_loop import Watcher
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import Description


class ErrorEstimator(Watcher, Protocol):
    """An estimate of the coupling error while a run goes on.

    `longer` is that of `CouplingErrorReport`.
    """

    longer: Mapping[str, str]

    @property
    def failure(self) -> str:
        """The reason why nothing is known; empty if something is."""
        ...

    def changed(self, changes: Sequence[Change]) -> None:
        """Account for values that were set at the present point, and exchanged."""
        ...

    def finish(self) -> None:
        """Evaluate the steps up to the present point."""
        ...

    def errors(self, *, halved: bool = False) -> np.ndarray:
        """Largest known errors (n,) of the outputs, in their units, or those at half the step."""
        ...

    def leaps(self) -> np.ndarray:
        """Largest known changes (n,) of the outputs within one step, in their units."""
        ...

    def ranges(self) -> np.ndarray:
        """Ranges (n,) of the outputs, in their units."""
        ...

    def coverage(self) -> Coverage:
        """The parts of the run that were repeated."""
        ...


def without_rollback(descriptions: Mapping[str, Description]) -> list[str]:
    """Names of the components that cannot go back."""
    return [name for name, d in descriptions.items() if not d.saves_state]


def error_estimator(
    network: Network,
    make: Callable[[Network], Algorithm],
    prepared: Prepared,
    second: Callable[[Prepared], Network],
    *,
    order: int,
    changeable: bool,
) -> ErrorEstimator | str:
    """The estimator for a run of `network` by an algorithm of this `order`, or the reason for none.

    `make` makes another algorithm; `second` makes a second network, at the start time. In a
    `changeable` run, values may be set between the steps. With actions of a scenario whose values
    are held within steps, the order is 1.

    A longer step of a component that is not sampled makes an error of first order in its own
    length, not in the system's. A second network at half the step halves that length, too: the
    difference is half of that error, and a larger share of errors of higher order.
    """
    held = bool(network.scenario.held)
    order = 1 if held else order
    lengths, why = _lengths(prepared)
    if not lengths:
        return why
    sources, spans = monitored_places(network), Spans(network)
    fixed = without_rollback(prepared.descriptions)
    halved = prepared.halved if HALF in lengths else {}
    settings = prepared.system.simulation
    other = None
    if fixed or halved:
        try:
            other = second(replace(prepared, rates={**prepared.rates, **halved}))
        except RunError as error:
            if fixed:
                return (
                    f"{' and '.join(fixed)} cannot roll back (canGetAndSetFMUstate), a second set "
                    f"of FMUs fails ({error.message})"
                )
            halved, why = {}, f"a second set of FMUs fails: {error.message}"
    if other is None:
        run = StepDoublingEstimator(
            network,
            make,
            sources,
            lengths,
            order=order,
            spans=spans,
            coarse=_coarse(prepared),
        )
    else:
        single = settings.stop_time - settings.start_time <= settings.step_size
        length = lengths[-1] if halved or changeable or single else lengths[0]
        run = ShadowRun(
            network,
            other,
            make,
            settings,
            sources,
            order=1 if halved else order,
            length=length,
            spans=spans,
        )
        run.switched = held
    run.longer = {n: why if n in prepared.halved else ONE_LENGTH for n in prepared.longer}
    return run


def _lengths(prepared: Prepared) -> tuple[list[float], str]:
    """Usable lengths of steps, over the run's; why there are none, or none of half the length."""
    rates = prepared.rates.items()
    odd = [f"{n} {r}" for n, r in rates if r.is_longer and r.every % 2]
    whole = [f"{n} {r}" for n, r in rates if not r.shortens]
    size = round(prepared.system.simulation.step_size * NS_PER_SECOND)
    if (without_rollback(prepared.descriptions) or prepared.halved) and size % 2:
        whole.append("two sets of FMUs, and steps of an odd number of nanoseconds")
    why = f"there are no steps of half the length: {whole[0]}" if whole else ""
    if odd and whole:
        why = f"steps of twice the length miss points of a component ({odd[0]}), and {why}"
    return [length for length, no in ((TWICE, odd), (HALF, whole)) if not no], why


def _coarse(prepared: Prepared) -> str:
    """The reason why there are no steps of a small part of the length; empty if there are."""
    steps = ((n, d.internal_step) for n, d in prepared.descriptions.items() if d.internal_step)
    own = [f"{name} has internal steps of {step:g} s" for name, step in steps]
    return "; ".join([f"{n} {r}" for n, r in prepared.rates.items() if not r.shortens] or own)
