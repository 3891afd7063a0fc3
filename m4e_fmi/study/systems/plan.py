"""The plan of a study of a system: its FMUs, and one task for each run."""

from __future__ import annotations

import hashlib
import json
import pickle
import zipfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path

from m4e_fmi.code_hash import code_hash, imports_hash
from m4e_fmi.cosim.preparation.components import (
    WARNING,
    Draft,
    ReadyFmu,
    drafted,
    missing_fmus,
    ready_fmus,
    takes_long,
)
from m4e_fmi.cosim.preparation.doubtful_values import ramps
from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.run.identity import identity
from m4e_fmi.cosim.system.component import Component, Kind, StartValue, kind_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.document import Location
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.writing import written
from m4e_fmi.fmu import Description
from m4e_fmi.fmu.importer.reading import STRUCTURAL
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.runs.start_up import check_start_up, ramp_of, start_up, within_ramp
from m4e_fmi.study.systems.names import Named, changed
from m4e_fmi.study.systems.targets import dotted
from m4e_fmi.study.systems.task import Blob, Task
from m4e_fmi.study.systems.variants import Combination, Variant, Variants, variants

Tell = Callable[[str], None]


@dataclass(frozen=True)
class Versions:
    """All versions of the components of a study whose sections change, by component."""

    named: Named
    of: Mapping[str, Variants]

    def components(self, run: int) -> dict[str, tuple[int, Component]]:
        """Every component of a run with its start values, and the number of its FMU."""
        values = self.named.study.grid.values(run)
        start = self.named.start(values)
        found: dict[str, tuple[int, Component]] = {}
        for component in self.named.system.components:
            name, number, made = component.name, 0, component
            own: dict[str, StartValue] = {**component.start, **start.get(name, {})}
            if name in self.of:
                variant = self._variant(name, values)
                number, made, own = variant.build, variant.component, {**variant.start, **own}
            found[name] = number, replace(made, start=own)
        return found

    def variant(self, name: str, run: int) -> Variant:
        """The version of a component whose section changes, in a run."""
        return self._variant(name, self.named.study.grid.values(run))

    def _variant(self, name: str, values: Mapping[str, Scalar]) -> Variant:
        return self.of[name].of[tuple(values[key] for key in self.named.keys(name))]


def versions(named: Named, *, quick: bool = False) -> Versions:
    """The versions of all components whose section is varied; InputError for values refused.

    `quick` ones are of what is known without long computations: their FMUs cannot be built.
    """
    grid, found = named.study.grid, dict[str, Variants]()
    problems: list[Problem] = []
    for component in named.changing:
        keys = named.keys(component.name)
        combinations = dict.fromkeys(
            tuple(values[key] for key in keys) for values in map(grid.values, grid.runs)
        )

        def make(one: Component) -> Draft:
            return _expected(named.system, one) if quick else drafted(named.system, one)

        try:
            found[component.name] = variants(
                named.system, component.name, list(keys.values()), combinations, make
            )
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(dict.fromkeys(problems))
    return Versions(named, found)


def _expected(system: System, component: Component) -> Draft:
    """The draft of a component without long computations."""
    source = component.source
    if isinstance(source, Kind) and takes_long(source):
        outline = kind_of(source.name).outline(source.config, folder=system.folder)
        if outline is not None:
            return Draft(outline, {})
    return drafted(system, component)


