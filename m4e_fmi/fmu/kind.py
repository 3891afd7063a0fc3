"""`FmuKind`: how the components of one kind are checked, built and looked at (docs/adapters.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from m4e_fmi.errors import Problem

Function = Callable[..., Any]


def _nothing(*_: object, **__: object) -> None:
    """No answer."""


def _none(*_: object) -> tuple[()]:
    """No problem, or no warning."""
    return ()


def _same(config: object, start: object) -> tuple[object, object]:
    """Both as they are."""
    return config, start


@dataclass(frozen=True)
class OutputsAtRest:
    """Outputs at rest by name, and their derivatives by input and output, in the FMU's units.

    `warnings` are those of the FMU at a start there.
    """

    values: Mapping[str, float]
    slopes: Mapping[str, Mapping[str, float]]
    warnings: Iterable[str] = ()


@dataclass(frozen=True)
class FmuKind:
    """A kind of component: an entry point of the group `m4e_fmi.fmus` leads to one.

    `config` is the class of its keys in a system file, a `files.document.Section`; all functions
    get an instance of it, and the `folder` to which files in it are relative. Only `build` is
    needed: ``build(config, *, name, folder, progress)`` gives the source of the FMU of the
    component `name`, a Program or a PythonSource; `progress` takes lines of text. Where that
    `takes_long`, ``outline(config, *, folder)`` gives the same with all variables, but no long
    computation, within a second; None if they are not known yet. Both raise InputError with all
    that is wrong.

    ``scene(config, *, folder, values)`` is what an animation shows (`report.animation.shown.Shown`)
    for `values` of the parameters at the start. ``response(config, *, name, folder, highest,
    progress)`` gives the program with the forces of its surroundings as inputs, and what these are
    up to the angular frequency `highest` [rad/s] (`analysis.response.WaveForces`).
    ``at_rest(config, start)`` gives both without what moves by itself; `start` are start values.
    ``statics(config, *, folder)`` gives a function from the values of all Real inputs and
    parameters to `OutputsAtRest`, in place of steps of an FMU until it rests; None, as the function
    may return, where only the FMU can tell.

    ``problems(system, variables, links)`` are errors of the connections of a system with such a
    component, ``doubts(system, descriptions, wiring)`` warnings of what is known before the run,
    and ``doubts_at_start(system, descriptions, wiring, start)`` those that need the values at the
    start. Each is asked once for a system, also if several of its kinds have it.

    The rest is for kinds in water: ``coefficients(config, *, name, folder, progress)`` are their
    hydrodynamic data, ``config_of_file(path, *, progress, depth)`` the configuration for a file of
    these, and ``refinement(config, *, folder, progress)`` a convergence study as text and JSON.
    ``mooring(config, *, title, folder, given, about, directions, moved)`` are mooring lines at rest
    (`analysis.mooring_data.MooringData`) with the inputs `given`; `about` [m] is the point of their
    stiffness, None a default, `directions` [rad] are those of offsets, `moved` names the fairleads
    that move, none: all.
    """

    config: type
    build: Function
    takes_long: bool = False
    outline: Function = _nothing
    scene: Function = _nothing
    response: Function = _nothing
    at_rest: Function = _same
    statics: Function = _nothing
    problems: Callable[..., Iterable[Problem]] = _none
    doubts: Callable[..., Iterable[str]] = _none
    doubts_at_start: Callable[..., Iterable[str]] = _none
    coefficients: Function | None = None
    config_of_file: Function | None = None
    refinement: Function | None = None
    mooring: Function | None = None
