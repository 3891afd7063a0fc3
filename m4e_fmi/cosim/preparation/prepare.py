"""From a System to one that can run: build what is missing, read the FMUs, connect, check."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

from m4e_fmi.cosim.connections.added_mass import without_added_mass
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.connections.missing import loose_ends, unconnected_parameters
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.structure import analyse, broken, with_stated
from m4e_fmi.cosim.exchange.schedule import loop_library
from m4e_fmi.cosim.preparation.components import Draft, ReadyFmu, check_components, ready_fmus
from m4e_fmi.cosim.preparation.dependence_probing import probed
from m4e_fmi.cosim.preparation.doubtful_values import (
    differing,
    double_buoyancy,
    double_drag,
    reversed_forces,
    start_values_without_effect,
    within_ramps,
)
from m4e_fmi.cosim.preparation.hosts import available, hosts
from m4e_fmi.cosim.preparation.state_trials import without_forgetful, without_refused
from m4e_fmi.cosim.scenario.plan import scenario_problems
from m4e_fmi.cosim.system.component_steps import pace, refined, rounded
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.importer.opening import replaced
from m4e_fmi.fmu.importer.reading import resized
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
    """Build what is missing (`native` or not: see `fmu_files`), read the FMUs, connect them.

    `system` may be the path of a system's file, whose notes `tell` receives. `drafts` are those
    of a system whose inputs have been checked (`waiting`), `fmus` the FMUs of all components if
    they are there already.

    InputError with all problems of the FMU files, else of connections and start values, else of
    components' own steps, else of the scenario; RunError for a build that failed, or without the C
    library. `tell` receives a line per step of a build. FMUs that declare no dependencies and have
    connected inputs are probed (`probing`), and foreign ones that say they can go back, or take
    derivatives of inputs, are tried (`state_trials`).
    """
    with ONE_RUN:
        system = _as_system(system, tell)
        check_components(system)
        loop_library()
        if fmus is None:
            fmus = ready_fmus(system, build_directory, native=native, tell=tell, drafts=drafts)
        descriptions = described(system, fmus)
        wiring = connect(system, descriptions)
        paced, finer = refined(system, descriptions)
        rates = pace(paced, descriptions)
        if problems := scenario_problems(paced, descriptions, wiring):
            raise InputError(problems)
        apart, missing = available(system, hosts(system, descriptions))
        descriptions, found = probed(paced, with_stated(system, descriptions), wiring, apart)
        descriptions, forgetful = without_forgetful(paced, descriptions, wiring, apart)
        descriptions, refused = without_refused(paced, descriptions, wiring, apart)
        wiring, late = broken(descriptions, wiring, rates)
        structure = analyse(descriptions, wiring)
        warnings = (
            *missing,
            *forgetful,
            *unconnected_parameters(system, descriptions, wiring),
            *without_added_mass(descriptions, wiring),
            *loose_ends(system, descriptions, wiring),
            *differing(system, descriptions, wiring),
            *double_drag(system, descriptions, wiring),
            *double_buoyancy(system, wiring),
            *start_values_without_effect(system, wiring, structure),
            *reversed_forces(system, descriptions, wiring),
            *within_ramps(system, descriptions),
        )
        notes = (*rounded(system.simulation), *finer, *wiring.notes, *found, *refused, *late)
        prepared = Prepared(paced, descriptions, wiring, structure, rates, apart, notes, warnings)
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
    if problems:
        raise InputError(problems)
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