@dataclass
class Plan:
    """The FMUs of a study, built, and its tasks.

    `warnings` are those of preparation and of FMUs, with the number of runs that have them.
    """

    versions: Versions
    folder: Path
    blobs: Path
    tell: Tell
    warnings: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._fmus: dict[tuple[str, int], ReadyFmu] = {}
        self._prepared: dict[str, tuple[Prepared, Blob]] = {}
        self._of_prepared: dict[str, None] = {}
        self._files: dict[Path, Blob] = {}
        self._imported: dict[Path, str] = {}
        self._of_base: list[str] = []
        self._early: list[float] = []  # ramps [s] that end after the start-up

    @cached_property
    def _base(self) -> dict[str, ReadyFmu]:
        """The FMUs of the components whose section does not change."""
        named = self.versions.named
        same = tuple(c for c in named.system.components if c.name not in self.versions.of)
        if not same:
            return {}
        if len(same) == len(named.system.components):
            return ready_fmus(named.system, self.folder, tell=self._tell_of_base)
        system = replace(named.system, components=same)
        return ready_fmus(system, self.folder, tell=self._tell_of_base, drafts={})

    def build(self) -> None:
        """Build all FMUs that are not there yet."""
        for name, fmu in self._base.items():
            self._fmus[name, 0] = fmu
        for name, one in self.versions.of.items():
            for combination, variant in one.of.items():
                for line in variant.warnings:
                    self.tell(f"{name}: {line} ({_values_text(one.keys, combination)})")
            lines = _BuildLines(self.tell, name, one)
            for number in range(len(one.builds)):
                draft = one.drafts.pop(number, None)
                fmus = ready_fmus(
                    self.part(name, number),
                    self._variants_folder,
                    tell=partial(lines.tell, number),
                    drafts={name: draft} if draft else {},
                )
                self._fmus[name, number] = fmus[name]
            lines.end()

    def _tell_of_base(self, line: str) -> None:
        """Tell a line of the build of a component that does not change."""
        if line.partition(": ")[2].startswith(WARNING):
            self._of_base.append(_warning(line))
        self.tell(line)

    @property
    def _variants_folder(self) -> Path:
        return self.folder / f"{file_stem(self.versions.named.system.name)}.variants"

    def part(self, name: str, number: int) -> System:
        """A version of a component as a system of its own, which its FMU is built from."""
        one = self.versions.of[name]
        build = one.builds[number]
        same = repr((one.keys, build.of, build.component))
        return replace(
            self.versions.named.system,
            name=f"{name}_{_short(same)}",
            components=(replace(build.component, start={}),),
        )

    def missing(self) -> list[str]:
        """FMUs that would be built, in words."""
        system = self.versions.named.system
        same = tuple(c for c in system.components if c.name not in self.versions.of)
        found = list(missing_fmus(replace(system, components=same), self.folder))
        for name, one in self.versions.of.items():
            found += [
                f"{name} ({of_keys(one, number)})"
                for number in range(len(one.builds))
                if missing_fmus(self.part(name, number), self._variants_folder)
            ]
        return found

    def tasks(self) -> dict[int, Task]:
        """The task of each run by its number, in order; the FMUs have been built."""
        runs = self.versions.named.study.grid.runs
        tasks = {run: self.task(run) for run in runs}
        found = Counter[str](dict.fromkeys([*self._of_base, *self._of_prepared], len(runs)))
        for name, one in self.versions.of.items():
            if any(variant.warnings for variant in one.of.values()):
                for run in runs:
                    variant = self.versions.variant(name, run)
                    found.update(_warning(f"{name}: {line}") for line in variant.warnings)
        if self._early:
            stated = self.versions.named.study.start_up
            found[within_ramp(stated or 0.0, max(self._early))] = len(self._early)
        self.warnings = dict(found)
        return tasks

    def task(self, run: int) -> Task:
        """The task of run number `run`, from 0."""
        named = self.versions.named
        study = named.study
        components = self.versions.components(run)
        settings = named.settings(study.grid.values(run))
        system = replace(
            changed(named.system, settings),
            components=tuple(component for _, component in components.values()),
        )
        numbers = {name: number for name, (number, _) in components.items()}
        prepared, blob = self._prepared_for(system, numbers)
        own = replace(prepared, system=replace(prepared.system, components=system.components))
        stop = system.simulation.stop_time
        own = replace(own, system=own.system.changed(stop_time=stop))
        first = self.start_up(own)
        starts = {c.name: dict(c.start) for c in system.components}
        fmus = {name: self._file(d.path, d) for name, d in prepared.descriptions.items()}
        same = {
            **identity(own, certify=study.coupling_error),
            "code": code_hash(),
            "imports": {n: self._imports(d.path) for n, d in prepared.descriptions.items()},
            "stop_time": repr(stop),
            "order": repr(prepared.structure),
            "wanted": repr((study.wanted, study.series, first)),
        }
        key = hashlib.sha256(json.dumps(same, sort_keys=True).encode("utf-8", "replace"))
        return Task(
            key=key.hexdigest(),
            prepared=blob,
            fmus=fmus,
            start=starts,
            stop_time=stop,
            wanted=study.wanted,
            series=study.series,
            start_up=first,
            certify=study.coupling_error,
        )

    def start_up(self, prepared: Prepared) -> float:
        """The time [s] from which on the rows of a run count; InputError if none does."""
        study = self.versions.named.study
        starts = ramps(prepared.system, prepared.descriptions)
        times = prepared.system.simulation
        if study.start_up is not None and study.start_up < ramp_of(starts.items()):
            self._early.append(ramp_of(starts.items()))
        first = start_up(study.start_up, times.start_time, starts)
        check_start_up(study, first, times.stop_time)
        return first

    def _prepared_for(self, system: System, numbers: Mapping[str, int]) -> tuple[Prepared, Blob]:
        """A prepared system with these FMUs and settings, and its blob.

        It is that of whatever start values, but for those that give arrays their size.
        """
        fmus = {name: self._fmus[name, number] for name, number in numbers.items()}
        key = repr((
            {name: str(fmu.path) for name, fmu in fmus.items()},
            [self._sizes(component) for component in system.components],
            [(c.step_size, dict(c.dependencies), c.process, c.limits) for c in system.components],
            _but_stop_time(system),
        ))  # fmt: skip
        if key not in self._prepared:
            made = prepare(system, build_directory=self.folder, fmus=fmus)
            self._of_prepared |= dict.fromkeys(made.warnings)
            self._prepared[key] = made, self._blob(made)
        return self._prepared[key]

    def _sizes(self, component: Component) -> dict[str, StartValue]:
        """The start values of structural parameters (FMI 3.0)."""
        known = self.versions.named.descriptions.get(component.name)
        variables = known.variables if known else {}
        return {
            name: value
            for name, value in component.start.items()
            if name in variables and variables[name].causality == STRUCTURAL
        }

    def _blob(self, prepared: Prepared) -> Blob:
        """The prepared system in a file, without what lies elsewhere."""
        system = replace(prepared.system, document=None, origins={}, notes=())
        data = pickle.dumps(replace(prepared, system=system, notes=(), warnings=()), protocol=5)
        content = hashlib.sha256(data).hexdigest()
        path = self.blobs / f"{content[:16]}.prepared"
        with written(path) as part:
            part.write_bytes(data)
        return Blob(content, path.name, path.absolute())

    def _imports(self, fmu: Path) -> str:
        """Hash of what the Python code in an FMU imports from outside of it."""
        if fmu not in self._imported:
            self._imported[fmu] = imports_of(fmu)
        return self._imported[fmu]

    def _file(self, path: Path, description: Description) -> Blob:
        if path not in self._files:
            self._files[path] = Blob(description.content, path.name, path.absolute())
        return self._files[path]


