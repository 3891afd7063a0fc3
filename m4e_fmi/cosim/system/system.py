"""`System`: components, connections, simulation and scenario, from a file or written in Python."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, model_validator

from m4e_fmi.cosim.system.component import Component, Processes, Start, StartValue, step_problems
from m4e_fmi.cosim.system.simulation import SETTINGS, Simulation, Time
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Document, Location, Section, rejected
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.files.limits import LONGEST_RUN
from m4e_fmi.shown import listing

Amount = float | str
"""A number in the unit of its signal, or a text with a unit of its own: ``"2 cm"``."""
KINDS = ("set", "ramp", "freeze", "offset", "replace")
"""The kinds of actions."""


Names = Annotated[tuple[str, ...], BeforeValidator(lambda x: (x,) if isinstance(x, str) else x)]
"""One name, or a list of names."""


def _key(field: str) -> str:
    """The key of a field in files, where it is a word of Python."""
    return "for" if field == "duration" else field


class Action(Section):
    """One action of a scenario: when it begins and ends, and what it does.

    It begins `at` a time [s], or `when` a condition as ``buoy.z > 2 m`` is first true; it ends
    after a time `for` [s] (in Python `duration`), or not at all.
    set: values by unconnected input or tunable parameter; ramp: values that these reach in equal
    steps `within` a time [s].
    freeze: signals that stay as they are. offset: amounts that are added, by signal. replace:
    values by signal.
    """

    model_config = ConfigDict(populate_by_name=True, alias_generator=_key)

    at: Time | None = None
    when: str | None = None
    duration: Time | None = None
    set: Mapping[str, bool | int | float | str] | None = None
    ramp: Mapping[str, Amount] | None = None
    within: Time | None = None
    freeze: Names | None = None
    offset: Mapping[str, Amount] | None = None
    replace: Mapping[str, Amount] | None = None

    @property
    def kind(self) -> str:
        """The key that says what it does."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def given(self) -> dict[str, object]:
        """Its values by the keys of files, without those that are as if they were left out."""
        fields = ((key, field.default) for key, field in type(self).model_fields.items())
        return {_key(k): getattr(self, k) for k, default in fields if getattr(self, k) != default}

    @model_validator(mode="after")
    def _whole(self) -> Action:
        for message, remedy in self._faults():
            raise rejected(message, remedy)
        return self

    def _faults(self) -> Iterator[tuple[str, str]]:
        """All that does not fit together: message and remedy."""
        kinds = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(kinds) != 1:
            what = f"does {' and '.join(kinds)}" if kinds else "does nothing"
            yield (
                f"an action {what}",
                f"give one of {', '.join(KINDS)}; several are several actions",
            )
            return
        if (self.at is None) == (self.when is None):
            told = "both 'at' and 'when'" if self.at is not None else "neither 'at' nor 'when'"
            remedy = "give a time, 'at: 10 s', or a condition, 'when: buoy.z > 2 m'"
            yield f"an action has {told}", remedy
        if self.at is not None and not abs(self.at) < LONGEST_RUN:
            yield f"'at' is {self.at:g} s", "give a time within the run"
        if "within" in self.model_fields_set and kinds[0] != "ramp":
            yield f"{kinds[0]!r} has no 'within'", "leave 'within' out"
        for key in ("duration", "within"):
            time = getattr(self, key)
            if time is not None and not 0.0 < time < LONGEST_RUN:
                name = "for" if key == "duration" else key
                yield f"{name!r} is {time:g} s", "give a time above 0"
        if kinds[0] == "ramp" and self.within is None:
            yield "a ramp without a time", "give the time that it takes, 'within: 2 s'"
        if self.within and self.duration and self.within > self.duration:
            yield (
                f"'for' ends the ramp after {self.duration:g} s, 'within' is {self.within:g} s",
                "give more 'for', or less 'within': values return when 'for' is over",
            )
        if not getattr(self, kinds[0]):
            yield f"{kinds[0]!r} names nothing", "give the name of a variable, component.variable"


@dataclass(frozen=True)
class Origin:
    """A file of parameters (with its `document` if it is YAML), or "command line", or "Python".

    `value` is the given value of a setting, which a run may refine.
    """

    name: str = "Python"
    document: Document | None = None
    value: object = None

    def problem(self, variable: str, message: str, remedy: str) -> Problem:
        """A problem with the value that was given for `variable`."""
        if self.document is not None:
            return self.document.problem(("values", variable), message, remedy)
        return Problem(message, remedy, "" if self == Origin() else self.name)


