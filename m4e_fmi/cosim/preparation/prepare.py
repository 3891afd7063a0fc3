"""From a System to one that can run: build missing FMUs, read the FMUs, connect, check.

Components run in separate processes if their FMUs were not built here. An FMU was built here if the
record beside it says so and fits its content, or if its library has the same bytes as that of all
native FMUs of this package. Statements of an FMU about itself are not trusted.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from zipfile import ZipFile

import fmpy

from m4e_fmi.cosim.network.interruption import setting_up
from m4e_fmi.cosim.network.schedule import loop_library
from m4e_fmi.cosim.preparation.components import (
    WARNING,
    Draft,
    ReadyFmu,
    check_components,
    ready_fmus,
)
from m4e_fmi.cosim.preparation.dependence_probing import probed
from m4e_fmi.cosim.preparation.state_trials import without_forgetful, without_refused
from m4e_fmi.cosim.scenario.plan import scenario_problems
from m4e_fmi.cosim.system.component import HERE, OWN, Component, FmuFile, answers
from m4e_fmi.cosim.system.component_steps import pace
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.cosim.wiring.added_mass import without_added_mass
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.missing import loose_ends, unconnected_parameters
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.cosim.wiring.structure import analyse, broken, with_stated
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.archives import ERRORS
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.export.build_record import read_record
from m4e_fmi.fmu.export.native_fmu import shell_binaries
from m4e_fmi.fmu.importer.opening import opened, replaced
from m4e_fmi.fmu.importer.reading import resized
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.threads import ONE_RUN


def prepare(
    system: System | str | Path,
    *,
    build_directory: str | Path = "build",
    native: bool | None = None,
    tell: Callable[[str], None] | None = None,
    drafts: Mapping[str, Draft] | None = None,
    fmus: Mapping[str, ReadyFmu] | None = None,
) -> Prepared:
    """Build missing FMUs (`native` or not: see `fmu_files`), read the FMUs, connect them.

    `system` may be the path of a system's file, whose notes `tell` receives. `drafts` are those
    of a system whose inputs have been checked (`waiting`), `fmus` the FMUs of all components if
    they exist already.

    InputError with all problems of the FMU files, else of connections and start values, else of
    components' own steps, else of the scenario; RunError for a build that failed, or without the C
    library. `tell` receives a line per step of a build. FMUs that declare no dependencies and have
    connected inputs are probed (`dependence_probing`), and foreign ones that say they can go back,
    or take derivatives of inputs, are tried (`state_trials`).
    """
    with ONE_RUN:
        system = _as_system(system, tell)
        check_components(system)
        loop_library()
        doubts: list[str] = []

        def listen(line: str) -> None:
            if f": {WARNING}" in line or ": note: " in line:
                doubts.append(line)
            if tell:
                tell(line)

        if fmus is None:
            fmus = ready_fmus(system, build_directory, native=native, tell=listen, drafts=drafts)
        descriptions = described(system, fmus)
        wiring = connect(system, descriptions)
        rates = pace(system, descriptions)
        InputError.raise_for(scenario_problems(system, descriptions, wiring))
        apart, missing = available(system, hosts(system, descriptions))
        descriptions = with_stated(system, descriptions)
        with setting_up():
            descriptions, found = probed(system, descriptions, wiring, apart)
            descriptions, forgetful = without_forgetful(system, descriptions, wiring, apart)
            descriptions, refused = without_refused(system, descriptions, wiring, apart)
        wiring, late = broken(descriptions, wiring, rates)
        structure = analyse(descriptions, wiring)
        warnings = (
            *missing,
            *forgetful,
            *unconnected_parameters(system, descriptions, wiring),
            *without_added_mass(descriptions, wiring),
            *loose_ends(system, descriptions, wiring),
            *answers(
                system.components, descriptions, lambda k: k.doubts, system, descriptions, wiring
            ),
        )
        notes = (*doubts, *wiring.notes, *found, *refused, *late)
        prepared = Prepared(system, descriptions, wiring, structure, rates, apart, notes, warnings)
        return prepared.recording()


def described(system: System, fmus: Mapping[str, ReadyFmu]) -> dict[str, Description]:
    """Descriptions of the FMUs by component; InputError with all problems of the files."""
    problems: list[Problem] = []
    descriptions: dict[str, Description] = {}
    read = cache(read_description)  # many components may be of one file
    for component in system.components:
        try:
            fmu = fmus[component.name]
            description = resized(read(fmu.path), component.start)
            if fmu.content not in ("", description.content):
                raise replaced(fmu.path)
            descriptions[component.name] = component.described(description)
        except InputError as error:
            problems += error.problems
    InputError.raise_for(problems)
    return descriptions


def _as_system(given: object, tell: Callable[[str], None] | None) -> System:
    """The System itself, or that in the file at a path; InputError for anything else."""
    if isinstance(given, System):
        return given
    if not isinstance(given, str | Path):
        kind = type(given).__name__
        raise InputError.single(f"expected a System, or the path of a system file; got {kind}")
    system = load_system(given)
    if tell:
        for note in system.notes:
            tell(f"{given}: {note}")
    return system


def hosts(system: System, descriptions: Mapping[str, Description]) -> dict[str, Host]:
    """The conditions for each component that runs in a process of its own, by name."""
    files = {d.path: d for d in descriptions.values()}
    known = cache(lambda path: read_record(path) is not None or _has_our_library(files[path]))

    def is_apart(component: Component) -> bool:
        if component.process:
            return component.process != HERE
        path = descriptions[component.name].path
        return isinstance(component.source, FmuFile) and not known(path)

    return {c.name: system.processes.host for c in system.components if is_apart(c)}


def available(system: System, hosts: Mapping[str, Host]) -> tuple[dict[str, Host], list[str]]:
    """All `hosts` if this machine can start processes, else no hosts and a warning.

    InputError if it cannot, and a component asks for a process or for limits.
    """
    if not hosts or hasattr(os, "fork"):
        return dict(hosts), []
    why = "this system has no fork, by which other processes are started"
    asking = [("components", c.name, "process") for c in system.components if c.process == OWN]
    asking += [("limits",)] if system.processes.limits else []
    if asking:
        message = f"no FMU can have a process of its own: {why}"
        remedy = "leave this out, or run the system on another machine"
        raise InputError([system.problem(place, message, remedy) for place in asking])
    return {}, [f"{', '.join(hosts)}: run in this process, where a fault of an FMU ends all: {why}"]


def _has_our_library(description: Description) -> bool:
    """True if the library for this machine is that of native FMUs."""
    path = description.path
    fmi3 = description.version == "3.0"
    folder = fmpy.platform_tuple if fmi3 else fmpy.platform
    name = f"binaries/{folder}/{description.identifier}{fmpy.sharedLibraryExtension}"
    try:
        ours = shell_binaries(description.identifier, fmi="3" if fmi3 else "2").get(name)
    except RunError:
        return False
    try:
        with opened(path, description.content) as file, ZipFile(file) as archive:
            return ours is not None and name in archive.namelist() and archive.read(name) == ours
    except ERRORS:  # damaged, which is told where it is unpacked
        return False