class _BuildLines:
    """Lines on the builds of one component: all of the first, then how many there are.

    Warnings are none of them: they are those of sections, which may share an FMU.
    """

    def __init__(self, tell: Tell, name: str, one: Variants) -> None:
        self._tell, self._name, self._one = tell, name, one
        self._first = self._last = -1

    def tell(self, number: int, line: str) -> None:
        """Tell a line on the FMU of a `number`, if it is new."""
        if line.partition(": ")[2].startswith(WARNING):
            return
        if self._first < 0:
            self._first = number
        if number == self._first:
            self._tell(f"{line} ({of_keys(self._one, number)})")
        elif number != self._last:
            self._count(number)

    def end(self) -> None:
        """End the line that counts."""
        if 0 <= self._last < len(self._one.builds) - 1:
            self._count(len(self._one.builds) - 1)

    def _count(self, number: int) -> None:
        self._last = number
        self._tell(f"{self._name}: building FMUs, {number + 1} of {len(self._one.builds)}")


def _warning(line: str) -> str:
    """A line ``component: warning: text`` without that word."""
    return line.replace(f"{WARNING}: ", "", 1)


def imports_of(fmu: Path) -> str:
    """Hash of what the Python files in an FMU import, but for each other; "" if it has none.

    RunError if it cannot be read.
    """
    try:
        with zipfile.ZipFile(fmu) as archive:
            files = [Path(name) for name in archive.namelist() if name.endswith(".py")]
            sources = [archive.read(file.as_posix()) for file in files]
    except (OSError, zipfile.BadZipFile) as error:
        raise RunError(f"{fmu}: cannot be read: {error}", "build it again") from error
    return imports_hash(sources, {word for file in files for word in (*file.parts, file.stem)})


def _but_stop_time(system: System) -> dict[str, object]:
    """The settings of a system's simulation without the stop time: prepared ones share any."""
    return {**vars(system.simulation), "stop_time": None}


def of_keys(one: Variants, number: int) -> str:
    """The values of its keys that a version of a component was made for."""
    return _values_text(one.keys, one.builds[number].of)


def _values_text(keys: Sequence[Location], values: Combination) -> str:
    pairs = zip(keys, values, strict=True)
    return ", ".join(f"{dotted(key)} {value}" for key, value in pairs)


def _short(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:12]
