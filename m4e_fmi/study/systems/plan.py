"""The plan of a study of a system: its FMUs, and one task for each run."""

from __future__ import annotations

import hashlib
import json
import math
import pickle
import zipfile
from collections import Counter
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from m4e_fmi.code_hash import code_hash, imports_hash
from m4e_fmi.cosim.preparation.components import (
    WARNING,
    ReadyFmu,
    ready_fmus,
)
from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.results.system_scene import waters
from m4e_fmi.cosim.run.identity import identity
from m4e_fmi.cosim.system.component import Component, StartValue
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.document import Location
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.writing import written
from m4e_fmi.fmu.importer.reading import STRUCTURAL
from m4e_fmi.study.dataset import Batch, Labels, Work, rows_text
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.names import changed, named_system
from m4e_fmi.study.report.record import inputs_of
from m4e_fmi.study.start_up import first_time, ramp_warnings, ramps_of
from m4e_fmi.study.systems.execution import Perform
from m4e_fmi.study.systems.task import Blob, Task
from m4e_fmi.study.systems.variants import Combination, Variant, Variants, variants
from m4e_fmi.study.targets import KeyTarget, StartTarget, dotted

Tell = Callable[[str], None]
NO_TIME = ("algorithm", "tolerance", "coupling_tolerance")
"""Settings that are no times."""


