"""Components of a system: their sources, start values, steps and processes."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field

from m4e_fmi.cosim.system.simulation import Simulation, Time, fits, misfit, seconds
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Section, rejected
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.files.limits import beyond_limits
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.fmu.kind import FmuKind
from m4e_fmi.shown import short
from m4e_fmi.units import Quantity, Unit

OWN, HERE = "own", "here"
LEAST_MEMORY = 10**8
"""Bytes that a worker needs before it has loaded an FMU."""
KIND_GROUP = "m4e_fmi.fmus"
StartValue = float | int | bool | str | Quantity
Start = Mapping[str, StartValue]


def _positive(given: float | None) -> float | None:
    if given is not None and not (math.isfinite(given) and given > 0):
        raise rejected(f"{given:g} s is no limit", "give a time above 0 s")
    return given


Limit = Annotated[Time | None, AfterValidator(_positive)]


class ProcessLimits(Section):
    """Limits for FMUs in processes of their own.

    `call`: time that each call of the FMU may take [s], or with a unit, 600 s by default.
    `end`: the same for terminating and freeing it, 30 s by default. `memory`: address space of each
    process [bytes], 100 MB at least; no limit by default.
    """

    call: Limit = None
    end: Limit = None
    memory: Annotated[int | None, Field(ge=LEAST_MEMORY)] = None

    def __bool__(self) -> bool:
        return self != ProcessLimits()


@dataclass(frozen=True)
class Processes:
    """Conditions for all FMUs in processes of their own: `limits`, and what they `keep`.

    `keep` are the names of variables of the environment that they get.
    """

    limits: ProcessLimits = field(default_factory=ProcessLimits)
    keep: tuple[str, ...] = ()

    @property
    def host(self) -> Host:
        """The conditions for each of them."""
        return Host(**self.limits.model_dump(exclude_none=True), keep=self.keep)


@dataclass(frozen=True)
class FmuFile:
    """A component that exists as an FMU: the file `path`, or `member` of that archive."""

    path: Path
    member: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", as_path(self.path))


@dataclass(frozen=True)
class ModelFile:
    """A component to be built from a multibody model (`*.model.yaml`)."""

    path: Path

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", as_path(self.path))


@short
@dataclass(frozen=True)
class Kind:
    """A component to be built by the entry point `name` of the group `m4e_fmi.fmus`.

    `config` is an instance of its `FmuKind.config`.
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
    every m-th. None leaves it to the algorithm.

    `process` is "own" for an FMU that runs in a process of its own, "here" for one in this process;
    None leaves it to where the FMU was built.

    `dependencies` names, for some outputs, the inputs that they depend on within an instant, in
    place of what the FMU declares. InputError for another `process`.
    """

    name: str
    source: Source
    start: Start = field(default_factory=dict)
    units: Mapping[str, Unit] = field(default_factory=dict)
    step_size: float | str | None = None
    dependencies: Mapping[str, Sequence[str]] = field(default_factory=dict)
    process: str | None = None

    def __post_init__(self) -> None:
        if self.process not in (None, OWN, HERE):
            message = f"component {self.name!r}: process {self.process!r} is unknown"
            raise InputError.single(message, f"give {OWN!r} or {HERE!r}, or nothing")

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
    return _kinds(tuple(sys.path))


@lru_cache(maxsize=1)
def _kinds(_: tuple[str, ...]) -> Mapping[str, EntryPoint]:
    """Of the packages in these folders: all of them are read for it."""
    return {point.name: point for point in entry_points(group=KIND_GROUP)}


def kind_of(name: str) -> FmuKind:
    """The kind of this name; ImportError if its package cannot be imported or has none there."""
    point = kinds()[name]
    try:
        found = point.load()
    except AttributeError as error:
        raise ImportError(f"{point.value}: {error}") from error
    if not isinstance(found, FmuKind):
        raise ImportError(f"{point.value} is a {type(found).__name__}, not an FmuKind")
    return found


Answer = TypeVar("Answer")


def answers(
    components: Sequence[Component],
    descriptions: Mapping[str, Description],
    question: Callable[[FmuKind], Callable[..., Iterable[Answer]]],
    *asked: object,
) -> Iterator[Answer]:
    """Answers of the kinds of these components to a `question`, one of their functions.

    It gets what is `asked`, once for all kinds that have the same. An FMU that was built here may
    be of any kind: with one, all that are installed answer.
    """
    names = {c.source.name for c in components if isinstance(c.source, Kind)}
    found = [kind_of(name) for name in sorted(names)]
    if any(isinstance(c.source, FmuFile) and descriptions[c.name].is_own for c in components):
        for name in sorted(kinds().keys() - names):
            with suppress(ImportError):  # of others, which the system does not use
                found.append(kind_of(name))
    for function in dict.fromkeys(map(question, found)):
        yield from function(*asked)


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
        if name not in found and not fits(step, simulation.step):
            found[name] = misfit(step, simulation.step)
    return [
        Problem(
            f"component {c.name!r}: {found[c.name].message}",
            found[c.name].remedy,
            keys=("components", c.name, "step_size"),
        )
        for c in components
        if c.name in found
    ]
