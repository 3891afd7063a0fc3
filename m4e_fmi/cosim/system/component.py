"""Components of a system: their sources, start values and steps."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from m4e_fmi.cosim.system.component_step import common_step, seconds
from m4e_fmi.cosim.system.processes import Limits, check_process
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Section
from m4e_fmi.files.limits import beyond_limits
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.shown import short
from m4e_fmi.units import Quantity, Unit

KIND_GROUP = "m4e_fmi.fmus"
StartValue = float | int | bool | str | Quantity
Start = Mapping[str, StartValue]


@dataclass(frozen=True)
class FmuFile:
    """A component that exists as an FMU: the file `path`, or `member` of that archive."""

    path: Path
    member: str = ""


@dataclass(frozen=True)
class ModelFile:
    """A component to be built from a multibody model (`*.model.yaml`)."""

    path: Path


@short
@dataclass(frozen=True)
class Kind:
    """A component to be built by the entry point `name` of the group `m4e_fmi.fmus`.

    `config` is an instance of that entry point's `Config`.
    """

    name: str
    config: Section


Source = FmuFile | ModelFile | Kind


@short
@dataclass(frozen=True)
class Component:
    """One FMU of the system.

    `start` holds start values by variable name: in the FMU's unit, or with one of their own (a
    Quantity, or a text as ``"5 mm"``). `units` are those of variables whose FMU gives none.

    `step_size` is the time by which this FMU is stepped: a number of seconds or a text with
    unit (``"1/3 ms"``). If that of the simulation is n times as long, the component makes n
    equal steps in each macro step; if it is m times that of the simulation, it makes one in
    every m-th; else the system makes shorter macro steps that meet its points. None leaves it
    to the algorithm.

    `process` is "own" for an FMU that runs in a process of its own, with `limits`, "here" for one
    in this process; None leaves it to where the FMU was built. Limits ask for a process.

    `dependencies` names, for some outputs, the inputs that they depend on within an instant, in
    place of what the FMU declares.
    """

    name: str
    source: Source
    start: Start = field(default_factory=dict)
    units: Mapping[str, Unit] = field(default_factory=dict)
    step_size: float | str | None = None
    dependencies: Mapping[str, Sequence[str]] = field(default_factory=dict)
    process: str | None = None
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        check_process(self.name, self.process, self.limits)

    def described(self, description: Description) -> Description:
        """The `description` of its FMU, with the units that the system adds."""
        variables = dict(description.variables)
        for name, unit in self.units.items():
            if name in variables and variables[name].dimension is None:
                variables[name] = replace(variables[name], unit=unit.text, dimension=unit)
        return replace(description, variables=variables)

    @property
    def own_step(self) -> Fraction | None:
        """`step_size` [s], None without one; InputError if it is not a valid duration."""
        return None if self.step_size is None else seconds(self.step_size)


def kinds() -> Mapping[str, EntryPoint]:
    """Entry points of the kinds of FMU that are installed, by name."""
    return _kinds(tuple(map(_state, sys.path)))


def _state(folder: str) -> tuple[str, int, int]:
    """A folder that packages may be in, and what changes when one is installed there."""
    try:
        found = os.stat(folder or ".")  # noqa: PTH116  for each look at a kind: Path costs more
    except OSError:
        return folder, 0, 0
    return folder, found.st_ino, found.st_mtime_ns


@lru_cache(maxsize=1)
def _kinds(_: tuple[tuple[str, int, int], ...]) -> Mapping[str, EntryPoint]:
    """Of the packages in folders of this state: all of them are read for it."""
    return {point.name: point for point in entry_points(group=KIND_GROUP)}


def kind_module(name: str) -> ModuleType:
    """The module behind a kind: it offers `Config` and `make`."""
    return importlib.import_module(kinds()[name].value)


def step_problems(components: Sequence[Component], simulation: Simulation) -> list[Problem]:
    """All problems of the components' own steps; `keys` lead to the step in the system."""
    found: dict[str, Problem] = {}
    steps: dict[str, Fraction] = {}
    for component in components:
        try:
            if (step := component.own_step) is not None:
                steps[component.name] = step
        except InputError as error:
            found[component.name] = error.problems[0]
    span = simulation.stop_time - simulation.start_time
    for name, step in steps.items():
        for _, message, remedy in beyond_limits(span, step_size=float(step)):
            found[name] = Problem(message, remedy)
    fitting = {name: step for name, step in steps.items() if name not in found}
    found |= common_step(simulation.step, fitting)[1]
    return [
        Problem(
            f"component {c.name!r}: {found[c.name].message}",
            found[c.name].remedy,
            keys=("components", c.name, "step_size"),
        )
        for c in components
        if c.name in found
    ]
