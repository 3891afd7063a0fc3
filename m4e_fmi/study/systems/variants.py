"""Components whose section changes in a study: as few FMUs as possible, and start values.

A section makes a program. Programs that differ in the start values of their variables alone share
one FMU, whichever kind makes them; what they differ in are start values of the run. Python code and
programs that differ in their operations or constants have an FMU for each section.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from m4e_fmi.cosim.input_checks.drafts import Draft
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import read_component
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document, Location
from m4e_fmi.program import Program, Variable
from m4e_fmi.program.binary_form import encode
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.systems.targets import with_values

Combination = tuple[Scalar, ...]
"""Values of the varied keys of one component."""
Make = Callable[[Component], Draft]
TRIED = 8
"""Values of a key at which it is seen to be a start value."""


@dataclass(frozen=True)
class Build:
    """One FMU of a component: what it is made of, and the values of the keys it was made for."""

    component: Component
    draft: Draft = field(repr=False)
    of: Combination

    @property
    def program(self) -> Program | None:
        """The program; None of Python code."""
        return self.draft.made if isinstance(self.draft.made, Program) else None


@dataclass(frozen=True)
class Variant:
    """A component with its own section, as a `build` by number and start values on top of it.

    Start values of the system's file come before these.
    """

    build: int
    component: Component
    start: Mapping[str, float]


@dataclass(frozen=True)
class Variants:
    """All versions of one component, by the values of its varied `keys`.

    `units` are unit and description of keys that are parameters of its program, by place.
    """

    name: str
    keys: tuple[Location, ...]
    builds: tuple[Build, ...]
    of: Mapping[Combination, Variant] = field(repr=False)
    labels: Mapping[int, tuple[str, str]] = field(default_factory=dict)


def variants(
    system: System,
    name: str,
    keys: Sequence[Location],
    combinations: Iterable[Combination],
    make: Make,
) -> Variants:
    """The versions of the component `name` for each of the `combinations` of values of its `keys`.

    `make` drafts a component. InputError with all values that its section refuses.
    """
    wanted = list(dict.fromkeys(combinations))
    return _Finder(system, name, tuple(keys), make).variants(wanted)


class _Finder:
    def __init__(self, system: System, name: str, keys: tuple[Location, ...], make: Make) -> None:
        assert system.document is not None
        self._document: Document = system.document
        self._name, self._keys, self._make = name, keys, make
        self._section = self._document.data["components"][name]
        self._made: dict[Combination, Build] = {}
        self._codes: dict[Combination, str] = {}

    def variants(self, wanted: Sequence[Combination]) -> Variants:
        direct = self._direct(wanted)
        builds: list[Build] = []
        by_code: dict[str, list[int]] = {}
        of: dict[Combination, Variant] = {}
        for one in wanted:
            plain = self._at_base(one, direct, wanted[0])
            made, code = self._build(plain), self._codes[plain]
            given = {direct[k]: float(one[k]) for k in direct}
            variant = None
            for number in by_code.get(code, []):
                if (start := _started(builds[number], made, given)) is not None:
                    variant = Variant(number, made.component, start)
                    break
            if variant is None:
                if (start := _started(made, made, given)) is None:
                    made, given = self._build(one), {}
                    start = {}
                builds.append(made)
                by_code.setdefault(code, []).append(len(builds) - 1)
                variant = Variant(len(builds) - 1, made.component, start)
            of[one] = variant
        return Variants(self._name, self._keys, tuple(builds), of, self._labels(wanted, direct))

    def _labels(
        self, wanted: Sequence[Combination], direct: Mapping[int, str]
    ) -> dict[int, tuple[str, str]]:
        """Unit and description of keys whose values the programs have as a parameter."""
        program = self._build(wanted[0]).program
        if program is None:
            return {}
        found = {}
        for k, location in enumerate(self._keys):
            last = str(location[-1])
            for variable in program.parameters:
                name = variable.name.rpartition(".")[2]
                if direct.get(k, "") == variable.name or (
                    k not in direct and name == last and variable.start == wanted[0][k]
                ):
                    text = variable.description.partition(",")[0]
                    found[k] = variable.unit, text
                    break
        return found

    def _at_base(
        self, one: Combination, direct: Mapping[int, str], base: Combination
    ) -> Combination:
        """`one` with the values of `base` for the keys that are start values."""
        return tuple(base[k] if k in direct else value for k, value in enumerate(one))

    def _build(self, values: Combination) -> Build:
        if values not in self._made:
            component = self._component(values)
            build = Build(component, self._make(component), values)
            self._made[values] = build
            self._codes[values] = code_of(build)
        return self._made[values]

    def _component(self, values: Combination) -> Component:
        """The component with these values; InputError that names those that are refused."""
        try:
            section = with_values(self._section, dict(zip(self._keys, values, strict=True)))
            components = {**self._document.data["components"], self._name: section}
            document = self._document.with_data({**self._document.data, "components": components})
            return read_component(document, self._name)
        except InputError as error:
            told = self._told(values)
            raise InputError(
                replace(p, message=f"{p.message} (with {told})") for p in error.problems
            ) from None
        except ValueError as error:
            raise InputError.single(f"{self._name}: {error}") from None

    def _told(self, values: Combination) -> str:
        return ", ".join(
            f"{'.'.join(map(str, key))} = {value}"
            for key, value in zip(self._keys, values, strict=True)
        )

    def _direct(self, wanted: Sequence[Combination]) -> dict[int, str]:
        """Keys that are nothing but the start value of one variable, by place, and its name.

        Seen at several values of each key, all others as in the first combination, and again with
        all others as in the last.
        """
        base, last = wanted[0], wanted[-1]
        found: dict[int, str] = {}
        for k in range(len(self._keys)):
            values = list(dict.fromkeys(one[k] for one in wanted))
            numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
            if len(values) < 2 or not numbers:
                continue
            tried = values[:: max(1, len(values) // TRIED)]
            names = set[str | None]()
            for at, value in (
                *((base, v) for v in (*tried, values[-1])),
                *((last, v) for v in values[:2]),
            ):
                names.add(self._wired(at, k, value))
                if "" in names:
                    break
            names.discard(None)
            if len(names) == 1 and (name := names.pop()):
                found[k] = str(name)
        if len(set(found.values())) < len(found):
            return {}
        return found

    def _wired(self, base: Combination, k: int, value: Scalar) -> str | None:
        """The one variable whose start value key `k` is; "" if it is something else.

        None if `value` is that of the base.
        """
        if value == base[k]:
            return None
        other = (*base[:k], value, *base[k + 1 :])
        here, there = self._build(base), self._build(other)
        if self._codes[base] != self._codes[other] or here.program is None:
            return ""
        changed = [
            (old, new)
            for old, new in zip(_variables(here), _variables(there), strict=True)
            if old.start != new.start
        ]
        if len(changed) != 1 or not (
            changed[0][0].start == base[k] and changed[0][1].start == value
        ):
            return ""
        return changed[0][0].name


def _variables(build: Build) -> tuple[Variable, ...]:
    program = build.program
    assert program is not None
    return (*program.parameters, *program.states, *program.inputs)


def _started(built: Build, wanted: Build, given: Mapping[str, float]) -> dict[str, float] | None:
    """Start values with which `built` is what `wanted` would be; None if its FMU refuses them.

    `given` are further ones.
    """
    if built.program is None:
        return {} if built is wanted and not given else None
    found: dict[str, float] = {}
    for old, new in zip(_variables(built), _variables(wanted), strict=True):
        start = given.get(new.name, new.start)
        if start == old.start:
            continue
        if not old.minimum <= start <= old.maximum:
            return None
        found[old.name] = start
    return found


def code_of(build: Build) -> str:
    """Hash of what the FMU computes: a program without its start values, or Python code with all.

    Programs with one hash have the same variables and operations in the same order.
    """
    program = build.program
    own = [repr(build.component.step_size), repr(build.component.dependencies)]
    digest = hashlib.sha256("\0".join(own).encode())
    if program is None:
        digest.update(repr(build.component.source).encode())
        digest.update(repr(build.of).encode())
        return digest.hexdigest()
    digest.update(bare_code(program).encode())
    return digest.hexdigest()


def bare_code(program: Program) -> str:
    """Hash of the operations of a program and the names and units of its variables."""
    return hashlib.sha256(encode(_bare(program))).hexdigest()


def _bare(program: Program) -> Program:
    """The program without what its operations do not depend on: start values and texts."""

    def bare(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
        return tuple(replace(v, start=0.0, description="") for v in variables)

    groups = ("parameters", "inputs", "states", "outputs", "calculated")
    return replace(program, description="", **{k: bare(getattr(program, k)) for k in groups})
