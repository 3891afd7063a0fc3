"""Components whose section changes in a study: as few FMUs as possible, and start values.

A section makes a program. Programs that differ in the start values of their variables alone share
one FMU, whichever kind makes them; what they differ in are start values of the run. Python code and
programs that differ in their operations or constants have an FMU for each section.
"""

from __future__ import annotations

import hashlib
import marshal
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from m4e_fmi.cosim.preparation.components import WARNING, Draft, drafted
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import read_component
from m4e_fmi.files.document import Location
from m4e_fmi.program import Program, Variable
from m4e_fmi.study.targets import Combination, dotted, made_for, with_values

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
    """All versions of one component, by the values of its varied `keys`."""

    name: str
    keys: tuple[Location, ...]
    builds: tuple[Build, ...]
    of: Mapping[Combination, Variant] = field(repr=False)

    def label(self, place: int) -> tuple[str, str]:
        """Unit and description of a key by its place, if a start value has its name and values."""
        last = str(self.keys[place][-1])
        for variable in self.builds[0].variables or ():
            if variable.name.rpartition(".")[2] == last and all(
                self._start(variable.name, one) == one[place] for one in self.of
            ):
                return variable.unit, variable.description.partition(",")[0]
        return "", ""

    def _start(self, name: str, one: Combination) -> float | None:
        """The start value of a variable in a version; None if it has none of that name."""
        made = self.of[one]
        known = {v.name: v.start for v in self.builds[made.build].variables or ()}
        return made.start.get(name, known.get(name))


def variants(
    system: System,
    name: str,
    keys: Sequence[Location],
    combinations: Iterable[Combination],
) -> Variants:
    """The versions of the component `name` for each of the `combinations` of values of its `keys`.

    The draft of every combination is compared with those before it: nothing is concluded from other
    values. InputError with all values that its section refuses.
    """
    document = system.document
    assert document is not None
    components = document.data["components"]

    def make(one: Combination) -> tuple[Component, Draft]:
        section = with_values(components[name], dict(zip(keys, one, strict=True)))
        data = {**document.data, "components": {**components, name: section}}
        component = read_component(document.with_data(data), name)
        return component, drafted(system, component)

    made_of = made_for(combinations, [*map(dotted, keys)], make, partial(system.located, name))
    builds: list[Build] = []
    by_code: dict[str, int] = {}
    of: dict[Combination, Variant] = {}
    for one, (component, draft) in made_of.items():
        program = draft.made if isinstance(draft.made, Program) else None
        made = Build(component, one, starts_of(program) if program else None)
        bare = bare_code(program) if program else repr((component.source, one))
        code = repr((component.step_size, component.dependencies, bare))
        number = by_code.setdefault(code, len(builds))
        if number == len(builds):
            builds.append(made)
        warnings = tuple(line for line in draft.lines if line.startswith(WARNING))
        pairs = zip(builds[number].variables or (), made.variables or (), strict=True)
        start = {new.name: new.start for old, new in pairs if repr(new.start) != repr(old.start)}
        of[one] = Variant(number, component, start, warnings)
    return Variants(name, tuple(keys), tuple(builds), of)


def starts_of(program: Program) -> tuple[Variable, ...]:
    """All variables of a program that have a start value: parameters, inputs, states."""
    return (*program.parameters, *program.inputs, *program.states)


def bare_code(program: Program) -> str:
    """Hash of the operations of a program and of its variables without start values and texts.

    Programs with one hash have the same variables and operations in the same order.
    """
    groups = (getattr(program, name) for name in _GROUPS)
    bare = [[replace(v, start=0.0, description="") for v in group] for group in groups]
    roots = (program.rates, program.results, program.constants)
    digest = hashlib.sha256(marshal.dumps(program.tape.operations, _NO_REFERENCES))
    digest.update(repr((program.name, bare, roots)).encode("utf-8", "replace"))
    return digest.hexdigest()