class SystemPlan:
    """The runs of a study of a system: versions of its components, their FMUs, and tasks.

    `variants` are the versions of the components whose section changes. FMUs are built in `folder`;
    what runs share is in `blobs`.

    InputError with all problems of names and values; if there are none, with those of sections.
    """

    def __init__(self, study: Study, folder: Path, blobs: Path, tell: Tell) -> None:
        self.named, self.of = named_system(study)
        self.study, self.system = self.named.study, self.of.system
        self.folder, self.blobs, self.tell = folder, blobs, tell
        settings = (self.named.settings(study.grid.values(run)) for run in study.grid.runs)
        distinct = {repr(one): one for one in settings}.values()
        self._simulations = [changed(self.system, one).simulation for one in distinct]
        for one in self._simulations if study.start_up is not None else ():
            first_time(self.study, {}, one.start_time, one.stop_time)  # before FMUs are built
        self.variants: dict[str, Variants] = {}
        problems: list[Problem] = []
        for component in self.system.components:
            name = component.name
            if keys := self.named.keys(name):
                values = (self.study.grid.values(run) for run in self.study.grid.runs)
                wanted = (tuple(one[key] for key in keys) for one in values)
                try:
                    self.variants[name] = variants(self.system, name, [*keys.values()], wanted)
                except InputError as error:
                    problems += error.problems
        InputError.raise_for(dict.fromkeys(problems))
        self._fmus: dict[tuple[str, int], ReadyFmu] = {}
        self._prepared: dict[str, tuple[Prepared, Blob]] = {}
        self._imports = lru_cache(maxsize=None)(imports_of)
        self._of_all: dict[str, None] = {}  # warnings of all runs
        self._water: dict[str, None] = {}  # depths and densities of all runs, in words

    @property
    def _same(self) -> tuple[Component, ...]:
        """The components whose section does not change."""
        return tuple(c for c in self.system.components if c.name not in self.variants)

    def variant(self, name: str, run: int) -> Variant:
        """The version of a component whose section changes, in a run."""
        values = self.study.grid.values(run)
        return self.variants[name].of[tuple(values[key] for key in self.named.keys(name))]

    def components(self, run: int) -> dict[str, tuple[int, Component]]:
        """Every component of a run with its start values, and the number of its FMU."""
        values = self.study.grid.values(run)
        found: dict[str, tuple[int, Component]] = {}
        for component in self.system.components:
            name, number, made = component.name, 0, component
            own: dict[str, StartValue] = dict(component.start)
            if name in self.variants:
                variant = self.variant(name, run)
                number, made, own = variant.build, variant.component, {**variant.start, **own}
            for key, target in self.named.starts.items():
                if target.component == name:
                    own[target.variable] = values[key]
            found[name] = number, replace(made, start=own)
        return found

    def build(self) -> None:
        """Build all FMUs that are not there yet."""
        if same := self._same:
            drafts = None if len(same) == len(self.system.components) else {}
            system = replace(self.system, components=same)
            found = ready_fmus(system, self.folder, tell=self._tell_of_all, drafts=drafts)
            self._fmus |= {(name, 0): fmu for name, fmu in found.items()}
        for name, one in self.variants.items():
            for combination, variant in one.of.items():
                for line in variant.warnings:
                    self.tell(f"{name}: {line} ({_values_text(one.keys, combination)})")
            for number in range(len(one.builds)):
                found = ready_fmus(
                    self.part(name, number),
                    self._variants_folder,
                    tell=partial(self._tell_of_one, one, number),
                    drafts={},
                )
                self._fmus[name, number] = found[name]

    def _tell_of_all(self, line: str) -> None:
        """Tell a line of the build of a component that does not change."""
        if line.partition(": ")[2].startswith(WARNING):
            self._of_all[_warning(line)] = None
        self.tell(line)

    def _tell_of_one(self, one: Variants, number: int, line: str) -> None:
        """Tell a line of a build of a component, but for warnings, which are those of sections."""
        if f": {WARNING}" not in line:
            self.tell(f"{line} ({of_keys(one, number)})")

    @property
    def _variants_folder(self) -> Path:
        return self.folder / f"{file_stem(self.system.name)}.variants"

    def part(self, name: str, number: int) -> System:
        """A version of a component as a system of its own, which its FMU is built from."""
        one = self.variants[name]
        build = one.builds[number]
        same = repr((one.keys, build.of, build.component))
        short = hashlib.sha256(same.encode("utf-8", "replace")).hexdigest()[:12]
        parts = (replace(build.component, start={}),)
        return replace(self.system, name=f"{name}_{short}", components=parts)

    def work(self, perform: Perform) -> Work:
        """The runs, which `perform` makes; FMUs are built."""
        study, runs = self.study, self.study.grid.runs
        inputs = inputs_of(study)
        self.build()
        ramping: list[Mapping[str, float]] = []
        tasks = {run: self.task(run, ramping) for run in runs}
        warnings = Counter[str](dict.fromkeys(self._of_all, len(runs)))
        for name, one in self.variants.items():
            if any(variant.warnings for variant in one.of.values()):
                for run in runs:
                    told = self.variant(name, run).warnings
                    warnings.update(_warning(f"{name}: {line}") for line in told)
        points = range(study.grid.size)

        def records(missing: Sequence[int]) -> Generator[Batch]:
            for run, record in perform((run, tasks[run]) for run in missing):
                yield {run: record}

        return Work(
            study=study,
            keys=[tasks[run].key if run in tasks else "" for run in points],
            start_up=[tasks[run].start_up if run in tasks else math.nan for run in points],
            labels=self._labels(),
            inputs=inputs,
            warnings={**warnings, **ramp_warnings(study, ramping)},
            notes=(),
            records=records,
            rows=rows_text([one.output_interval for one in self._simulations]),
            wave_power=[tasks[run].wave_power if run in tasks else math.nan for run in points],
            water=" or ".join(self._water),
        )

    def _wave_power(self, system: System, prepared: Prepared, first: float) -> float:
        """Mean power [W/m] of the waves per metre of crest from `first` [s] on; nan without any."""
        time = np.linspace(first, system.simulation.stop_time, 101)
        for water in waters(system, prepared.descriptions):
            if power := water.energy_flux(time):
                deep = "deep water" if math.isinf(water.depth) else f"{water.depth:g} m of water"
                self._water[f"{deep} of {water.density:g} kg/m3"] = None
                return power
        return math.nan

    def _labels(self) -> Labels:
        """Units and descriptions of what is varied and of wanted variables."""
        varied: dict[str, tuple[str, str]] = {}
        for name, target in self.named.targets.items():
            if isinstance(target, StartTarget):
                varied[name] = target.unit, target.text
            elif isinstance(target, KeyTarget):
                one = self.variants[target.component]
                varied[name] = one.label(one.keys.index(target.keys))
            elif target.key not in NO_TIME:
                varied[name] = "s", f"{target.key} of the simulation"
        names = (*(w.variable for w in self.study.wanted), *self.study.series)
        found = {name: self.of.variable(name) for name in names}
        return Labels(varied, {n: (v.unit, v.description) for n, v in found.items()})

    def task(self, run: int, ramping: list[Mapping[str, float]]) -> Task:
        """The task of run number `run`, from 0; adds the ramps [s] of its seas to `ramping`.

        The FMUs have been built. InputError if no row of it counts.
        """
        study, components = self.study, self.components(run)
        settings = self.named.settings(study.grid.values(run))
        parts = tuple(component for _, component in components.values())
        system = replace(changed(self.system, settings), components=parts)
        numbers = {name: number for name, (number, _) in components.items()}
        prepared, blob = self._prepared_for(system, numbers)
        stop = system.simulation.stop_time
        own = replace(prepared.system, components=parts).changed(stop_time=stop)
        ramping.append(ramps_of(own, prepared.descriptions))
        first = first_time(study, ramping[-1], own.simulation.start_time, stop)
        same = {
            **identity(replace(prepared, system=own), certify=study.coupling_error),
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
            fmus={
                name: Blob(d.content, d.path.name, d.path.absolute())
                for name, d in prepared.descriptions.items()
            },
            start={c.name: dict(c.start) for c in parts},
            stop_time=stop,
            wanted=study.wanted,
            series=study.series,
            start_up=first,
            certify=study.coupling_error,
            wave_power=self._wave_power(own, prepared, first),
        )

    def _prepared_for(self, system: System, numbers: Mapping[str, int]) -> tuple[Prepared, Blob]:
        """A prepared system with these FMUs and settings, and its blob.

        It is that of whatever start values, but for those that give arrays their size, and of
        whatever stop time.
        """
        fmus = {name: self._fmus[name, number] for name, number in numbers.items()}
        key = repr((
            {name: str(fmu.path) for name, fmu in fmus.items()},
            [self._sizes(component) for component in system.components],
            [(c.step_size, dict(c.dependencies), c.process) for c in system.components],
            {**vars(system.simulation), "stop_time": None},
        ))  # fmt: skip
        if key not in self._prepared:
            made = prepare(system, build_directory=self.folder, fmus=fmus)
            self._of_all |= dict.fromkeys(made.warnings)
            # the prepared system in a file, without what lies elsewhere
            bare = replace(made.system, document=None, origins={}, notes=())
            data = pickle.dumps(replace(made, system=bare, notes=(), warnings=()), protocol=5)
            content = hashlib.sha256(data).hexdigest()
            path = self.blobs / f"{content[:16]}.prepared"
            with written(path) as part:
                part.write_bytes(data)
            self._prepared[key] = made, Blob(content, path.name, path.absolute())
        return self._prepared[key]

    def _sizes(self, component: Component) -> dict[str, StartValue]:
        """The start values of structural parameters (FMI 3.0)."""
        known = self.of.descriptions.get(component.name)
        variables = known.variables if known else {}
        return {
            name: value
            for name, value in component.start.items()
            if name in variables and variables[name].causality == STRUCTURAL
        }


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


def of_keys(one: Variants, number: int) -> str:
    """The values of its keys that a version of a component was made for."""
    return _values_text(one.keys, one.builds[number].of)


def _values_text(keys: Sequence[Location], values: Combination) -> str:
    pairs = zip(keys, values, strict=True)
    return ", ".join(f"{dotted(key)} {value}" for key, value in pairs)