class ParameterSet(dict[str, StartValue]):
    """Start values ``component.variable`` with the file they are from, as `origin`."""

    def __init__(
        self, values: Mapping[str, StartValue], path: Path, document: Document | None
    ) -> None:
        super().__init__(values)
        self.origin = Origin(str(path), document)


@dataclass(frozen=True)
class System:
    """Components, the connections between them, and the simulation.

    A connection is text: ``a.group <-> b.group`` connects connectors, ``a.variable -> b.variable``
    one variable or all elements of an array, ``a.variable * 2.5 + 1 -> b.variable`` with a factor
    and an offset. `inputs` and `outputs` are the system's own variables by name, and what they
    stand for: the inputs ``component.variable`` that take the value, the output that gives it.
    `scenario` are actions on it during a run, by name.

    `notes` say what reading the file has changed or left out. `folder` is the one that relative
    file names in the components' configurations start from; `processes` what holds for FMUs in
    processes of their own; `document` the YAML file it came from.
    `origins` are the origins of all that `changed` has set, by ``component.variable`` and by
    setting. InputError for steps of components that do not fit to each other.
    """

    name: str
    components: tuple[Component, ...]
    connections: tuple[str, ...]
    simulation: Simulation
    description: str = ""
    inputs: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    scenario: Mapping[str, Action] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    folder: Path = field(default_factory=Path)
    processes: Processes = field(default_factory=Processes)
    document: Document | None = field(default=None, repr=False, compare=False)
    origins: Mapping[str, Origin] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "folder", as_path(self.folder))
        found = step_problems(self.components, self.simulation)
        InputError.raise_for(self.problem(p.keys, p.message, p.remedy) for p in found)

    def changed(
        self, *, start: Start | None = None, origin: str = "", **simulation: object
    ) -> System:
        """The same system with other start values and simulation settings.

        `start` maps ``component.variable`` to a value; settings left None stay unchanged.
        `origin` names their source in messages and results, "Python" if it is empty; the values of
        a ParameterSet are from its file. InputError with all components that do not exist, and
        settings that do not fit.
        """
        caller = Origin(origin or "Python")
        giver = start.origin if isinstance(start, ParameterSet) else caller
        problems = [
            caller.problem("", f"unknown setting {key!r}", suggestion(key, SETTINGS, "settings"))
            for key in simulation.keys() - set(SETTINGS)
        ]
        components = self._with_start(_mapping(start), giver, problems)
        given = {k: v for k, v in simulation.items() if v is not None and k in SETTINGS}
        settings = self.simulation
        try:
            settings = replace(settings, **given)
        except InputError as error:
            problems += [caller.problem("", p.message, p.remedy) for p in error.problems]
        InputError.raise_for(problems)
        return replace(
            self,
            components=components,
            simulation=settings,
            origins={
                **self.origins,
                **dict.fromkeys(start or {}, giver),
                **{name: replace(caller, value=getattr(settings, name)) for name in given},
            },
        )

    def _with_start(
        self, start: Start, giver: Origin, problems: list[Problem]
    ) -> tuple[Component, ...]:
        """The components with further start values; adds to `problems`."""
        components = {component.name: component for component in self.components}
        for name, value in start.items():
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
        return tuple(components.values())

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
            named = (
                (*keys, "@value")
                for keys, text in self.document.texts(at)  # relative to the document's folder
                if self.folder / text == Path(problem.file)
            )
            keys = next(named, ())
        if not keys:
            return problem
        message = f"{problem.message} ({problem.file})" if problem.file else problem.message
        return self.document.problem((*at, *keys), message, problem.remedy)

    def __repr__(self) -> str:
        times = self.simulation
        return listing(
            f"System {self.name!r}: {times.start_time:g} s to {times.stop_time:g} s, "
            f"step {times.step_size:g} s, {times.algorithm}",
            components=self.components,
            connections=self.connections,
        )


def _mapping(start: object) -> Start:
    """Start values by name, none for None; InputError for anything but a mapping."""
    if start is None:
        return {}
    if not isinstance(start, Mapping):
        message = f"start: expected values by name, got {type(start).__name__}"
        raise InputError.single(message, "write start={'component.variable': value}")
    return start
