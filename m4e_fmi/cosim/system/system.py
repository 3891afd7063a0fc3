"""What is coupled and how: components, connections, simulation; from a file or from Python."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

from pydantic import BeforeValidator

from m4e_fmi.cosim.system.component_step import TIMES, common_step, seconds, time_of
from m4e_fmi.cosim.system.origins import Origin, ParameterSet
from m4e_fmi.coupling_algorithms import DEFAULT_ALGORITHM, algorithm_names
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Document, Location, Section, rejected
from m4e_fmi.shown import listing, short
from m4e_fmi.units import Quantity, Unit

KIND_GROUP = "m4e_fmi.fmus"
NS_PER_SECOND = 1_000_000_000
"""Nanoseconds, in which the master counts time."""
LONGEST = 4e9
"""Seconds that fit twice into 63 bits of them, more than a hundred years."""
TICK = Fraction(1, NS_PER_SECOND)
"""One of them [s]."""
ODD = 1e-3
"""Nanoseconds by which a time may miss whole ones for being a number in floating point."""

TOLERANCES = ("tolerance", "coupling_tolerance")
NUMBERS = ("stop_time", "step_size", "output_interval", "start_time", *TOLERANCES)
"""Settings of a simulation that are numbers."""

Start = Mapping[str, float | int | bool | str | Quantity]


@dataclass(frozen=True)
class FmuFile:
    """A component that is there already as an FMU: the file `path`, or `member` of that archive."""

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

    `dependencies` names, for some outputs, the inputs that they depend on within an instant, in
    place of what the FMU declares.
    """

    name: str
    source: FmuFile | ModelFile | Kind
    start: Start = field(default_factory=dict)
    units: Mapping[str, Unit] = field(default_factory=dict)
    step_size: float | str | None = None
    dependencies: Mapping[str, Sequence[str]] = field(default_factory=dict)

    @property
    def own_step(self) -> Fraction | None:
        """`step_size` [s], if it has one."""
        return None if self.step_size is None else seconds(self.step_size)


@dataclass(frozen=True)
class Simulation:
    """How long and how: all times in seconds.

    A time may be given as a text, ``"10 ms"``. `step_size` is the time between communication
    points; `output_interval`, a multiple of it, the
    time between rows of the results (None: every point). `tolerance` (relative) is handed to the
    FMUs that integrate with error control; None leaves them their own. `coupling_tolerance`
    (relative) makes the steps adaptive, none larger than `step_size`: None keeps them fixed.
    """

    stop_time: float
    step_size: float
    algorithm: str = DEFAULT_ALGORITHM
    output_interval: float | None = None
    start_time: float = 0.0
    tolerance: float | None = None
    coupling_tolerance: float | None = None

    @property
    def step(self) -> Fraction:
        """`step_size` as the master counts it [s]: whole nanoseconds."""
        return Fraction(round(self.step_size * NS_PER_SECOND), NS_PER_SECOND)

    def __post_init__(self) -> None:
        problems = []
        for key in NUMBERS:
            try:
                object.__setattr__(self, key, _setting(key, getattr(self, key)))
            except ValueError as error:
                problems.append(Problem(*error.args))
        if not problems:
            problems = [Problem(text, remedy) for _, text, remedy in simulation_problems(self)]
        if problems:
            raise InputError(problems)


def _setting(key: str, given: Any) -> float | None:
    """A setting as a number; ValueError(message, remedy) if it is none.

    It may be a number of any library, and a time a text as ``"10 ms"``.
    """
    if given is None and key in ("output_interval", *TOLERANCES):
        return None
    if isinstance(given, str) and key not in TOLERANCES:
        try:
            return float(time_of(given))
        except ValueError:
            raise ValueError(f"{key} {given!r} is not a valid duration", TIMES) from None
    if getattr(given, "shape", ()) == () and not isinstance(given, str | bool | None):
        with suppress(TypeError, ValueError):
            return float(given)
    remedy = "1e-6 is usual" if key in TOLERANCES else TIMES
    raise ValueError(f"{key}: expected a number, got {given!r}", remedy)


def _in_seconds(given: Any) -> Any:
    """A time in seconds of a text with a unit; other values as they are."""
    if not isinstance(given, str):
        return given
    try:
        return float(time_of(given))
    except ValueError:
        raise rejected(f"{given!r} is not a valid duration", TIMES) from None


Time = Annotated[float, BeforeValidator(_in_seconds)]
"""A time in seconds, or a text as ``"10 ms"``."""


SETTINGS = tuple(field.name for field in fields(Simulation))


