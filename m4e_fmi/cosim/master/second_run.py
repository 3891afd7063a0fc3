"""The second run of `--check`, at half the step."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.system.component_steps import pace
from m4e_fmi.cosim.system.system import Component
from m4e_fmi.errors import InputError
from m4e_fmi.signals import Terminated


@contextmanager
def second_run(results: Path | None) -> Generator[None]:
    """Ctrl-C and signals get a note that it is not the first run which they end."""
    try:
        yield
    except (KeyboardInterrupt, Terminated) as error:
        error.add_note("this was the second run, at half the step")
        if results:
            error.add_note(f"the results of the first are complete, in {results}")
        raise


def finer(prepared: Prepared) -> Prepared:
    """The same at half the step, which components that make several steps in each halve too.

    Sampled ones keep their step: it is what they are, and not how they are computed. InputError
    for an FMU that makes steps of one size only.
    """
    system = prepared.system
    settings, tolerance = system.simulation, system.simulation.coupling_tolerance
    parts: list[Component] = []
    for part in system.components:
        rate = prepared.rates.get(part.name)
        if rate and not rate.shortens:
            raise InputError.single(
                f"--check runs at half the step, which {part.name} cannot: it {rate}",
                "leave out --check: the error estimate of each run needs no other step size",
            )
        halved = prepared.descriptions[part.name].internal_step is None
        if rate and rate.is_longer:
            halved = part.name in prepared.halved
        if rate and halved and part.step_size is not None:
            part = replace(part, step_size=rate.step / 2)
        parts.append(part)
    simulation = replace(
        settings,
        step_size=settings.step_size / 2,
        output_interval=settings.output_interval or settings.step_size,
        coupling_tolerance=None if tolerance is None else tolerance / 8,
        checkpoint_interval=None,
        checkpoint_wall_interval=None,
    )
    finer = replace(system, components=tuple(parts), simulation=simulation)
    rates = pace(finer, prepared.descriptions)
    return replace(prepared, system=finer, rates=rates)
