"""Systems of a few C models: an oscillator, and any others; their values at all points of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Outcome,
    Prepared,
    Simulation,
    System,
    run,
)

Fmus = Callable[[str], Path]
Starts = Mapping[str, Mapping[str, float | str]]


def system(
    fmus: Fmus,
    components: Mapping[str, str],
    *connections: str,
    start: Starts | None = None,
    simulation: Simulation | None = None,
) -> System:
    parts = tuple(
        Component(name, FmuFile(fmus(model)), (start or {}).get(name, {}))
        for name, model in components.items()
    )
    return System("test", parts, connections, simulation or Simulation(1, 0.1))


def oscillator(fmus: Fmus, simulation: Simulation, options: str = "", of: str = "") -> System:
    """A mass of 1 kg on a spring of 1 N/m, released at rest at x = 1 m: x = cos t.

    FMUs have these `options`, and are `of` a version of FMI, as ``3:``.
    """
    names = {"body": f"{of}mass{options}", "spring": f"{of}spring{options}"}
    start = {"body": {"body.m.x": 1.0}}
    return system(fmus, names, "body.m <-> spring.end", start=start, simulation=simulation)


def observed(
    given: System | Prepared, *names: str, **options: Any
) -> tuple[list[list[Any]], Outcome]:
    """The time and the values of variables at all points of a run, and its outcome.

    `options` are those of `run`.
    """
    found: list[list[Any]] = []

    def observe(time: float, network: Network) -> None:
        found.append([time, *(network.read(name) for name in names)])

    return found, run(given, observers=[observe], **options)


def watched(given: System | Prepared, *names: str, **options: Any) -> list[list[Any]]:
    """The values of variables at all points of a run."""
    return [row[1:] for row in observed(given, *names, certify=False, **options)[0]]