class SimulationSection(Section):
    """A Simulation as files have it."""

    stop_time: Time
    step_size: Time
    algorithm: str = DEFAULT_ALGORITHM
    output_interval: Time | None = None
    start_time: Time = 0.0
    tolerance: float | None = None
    coupling_tolerance: float | None = None


@dataclass(frozen=True)
class System:
    """Components, the connections between them, and the simulation.

    A connection is text: ``a.group <-> b.group`` connects connectors, ``a.variable -> b.variable``
    one variable or all elements of an array, ``a.variable * 2.5 + 1 -> b.variable`` with a factor
    and an offset. `inputs` and `outputs` are the system's own variables by name, and what they
    stand for: the inputs ``component.variable`` that take the value, the output that gives it.
    `buses` are names under which connections meet, with their signals and the units of these.

    `notes` say what reading the file has changed or left out. `folder` is what relative file names
    in the components' configurations refer to; `document` the YAML file it came from, if it did.
    `origins` tell, by ``component.variable`` and by setting, who has given what `changed` has set.
    """

    name: str
    components: tuple[Component, ...]
    connections: tuple[str, ...]
    simulation: Simulation
    description: str = ""
    inputs: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    buses: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    folder: Path = field(default_factory=Path)
    document: Document | None = field(default=None, repr=False, compare=False)
    origins: Mapping[str, Origin] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        found = step_problems(self.components, self.simulation)
        if found:
            raise InputError([self.problem(*problem) for problem in found])

    def changed(self, *, start: Start | None = None, origin: str = "", **simulation: Any) -> System:
        """The same system with other start values and simulation settings.

        `start` maps ``component.variable`` to a value; settings that are None stay as they are.
        `origin` is who gives them, in messages and results, "Python" if it is empty; the values of
        a ParameterSet are from its file. InputError with all components that are not there, and
        settings that do not fit.
        """
        caller = Origin(origin or "Python")
        giver = start.origin if isinstance(start, ParameterSet) else caller
        components = {component.name: component for component in self.components}
        if start is not None and not isinstance(start, Mapping):
            message = f"start: expected values by name, got {type(start).__name__}"
            raise InputError.single(message, "write start={'component.variable': value}")
        problems = [
            caller.problem("", f"unknown setting {key!r}", suggestion(key, SETTINGS, "settings"))
            for key in simulation.keys() - set(SETTINGS)
        ]
        for name, value in (start or {}).items():
            component, _, variable = str(name).partition(".")
            if component not in components or not variable:
                remedy = suggestion(component, components, "components")
                message = f"start value {name!r}: there is no component {component!r}"
                if not variable:
                    message = f"start value {name!r}: expected COMPONENT.VARIABLE"
                problems.append(giver.problem(name, message, remedy))
                continue
            old = components[component]
            components[component] = replace(old, start={**old.start, variable: value})
        given = {k: v for k, v in simulation.items() if v is not None and k in SETTINGS}
        settings = self.simulation
        try:
            settings = replace(settings, **given)
        except InputError as error:
            problems += [caller.problem("", p.message, p.remedy) for p in error.problems]
        if problems:
            raise InputError(problems)
        return replace(
            self,
            components=tuple(components.values()),
            simulation=settings,
            origins={
                **self.origins,
                **dict.fromkeys(start or {}, giver),
                **{name: replace(caller, value=getattr(settings, name)) for name in given},
            },
        )

    def problem(self, location: Location, message: str, remedy: str = "") -> Problem:
        """A problem with the part of the system at `location`, placed where that was given."""
        if location[:1] == ("components",) and location[2:3] == ("start",):
            name = f"{location[1]}.{location[3]}"
            if name in self.origins:
                return self.origins[name].problem(name, message, remedy)
        if self.document is not None:
            return self.document.problem(location, message, remedy)
        return Problem(f"{self.name}: {message}", remedy)

    def located(self, component: str, problem: Problem) -> Problem:
        """A problem with the configuration of a component, placed where its `keys` lead.

        A problem with a file as a whole, as one that is missing, is placed where the file is named.
        """
        if self.document is None:
            return problem
        at: Location = ("components", component)
        keys = problem.keys
        if not keys and problem.file and not problem.line:
            keys = next(self._named(at, Path(problem.file)), ())
        if not keys:
            return problem
        message = f"{problem.message} ({problem.file})" if problem.file else problem.message
        return self.document.problem((*at, *keys), message, problem.remedy)

    def _named(self, at: Location, file: Path) -> Iterator[Location]:
        """Where below `at` the document names a file, relative to its folder."""
        assert self.document is not None
        for keys, text in self.document.texts(at):
            if self.folder / text == file:
                yield (*keys, "@value")

    def __repr__(self) -> str:
        times = self.simulation
        return listing(
            f"System {self.name!r}: {times.start_time:g} s to {times.stop_time:g} s, "
            f"step {times.step_size:g} s, {times.algorithm}",
            components=self.components,
            connections=self.connections,
        )


