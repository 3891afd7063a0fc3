"""Components whose section changes in a study: as few FMUs as possible, and start values.

A section makes a program. Programs that differ in the start values of their variables alone share
one FMU, whichever kind makes them; what they differ in are start values of the run. Python code and
programs that differ in their operations or constants have an FMU for each section.
"""

from __future__ import annotations

import hashlib
import marshal
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from m4e_fmi.cosim.preparation.components import WARNING, Draft
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import read_component
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Location
from m4e_fmi.program import Program, Variable
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.systems.targets import dotted, with_values

Combination = tuple[Scalar, ...]
"""Values of the varied keys of one component."""
Make = Callable[[Component], Draft]
MOST_DRAFTS = 8
"""Programs that are kept until their FMUs are built; others are made again. One may have 50 MB."""
_GROUPS = ("parameters", "inputs", "states", "outputs", "calculated")
_NO_REFERENCES = 2
"""Version of marshal's form in which equal operations have equal bytes."""


@dataclass(frozen=True)
class Build:
    """One FMU of a component: what it is made of, and the values of the keys it was made for.

    `variables` are parameters, states and inputs of its program; None of Python code.
    """

    component: Component
    of: Combination
    variables: tuple[Variable, ...] | None = field(repr=False)


@dataclass(frozen=True)
class Variant:
    """A component with its own section, as a `build` by number and start values on top of it.

    Start values of the system's file come before these. `warnings` are those of its section.
    """

    build: int
    component: Component
    start: Mapping[str, float]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Variants:
    """All versions of one component, by the values of its varied `keys`.

    `labels` are unit and description of keys that are parameters of its program, by place. `drafts`
    are those of builds by number, until they are used; of many programs all would fill the memory.
    """

    name: str
    keys: tuple[Location, ...]
    builds: tuple[Build, ...]
    of: Mapping[Combination, Variant] = field(repr=False)
    labels: Mapping[int, tuple[str, str]] = field(default_factory=dict)
    drafts: dict[int, Draft] = field(default_factory=dict, repr=False)


def variants(
    system: System,
    name: str,
    keys: Sequence[Location],
    combinations: Iterable[Combination],
    make: Make,
) -> Variants:
    """The versions of the component `name` for each of the `combinations` of values of its `keys`.

    `make` drafts a component. The draft of every combination is compared with those before it:
    nothing is concluded from other values. InputError with all values that its section refuses.
    """
    sections = _Sections(system, name, tuple(keys), make)
    problems: dict[Problem, Problem] = {}
    builds: list[Build] = []
    drafts: dict[int, Draft] = {}
    by_code: dict[str, list[int]] = {}
    of: dict[Combination, Variant] = {}
    labels = [_Label(key) for key in keys]
    for one in dict.fromkeys(combinations):
        try:
            made, draft = sections.build(one)
        except InputError as error:
            for problem in error.problems:
                problems.setdefault(problem, sections.with_values(problem, one))
            continue
        for label, value in zip(labels, one, strict=True):
            label.narrow(_program(draft), value)
        alike = by_code.setdefault(code_of(made, _program(draft)), [])
        started = ((n, _started(builds[n], made)) for n in alike)
        number, start = next(((n, s) for n, s in started if s is not None), (len(builds), {}))
        if number == len(builds):
            builds.append(made)
            alike.append(number)
            if number < MOST_DRAFTS or made.variables is None:
                drafts[number] = draft
        warnings = tuple(line for line in draft.lines if line.startswith(WARNING))
        of[one] = Variant(number, made.component, start, warnings)
    if problems:
        raise InputError(problems.values())
    told = {k: found for k, label in enumerate(labels) if (found := label.found)}
    return Variants(name, tuple(keys), tuple(builds), of, told, drafts)


