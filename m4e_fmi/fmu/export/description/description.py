"""The description of an FMU and its variables, independent of how it is packaged."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from m4e_fmi.shown import listing, short


@short
@dataclass(frozen=True)
class FmuVariable:
    """One scalar variable of an FMU, in FMI 2.0's words.

    `dependencies` names the inputs and states that an output depends on at one moment (None: all);
    `initial_dependencies` names what its initial value depends on (None: all). `kinds` and
    `initial_kinds` say how, in FMI's words, one for each name; None says nothing. What is set
    outside `minimum` … `maximum`, both included, is refused. `nominal` is an order of magnitude.
    """

    name: str
    unit: str
    description: str
    causality: str = "local"
    variability: str = "continuous"
    initial: str | None = None
    start: float | str | None = None
    type: str = "Real"
    dependencies: tuple[str, ...] | None = ()
    initial_dependencies: tuple[str, ...] | None = ()
    kinds: tuple[str, ...] | None = None
    initial_kinds: tuple[str, ...] | None = None
    derivative_of: str | None = None
    display_unit: str | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 1.0


@dataclass(frozen=True)
class ModelDescription:
    """Name, description, variables and default experiment (times in seconds) of an FMU.

    `tolerance` is the relative one of its integrator where an importer gives none.

    The value reference of a variable is its index among the variables of its type. `derivatives`
    names the rates of the states, in the order of the states; empty where they are not all there.
    """

    name: str
    description: str
    variables: tuple[FmuVariable, ...]
    stop_time: float = 10.0
    step_size: float = 0.01
    tolerance: float = 1e-8
    derivatives: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return listing(f"ModelDescription of {self.name!r}", variables=self.variables)


@short
@dataclass(frozen=True)
class PythonSource:
    """A slave in Python: `slave` is "module:Class", found among `modules` (file name → path).

    All modules are packed side by side into one package of a unique name; they import one another
    relatively (``from .slave_base import M4eSlave``). `data` (file name → content) goes there too.
    """

    description: ModelDescription
    slave: str
    modules: dict[str, Path]
    data: dict[str, bytes]
