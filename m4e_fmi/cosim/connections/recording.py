"""Variables that a run records, the size of its results, and rows left out if it is too large."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
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
LARGE = 1e9
"""Bytes of results above which their size is noted before the run; the aim where they are HUGE."""
HUGE = 2e9
"""Bytes of results above which not every step is a row, unless `output_interval` says so."""


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
        arrays = {(port.component, _array_of(port.variable)) for port in connected}
        result = {}
        for name, description in descriptions.items():
            outputs = _outputs(description)
            sizes = Counter(_array_of(v.name) for v in outputs)
            result[name] = [
                v
                for v in outputs
                if sizes[of := _array_of(v.name)] <= LARGEST_ARRAY or (name, of) in arrays
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


def _array_of(name: str) -> str:
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
        found = [(exact, v) for v in named if name in (v.name, _array_of(v.name))]
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


def volume(simulation: Simulation, values: int) -> tuple[int, str]:
    """The number of rows of a run with so many values in each, the time included; and in words.

    It is a lower bound if the steps are adaptive.
    """
    interval = simulation.output_interval
    span = simulation.stop_time - simulation.start_time
    rows = ceil(span / (interval or simulation.step_size)) + 1
    least = "at least " if _ends_anywhere(simulation) else ""
    return rows, f"{least}{rows:,} rows of {values:,} values, {size_text(8 * rows * values)}"


def _ends_anywhere(simulation: Simulation) -> bool:
    """True if steps are adaptive, and each is a row."""
    return simulation.output_interval is None and simulation.coupling_tolerance is not None


def thinned(simulation: Simulation, values: int) -> tuple[Simulation, str]:
    """The simulation, with an output interval if results would be HUGE without, and a note.

    Rows have so many `values`. The note is empty for results that are not LARGE. Adaptive steps are
    left as they are: they end where rows are due.
    """
    rows, text = volume(simulation, values)
    row = 8 * values
    if rows * row <= LARGE:
        return simulation, ""
    remedy = "a longer output_interval, or fewer --variables, make them smaller"
    if rows * row <= HUGE or simulation.output_interval or _ends_anywhere(simulation):
        return simulation, f"results: {text}; {remedy}"
    multiples = (factor * 10**power for power in count() for factor in (1, 2, 5))
    every = next(n for n in multiples if row * (ceil((rows - 1) / n) + 1) <= LARGE)
    fewer = replace(simulation, output_interval=every * simulation.step_ns / NS_PER_SECOND)
    return fewer, (
        f"results of every step would be {rows:,} rows, {size_text(rows * row)}: a row is "
        f"written every {every} steps, {size_text(volume(fewer, values)[0] * row)}; "
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