class _Sections:
    """Sections of one component, with other values at some keys."""

    def __init__(self, system: System, name: str, keys: tuple[Location, ...], make: Make) -> None:
        assert system.document is not None
        self._system, self._document = system, system.document
        self._name, self._keys, self._make = name, keys, make
        self._section = self._document.data["components"][name]

    def build(self, values: Combination) -> tuple[Build, Draft]:
        """The component with these values, and its draft; InputError if they are refused."""
        try:
            section = with_values(self._section, dict(zip(self._keys, values, strict=True)))
        except ValueError as error:
            raise InputError.single(f"{self._name}: {error}") from None
        components = {**self._document.data["components"], self._name: section}
        document = self._document.with_data({**self._document.data, "components": components})
        component = read_component(document, self._name)
        try:
            draft = self._make(component)
        except InputError as error:
            raise InputError(self._system.located(self._name, p) for p in error.problems) from None
        program = _program(draft)
        variables = (*program.parameters, *program.states, *program.inputs) if program else None
        return Build(component, values, variables), draft

    def with_values(self, problem: Problem, values: Combination) -> Problem:
        """The problem with the values that lead to it in its message."""
        told = ", ".join(
            f"{dotted(key)} = {value}" for key, value in zip(self._keys, values, strict=True)
        )
        return replace(problem, message=f"{problem.message} (with {told})")


class _Label:
    """Unit and description of a key: those of the parameter that has its value in all programs."""

    def __init__(self, key: Location) -> None:
        self._last = str(key[-1])
        self._values: set[Scalar] = set()
        self._known: dict[str, Variable] | None = None

    def narrow(self, program: Program | None, value: Scalar) -> None:
        """Keep the parameters that have this `value` of the key, too."""
        self._values.add(value)
        parameters = program.parameters if program and not isinstance(value, bool | str) else ()
        same = {v.name: v for v in parameters if v.start == value}
        if self._known is not None:
            same = {name: v for name, v in self._known.items() if name in same}
        self._known = same

    @property
    def found(self) -> tuple[str, str] | None:
        """Unit and description; None if no parameter, or more than one, may be meant.

        A value that does not vary says nothing if the parameter has another name, or if it is 0.
        """
        known = self._known or {}
        named = [v for v in known.values() if v.name.rpartition(".")[2] == self._last]
        alone = named or [*known.values()]
        if len(alone) != 1 or (len(self._values) < 2 and (not named or self._values == {0})):
            return None
        return alone[0].unit, alone[0].description.partition(",")[0]


def _program(draft: Draft) -> Program | None:
    """The program of a draft; None of Python code."""
    return draft.made if isinstance(draft.made, Program) else None


def _started(built: Build, wanted: Build) -> dict[str, float] | None:
    """Start values with which `built` is what `wanted` would be; None if its FMU refuses them."""
    if built.variables is None or wanted.variables is None:
        return None
    found: dict[str, float] = {}
    for old, new in zip(built.variables, wanted.variables, strict=True):
        if new.start == old.start:
            continue
        if not old.minimum <= new.start <= old.maximum:
            return None
        found[old.name] = new.start
    return found


def code_of(build: Build, program: Program | None) -> str:
    """Hash of what the FMU computes: a program without its start values, or Python code with all.

    Programs with one hash have the same variables and operations in the same order.
    """
    own = [repr(build.component.step_size), repr(build.component.dependencies)]
    digest = hashlib.sha256("\0".join(own).encode())
    if program is None:
        digest.update(repr(build.component.source).encode())
        digest.update(repr(build.of).encode())
        return digest.hexdigest()
    digest.update(bare_code(program).encode())
    return digest.hexdigest()


def bare_code(program: Program) -> str:
    """Hash of the operations of a program and of its variables without start values and texts."""
    groups = (getattr(program, name) for name in _GROUPS)
    bare = [[replace(v, start=0.0, description="") for v in group] for group in groups]
    roots = (program.rates, program.results, program.constants)
    digest = hashlib.sha256(marshal.dumps(program.tape.operations, _NO_REFERENCES))
    digest.update(repr((program.name, bare, roots)).encode("utf-8", "replace"))
    return digest.hexdigest()
