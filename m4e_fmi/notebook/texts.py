"""The text that notebooks show of each kind of object: what the program prints of them, mostly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import islice

import numpy as np

from m4e_fmi.analysis import Linearization, Modes
from m4e_fmi.analysis import modes as modes_of
from m4e_fmi.cosim import Kind, Outcome, System
from m4e_fmi.model import Model
from m4e_fmi.report.text.point_text import linear_text
from m4e_fmi.report.text.summaries import ranges, run_summary, simulation_summary
from m4e_fmi.report.text.tables import model_tables
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Series
from m4e_fmi.shown import columns, one_line, span
from m4e_fmi.simulate import Simulation

MOST_ROWS = 200
"""Variables of results that are shown."""


def _model(model: Model) -> str:
    warnings = "".join(f"warning: {one_line(str(warning))}\n" for warning in model.warnings)
    head = f"Model {model.name}: {one_line(model.description)}"
    return f"{head}\n{warnings}\n{model_tables(model)}"


def _system(system: System) -> str:
    times = system.simulation
    rows = [
        (c.name, f"kind {c.source.name}" if isinstance(c.source, Kind) else c.source.path.name,
         ", ".join(f"{name} = {value}" for name, value in c.start.items()))
        for c in system.components
    ]  # fmt: skip
    lines = [
        f"System {system.name}: {one_line(system.description)}",
        f"{times.start_time:g} s to {times.stop_time:g} s in steps of {times.step_size:g} s, "
        f"{times.algorithm}",
        *columns("<<<", ("component", "made from", "start values"), *rows),
    ]
    for title in ("connections", "scenario", "notes"):
        lines += [f"{title}:" for _ in getattr(system, title)][:1]
        lines += [f"  {one}" for one in getattr(system, title)]
    return "\n".join(lines)


def _results(results: Results) -> str:
    head = f"Results of {results.attributes.get('title') or results.path.name}, {results.path}"
    return "\n".join([f"{head}: {span(results.time)}", *_ranges(results.series, results.time)])


def _simulation(simulation: Simulation) -> str:
    shown = {name: simulation[name] for name, one in simulation.variables.items() if not one.local}
    return "\n".join([simulation_summary(simulation), *_ranges(shown, simulation.time)])


def _ranges(series: Mapping[str, Series], time: np.ndarray) -> list[str]:
    """A table of ranges over times (n,) [s]; of what is no number the type alone."""
    rows: list[Sequence[str]] = [("variable", "unit", "min", "mean", "max", "description")]
    for name, one in islice(series.items(), MOST_ROWS):
        has_range = one.recorded.is_real and len(time)
        numbers = [f"{x:.6g}" for x in ranges(one.values, time)] if has_range else ["", "", ""]
        unit = one.unit or one.recorded.type
        rows.append((one_line(name), unit, *numbers, one_line(one.long_name)))
    left = len(series) - MOST_ROWS
    return columns("<<>>><", *rows) + ([f"and {left} more"] if left > 0 else [])


def _outcome(outcome: Outcome) -> str:
    return run_summary(outcome) if outcome.path else repr(outcome)


def _linearization(linear: Linearization) -> str:
    return linear_text(linear, modes_of(linear), title="linear equations")


def _modes(modes: Modes) -> str:
    """Frequency, damping ratio and main coordinate of each mode."""
    rows = [("mode", "frequency [Hz]", "damping ratio [1]", "growth [1/s]", "mostly")]
    for k, value in enumerate(modes.eigenvalues.tolist()):
        shape = zip(np.abs(modes.shapes[:, k]), (v.name for v in modes.coordinates), strict=True)
        main = max(shape, default=(0.0, ""))[1]
        hertz = f"{abs(value) / (2 * np.pi):.6g}" if value.imag else "–"
        ratio = f"{modes.damping_ratios[k]:.5f}".replace("nan", "–")
        rows.append((str(k + 1), hertz, ratio, f"{value.real:.6g}", main))
    return "\n".join(columns(">>>><", *rows))


TEXTS: dict[type, Callable[..., str]] = {
    Model: _model,
    System: _system,
    Results: _results,
    Simulation: _simulation,
    Outcome: _outcome,
    Linearization: _linearization,
    Modes: _modes,
}
"""Kinds of objects, and what makes their texts."""
