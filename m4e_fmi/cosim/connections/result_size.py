"""Size of the results of a run, and thinning of rows where it is too large."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import ceil

from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.cosim.connections.recorded_variables import chosen
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND, Simulation
from m4e_fmi.fmu.importer.reading import Description

LARGE = 1e9
"""Bytes of results above which their size is noted before the run; the aim where they are HUGE."""
HUGE = 2e9
"""Bytes of results above which not every step is a row, unless `output_interval` says so."""


@dataclass(frozen=True)
class Volume:
    """`rows` of `values` each, including the time; a lower bound if the steps are `adaptive`."""

    rows: int
    values: int
    adaptive: bool

    @property
    def size(self) -> int:
        """Bytes."""
        return 8 * self.rows * self.values

    def __str__(self) -> str:
        least = "at least " if self.adaptive else ""
        return f"{least}{self.rows:,} rows of {self.values:,} values, {size_text(self.size)}"


def volume(
    simulation: Simulation,
    descriptions: Mapping[str, Description],
    variables: Sequence[str] = (),
    connected: Iterable[Port] = (),
) -> Volume:
    """The size of the results of a run that records `variables` (see `chosen`)."""
    values = 1 + sum(map(len, chosen(descriptions, variables, connected).values()))
    interval = simulation.output_interval
    span = simulation.stop_time - simulation.start_time
    rows = ceil(span / (interval or simulation.step_size)) + 1
    adaptive = interval is None and simulation.coupling_tolerance is not None
    return Volume(rows, values, adaptive)


def thinned(
    simulation: Simulation,
    descriptions: Mapping[str, Description],
    variables: Sequence[str] = (),
    connected: Iterable[Port] = (),
) -> tuple[Simulation, str]:
    """The simulation, with an output interval if results would be HUGE without, and a note.

    The note is empty for results that are not LARGE. Adaptive steps are left as they are: they end
    where rows are due.
    """
    whole = volume(simulation, descriptions, variables, connected)
    if whole.size <= LARGE:
        return simulation, ""
    remedy = "a longer output_interval, or fewer --variables, make them smaller"
    if whole.size <= HUGE or whole.adaptive or simulation.output_interval:
        return simulation, f"results: {whole}; {remedy}"
    multiples = (factor * 10**power for power in count() for factor in (1, 2, 5))
    row, steps = 8 * whole.values, whole.rows - 1
    every = next(n for n in multiples if row * (ceil(steps / n) + 1) <= LARGE)
    fewer = replace(simulation, output_interval=every * simulation.step_ns / NS_PER_SECOND)
    size = volume(fewer, descriptions, variables, connected).size
    return fewer, (
        f"results of every step would be {whole.rows:,} rows, {size_text(whole.size)}: a row is "
        f"written every {every} steps, {size_text(size)}; "
        f"output_interval: {fewer.output_interval:g} does the same, "
        f"output_interval: {simulation.step_size:g} writes every step"
    )


def size_text(size: float) -> str:
    """A number of bytes with its unit, as ``"1.5 GB"``."""
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:,.1f} GB"
