"""Choice of the variables that a run records."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import ceil

from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND, Simulation
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import TYPES

LARGEST_ARRAY = 9
"""Elements of an array that is recorded if nobody chooses: a vector, or a matrix of three by three.

Scalar variables of FMI 1.0 and 2.0 that are called y[1], y[2], … are an array.
"""


def chosen(
    descriptions: Mapping[str, Description],
    patterns: Sequence[str],
    connected: Iterable[Port] = (),
) -> dict[str, list[Variable]]:
    """The variables to be recorded, by component, of all types but Binary.

    Without patterns these are all outputs but arrays of more than `LARGEST_ARRAY` elements of which
    none is `connected`. A pattern is ``component.variable``, where ``*`` stands for anything. With
    ``*`` it chooses among the outputs, elements of arrays included; without, it may name any
    variable, or an array. InputError for patterns that match nothing.
    """
    if not patterns:
        arrays = {(port.component, array_of(port.variable)) for port in connected}
        result = {}
        for name, description in descriptions.items():
            outputs = _outputs(description)
            sizes = Counter(array_of(v.name) for v in outputs)
            result[name] = [
                v
                for v in outputs
                if sizes[of := array_of(v.name)] <= LARGEST_ARRAY or (name, of) in arrays
            ]
        return result
    found: dict[str, dict[str, Variable]] = {name: {} for name in descriptions}
    problems = []
    for pattern in patterns:
        matches = _matches(descriptions, pattern)
        for component, variable in matches:
            found[component][variable.name] = variable
        if not matches:
            known = [f"{c}.{v.name}" for c, d in descriptions.items() for v in _outputs(d)]
            problems.append(
                Problem(f"no output is called {pattern!r}", suggestion(pattern, known, "outputs"))
            )
    if problems:
        raise InputError(problems)
    return {name: list(members.values()) for name, members in found.items()}


def array_of(name: str) -> str:
    """The name of the array of an element; of a scalar, its own name."""
    return name.rpartition("[")[0] if name.endswith("]") else name


def _outputs(description: Description) -> list[Variable]:
    return [v for v in description.of_causality("output") if v.type in TYPES]


def _matches(descriptions: Mapping[str, Description], pattern: str) -> list[tuple[str, Variable]]:
    exact, _, name = pattern.partition(".")
    if exact in descriptions:
        variables = descriptions[exact].variables
        named = [variables[name]] if name in variables else []
        named = named or [v for v in variables.values() if v.name.endswith("]")]
        found = [(exact, v) for v in named if name in (v.name, array_of(v.name))]
        if found:
            return [(c, v) for c, v in found if v.type in TYPES]
    # brackets are part of names
    expression = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return [
        (component, v)
        for component, description in descriptions.items()
        for v in _outputs(description)
        if expression.fullmatch(f"{component}.{v.name}")
    ]


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