def kinds() -> dict[str, Any]:
    """Entry points of the kinds of FMU that are installed, by name."""
    return {point.name: point for point in entry_points(group=KIND_GROUP)}


def kind_module(name: str) -> ModuleType:
    """The module behind a kind: it offers `Config` and `make`."""
    return importlib.import_module(kinds()[name].value)


def simulation_problems(
    simulation: Simulation | SimulationSection,
) -> list[tuple[str, str, str]]:
    """(key, message, remedy) for all that is wrong with times and algorithm."""
    found = []
    span = simulation.stop_time - simulation.start_time
    step = simulation.step_size
    if not (math.isfinite(span) and span > 0):
        text = f"stop_time {simulation.stop_time:g} s is not after the start"
        found.append(("stop_time", text, f"start_time is {simulation.start_time:g} s"))
    elif max(abs(simulation.start_time), abs(simulation.stop_time)) > LONGEST:
        text = f"stop_time {simulation.stop_time:g} s: times are counted up to {LONGEST:g} s"
        found.append(("stop_time", text, "shorten the run"))
    if not (math.isfinite(step) and step * NS_PER_SECOND >= 1):
        text = f"step_size {step:g} s: expected 1e-9 s or more"
        found.append(("step_size", text, "give it in seconds, as 0.01, or as '10 ms'"))
    elif span > 0 and step > span:
        text = f"step_size {step:g} s is longer than the run of {span:g} s"
        found.append(("step_size", text, f"take {span:g} s or less, or a longer run"))
    interval = simulation.output_interval
    if interval is not None and not abs(interval) <= LONGEST:
        text = f"output_interval {interval:g} s: expected a multiple of step_size"
        found.append(("output_interval", text, "leave it out for a row after every step"))
    elif interval is not None and step <= LONGEST and step * NS_PER_SECOND >= 1:
        count = round(interval * NS_PER_SECOND) / round(step * NS_PER_SECOND)
        if count < 1 or count != int(count):
            text = f"output_interval {interval:g} s is not a multiple of step_size {step:g} s"
            remedy = f"take {max(1, round(count)) * step:g} s, or leave it out"
            if not is_whole(step):
                text = (
                    f"output_interval {interval:g} s: steps are whole nanoseconds, so that the "
                    f"step_size of {step:.12g} s is one of {round(step * NS_PER_SECOND)} ns"
                )
                nearest = _fitting(step, interval)
                remedy = f"take a step_size of {nearest:.12g} s, or leave output_interval out"
            found.append(("output_interval", text, remedy))
    for key in ("tolerance", "coupling_tolerance"):
        tolerance = getattr(simulation, key)
        if tolerance is not None and not 0 < tolerance < 1:
            text = f"{key} {tolerance:g}: expected a number between 0 and 1"
            found.append((key, text, "1e-6 is usual"))
    if simulation.algorithm not in algorithm_names():
        text = f"unknown algorithm {simulation.algorithm!r}"
        found.append(("algorithm", text, suggestion(simulation.algorithm, algorithm_names())))
    return found


def is_whole(time: float) -> bool:
    """Whether a time [s] is one of whole nanoseconds."""
    return abs(time * NS_PER_SECOND - round(time * NS_PER_SECOND)) < ODD


def _fitting(step: float, interval: float) -> float:
    """A time [s] near `step` of whole nanoseconds, of which `interval` [s] is a multiple."""
    whole, part = round(interval * NS_PER_SECOND), round(step * NS_PER_SECOND)
    count = max(1, round(whole / part))
    near = min(count, part)
    numbers = (n for k in range(near) for n in (near - k, near + k))
    found = next(n for n in numbers if whole % n == 0)
    return (whole // found if near == count else found) / NS_PER_SECOND


def step_problems(
    components: Sequence[Component], simulation: Simulation
) -> list[tuple[Location, str, str]]:
    """(location, message, remedy) for all that is wrong with the components' own steps."""
    found: dict[str, tuple[str, str]] = {}
    steps: dict[str, Fraction] = {}
    for component in components:
        if component.step_size is None:
            continue
        try:
            steps[component.name] = seconds(component.step_size)
        except ValueError as error:
            found[component.name] = error.args
    found |= common_step(simulation.step, steps, TICK)[1]
    return [
        (("components", c.name, "step_size"), f"component {c.name!r}: {message}", remedy)
        for c in components
        if c.name in found
        for message, remedy in [found[c.name]]
    ]
