"""From a System to results: build what is missing, connect, check, run."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path

from m4e_fmi.cosim.certificate import Certificate, Trace, compared
from m4e_fmi.cosim.components import ready_fmus, with_units
from m4e_fmi.cosim.connect import Link, Wiring, connect
from m4e_fmi.cosim.delays import broken
from m4e_fmi.cosim.dependence import with_stated
from m4e_fmi.cosim.energy import BondEnergy
from m4e_fmi.cosim.execution import Execution
from m4e_fmi.cosim.forgotten import forgotten
from m4e_fmi.cosim.journal import FmuMessage, Warn
from m4e_fmi.cosim.loose_ends import loose_ends
from m4e_fmi.cosim.master import Master, Observer, Progress
from m4e_fmi.cosim.overview import overview
from m4e_fmi.cosim.pacing import Rates, pace, refined
from m4e_fmi.cosim.probing import probed
from m4e_fmi.cosim.results import AT_STOP, ResultsWriter
from m4e_fmi.cosim.selection import chosen
from m4e_fmi.cosim.structure import Structure, analyse
from m4e_fmi.cosim.system import SECOND, Component, Simulation, System
from m4e_fmi.cosim.timing import Timing, timings
from m4e_fmi.cosim.volume import thinned
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.opening import replaced
from m4e_fmi.fmu.reading import resized
from m4e_fmi.locks import claimed
from m4e_fmi.results import Results, check_export, export, load, stream_of
from m4e_fmi.shown import listing
from m4e_fmi.signals import Terminated, ending_cleanly


@dataclass(frozen=True)
class Prepared:
    """A system with its FMUs built, its connections resolved, its loops and own steps known.

    Its step is such that it meets the points of all components: `notes` tell if it was shortened.
    `warnings` tell what seems to be left out of the connections, one line each.
    """

    system: System
    descriptions: dict[str, Description] = field(repr=False)
    wiring: Wiring = field(repr=False)
    structure: Structure = field(repr=False)
    rates: Rates = field(repr=False)
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def timings(self) -> dict[Link, Timing]:
        """How late each connected input is, under the system's algorithm."""
        algorithm = self.system.simulation.algorithm
        return timings(self.descriptions, self.wiring, self.structure, algorithm, self.rates)

    def __str__(self) -> str:
        return overview(self)

    def __repr__(self) -> str:
        return listing(
            f"Prepared system {self.system.name!r}: {len(self.wiring.links)} connected variables",
            components=self.descriptions,
            connections=self.system.connections,
            notes=self.notes,
        )


@dataclass(frozen=True)
class Outcome:
    """A finished run: where its results are, its steps, wall time [s] and energy balance [J].

    `order` is that of the coupling, `rejected` steps were taken back and made again, smaller.
    `notes` tell what the algorithm did without because an FMU cannot, `warnings` what seems to be
    left out of the connections, and what grows without bound, one line each. `certificate`
    estimates the coupling errors; it is a text that tells why they are not known, where they are
    not. `checked` is a second estimate, by a run at half the step, if there was one. `messages` are
    the warnings and errors that FMUs have logged, one of each kind.
    """

    prepared: Prepared = field(repr=False)
    path: Path | None
    steps: int
    wall_time: float
    energy: tuple[BondEnergy, ...]
    order: int
    notes: tuple[str, ...] = ()
    rejected: int = 0
    certificate: Certificate | str = ""
    checked: Certificate | None = None
    messages: tuple[FmuMessage, ...] = ()
    warnings: tuple[str, ...] = ()

    def results(self) -> Results:
        """The results file, in memory."""
        if self.path is None:
            raise RunError("this run wrote no results", "give `results` to run")
        return load(self.path)

    def __repr__(self) -> str:
        return listing(
            f"Outcome of {self.prepared.system.name!r}: {self.steps} steps in "
            f"{self.wall_time:.3g} s, results in {str(self.path) if self.path else 'no file'}",
            certificate=[str(self.certificate)],
            energy=[bond.connection for bond in self.energy],
            notes=self.notes,
        )


def prepare(
    system: System | str | Path,
    *,
    build_directory: str | Path = "build",
    native: bool | None = None,
    tell: Callable[[str], None] | None = None,
) -> Prepared:
    """Build what is missing (`native` or not: see `fmu_files`), read the FMUs, connect them.

    `system` may be the path of a system's file, whose notes `tell` receives.

    InputError with all problems of the FMU files, then of connections, start values and components'
    own steps; RunError for a build that failed. `tell` receives a line per step of a build. FMUs
    that declare no dependencies, and so may be part of an algebraic loop, are probed (`probing`).
    """
    system = _as_system(system, tell)
    problems: list[Problem] = []
    descriptions: dict[str, Description] = {}
    fmus = ready_fmus(system, build_directory, native=native, tell=tell)
    read = cache(read_description)  # many components may be of one file
    for component in system.components:
        try:
            fmu = fmus[component.name]
            description = resized(read(fmu.path), component.start)
            if fmu.content not in ("", description.content):
                raise replaced(fmu.path)
            descriptions[component.name] = with_units(component, description)
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    wiring: Wiring | None = None
    try:
        wiring = connect(system, descriptions)
    except InputError as error:
        problems += error.problems
    try:
        paced, note = refined(system, descriptions)
        rates = pace(paced, descriptions)
    except InputError as error:
        raise InputError([*problems, *error.problems]) from None
    if wiring is None:
        raise InputError(problems)
    descriptions, found = probed(paced, with_stated(system, descriptions), wiring)
    wiring, late = broken(descriptions, wiring, rates)
    structure = analyse(descriptions, wiring)
    notes = (*([note] if note else []), *found, *late)
    missing = [find(system, descriptions, wiring) for find in (forgotten, loose_ends)]
    warnings = tuple(line for lines in missing for line in lines)
    return Prepared(paced, descriptions, wiring, structure, rates, notes, warnings)


def run(
    system: System | Prepared | str | Path,
    *,
    results: str | Path | None = None,
    build_directory: str | Path = "build",
    observers: Sequence[Observer] = (),
    progress: Progress | None = None,
    tell: Callable[[str], None] | None = None,
    check: bool = False,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
) -> Outcome:
    """Co-simulate `system`, or that in the file at a path, from its start to its stop time.

    `results` is the file to write (None: none): netCDF, which grows with the run, or `.csv` or
    `.parquet`, written beside it at the end. `variables` choose what it holds, as ``buoy.*``; all
    scalar Real outputs if empty. Each of `observers` is called as
    ``observer(time, network)`` at the start and after every step, `progress` as
    ``progress(time)`` about ten times a second, `warn` with a line for each connection that seems
    to be left out, and for each kind of warning or error that an FMU logs, when it first does. With
    `check`, the system runs once more at half the step (and an eighth of the coupling tolerance),
    and the outcome has `checked`. RunError names component, variable and time; the results up to
    there are then on disk, as they are after KeyboardInterrupt, and after SIGTERM, which raises
    Terminated (a SystemExit). Results that would be huge if every step were a row have fewer rows,
    which `tell` receives and the notes tell. RunError before the first step if another run writes
    to the same file.
    """
    if not isinstance(system, Prepared):
        system = prepare(system, build_directory=build_directory, tell=tell)
    if results is not None:
        system = _thinned(system, variables, tell)
    if warn:
        for line in system.warnings:
            warn(f"warning: {line}")
    return (_checked if check else _once)(
        system,
        results=results,
        observers=observers,
        progress=progress,
        variables=variables,
        warn=warn,
    )


@contextmanager
def start(
    system: System | Prepared | str | Path,
    *,
    results: str | Path | None = None,
    build_directory: str | Path = "build",
    tell: Callable[[str], None] | None = None,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
) -> Iterator[Execution]:
    """A run that the block of ``with start(system) as run`` steps, from the start time.

    Arguments are those of `run`. The block may end before the stop time; `Execution.outcome` then
    tells of the run up to there, its certificate too: of the course that led there.
    """
    if not isinstance(system, Prepared):
        system = prepare(system, build_directory=build_directory, tell=tell)
    if results is not None:
        system = _thinned(system, variables, tell)
    with _begun(system, results=results, variables=variables, changeable=True, warn=warn) as begun:
        master, writer = begun.master, begun.results
        execution = Execution(master, system.descriptions, system.wiring)
        master.begin(writer, singly=True)
        try:
            yield execution
        finally:
            execution.end()
        if writer and not master.done:
            writer.close(f"stopped at t = {master.network.time:.9g} s")
    execution.end(begun.outcome)


def _as_system(given: System | str | Path, tell: Callable[[str], None] | None) -> System:
    """The System itself, or that in the file at a path; InputError for anything else."""
    if isinstance(given, System):
        return given
    if not isinstance(given, str | Path):
        kind = type(given).__name__
        raise InputError.single(f"expected a System, or the path of a system file; got {kind}")
    system = System.load(given)
    if tell:
        for note in system.notes:
            tell(f"{given}: {note}")
    return system


def _once(
    system: Prepared,
    *,
    results: str | Path | None = None,
    observers: Sequence[Observer],
    progress: Progress | None,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
    certify: bool = True,
) -> Outcome:
    with _begun(
        system,
        results=results,
        variables=variables,
        certify=certify,
        watched=bool(observers),
        warn=warn,
    ) as begun:
        begun.master.run(results=begun.results, observers=observers, progress=progress)
    assert begun.outcome
    return begun.outcome


@dataclass
class _Begun:
    """A run with its results file, if there is one; `outcome` once both have ended, unless it has
    `failed`.
    """

    master: Master
    results: ResultsWriter | None = None
    outcome: Outcome | None = None
    failed: bool = False


@contextmanager
def _begun(
    system: Prepared,
    *,
    results: str | Path | None,
    variables: Sequence[str],
    certify: bool = True,
    changeable: bool = False,
    watched: bool = False,
    warn: Warn | None = None,
) -> Iterator[_Begun]:
    begun = clock.perf_counter()
    missing = () if changeable else system.warnings  # inputs may be set between the steps
    system = _at_home(system)
    parts = (system.system, system.descriptions, system.wiring, system.structure, system.rates)
    recorded: dict[str, list[str]] = {}
    if results is not None:
        members = chosen(system.descriptions, variables, system.wiring.sources)
        recorded = {name: [v.name for v in members] for name, members in members.items()}
    with ExitStack() as stack:
        stack.enter_context(ending_cleanly())
        place = stack.enter_context(_claimed(results)) if results is not None else None
        file = Path(results or "").absolute()
        master = stack.enter_context(
            Master(
                *parts,
                certify=certify,
                changeable=changeable,
                recorded=recorded,
                watched=watched,
                warn=warn,
            )
        )
        found = _Begun(master)
        settings = system.system.simulation
        if place is None or results is None:
            with _interruptible(found, settings):
                yield found
        else:
            attributes = _attributes(system)
            writer = ResultsWriter(
                place,
                master.network,
                attributes,
                variables=variables,
                closing=lambda: _closing(master, certify=certify and not found.failed),
            )
            found.results = writer
            with _exported(file, Path(results), writer), writer:
                try:
                    with _interruptible(found, settings):
                        yield found
                except BaseException:
                    found.failed = True
                    raise
                if master.ended:
                    writer.close(master.ended)
        found.outcome = Outcome(
            prepared=system,
            path=None if results is None else stream_of(results),
            steps=master.steps,
            wall_time=clock.perf_counter() - begun,
            energy=master.energy,
            notes=(*system.notes, *master.notes, *(found.results.notes if found.results else ())),
            order=master.order,
            rejected=master.rejected,
            certificate=master.certificate() if certify else "",
            messages=master.messages,
            warnings=(*missing, *master.warnings),
        )


def _thinned(
    prepared: Prepared, variables: Sequence[str], tell: Callable[[str], None] | None
) -> Prepared:
    """The same, with an output interval if the results would be huge.

    What is told: results that are large, and such as have nothing but the time.
    """
    simulation, connected = prepared.system.simulation, prepared.wiring.sources
    settings, note = thinned(simulation, prepared.descriptions, variables, connected)
    if not any(chosen(prepared.descriptions, variables, connected).values()):
        note = (
            "the results have no column but time: there is no scalar output and no connected "
            "array; choose what to record by variables (--variables)"
        )
    if not note:
        return prepared
    if tell:
        tell(note)
    system = replace(prepared.system, simulation=settings)
    return replace(prepared, system=system, notes=(*prepared.notes, note))


def _at_home(system: Prepared) -> Prepared:
    """The same, with files that are found from any folder: FMUs may change that of the process."""
    found = {n: replace(d, path=d.path.absolute()) for n, d in system.descriptions.items()}
    return replace(system, descriptions=found)


@contextmanager
def _claimed(results: str | Path) -> Iterator[Path]:
    """Where the results are streamed to, absolute; InputError or RunError before any work."""
    check_export(results)
    with claimed(stream_of(results)) as place:
        yield place


def _closing(master: Master, *, certify: bool) -> dict[str, str]:
    """Attributes of the results that are known at the end of the run.

    These are the warnings and errors of FMUs, a line each, and how large the coupling errors are.
    """
    lines = "\n".join(map(str, master.messages))
    found = {"messages": lines} if lines else {}
    if certify:
        certificate = master.certificate()
        found["coupling_error"] = str(certificate) or "not known"
        if isinstance(certificate, Certificate) and certificate.coverage:
            found["coupling_error_from"] = str(certificate.coverage)
    return found


def _attributes(prepared: Prepared) -> dict[str, str]:
    system, settings = prepared.system, prepared.system.simulation
    interval = settings.output_interval
    parts = system.components
    starts = {f"{part.name}.{name}": given for part in parts for name, given in part.start.items()}
    changed = {**starts, **asdict(settings)}
    return {
        "title": system.name,
        "comment": system.description,
        "algorithm": settings.algorithm,
        "step_size": f"{settings.step_size:g} s",
        "output_interval": "every step" if interval is None else f"{interval:g} s",
        "start_values": "\n".join(f"{name} = {given}" for name, given in starts.items()),
        "changed": "\n".join(
            f"{name} = {changed[name]} ({origin.name})" for name, origin in system.origins.items()
        ),
        "notes": "\n".join(prepared.notes),
    }


@contextmanager
def _exported(file: Path, given: Path, writer: ResultsWriter) -> Iterator[None]:
    """Writes the results to `file`, however the run ends, and tells how far they go."""
    try:
        yield
    except RunError as error:
        note = _kept(file, given, writer)
        raise RunError(error.message, f"{error.remedy}; {note}".strip("; ")) from error
    except BaseException as error:
        if note := _kept(file, given, writer):
            error.add_note(note)
        raise
    export(writer.path, file)


def _kept(file: Path, given: Path, writer: ResultsWriter) -> str:
    """Export the results of a run that did not reach its end; what there is, as text."""
    if writer.saved is None:
        old = file.is_file() and "the run made no step: {} is as it was"
        return old.format(given) if old else ""
    rows, last = writer.saved
    until = f"results until t = {last:.9g} s are in"
    try:
        export(writer.path, file)
    except RunError as error:
        return f"{until} {stream_of(given)} ({_count(rows)}); {error.message}"
    return f"{until} {given} ({_count(rows)})"


def _count(rows: int) -> str:
    return f"{rows:,} row{'s' * (rows != 1)}"


@contextmanager
def _interruptible(begun: _Begun, settings: Simulation) -> Iterator[None]:
    """Ctrl-C and signals get a note of the time reached; results with all rows are complete."""
    try:
        yield
    except (KeyboardInterrupt, Terminated) as error:
        begun.failed = True
        time, stop = begun.master.network.time, settings.stop_time
        note = f"at t = {time:.9g} s of {stop:.9g} s"
        if round(time * SECOND) >= round(stop * SECOND):
            note = f"at the stop time, t = {stop:.9g} s"
            if begun.results:
                begun.results.close(AT_STOP)
        error.add_note(note)
        raise


def _checked(
    prepared: Prepared,
    *,
    results: str | Path | None,
    observers: Sequence[Observer],
    progress: Progress | None,
    variables: Sequence[str],
    warn: Warn | None,
) -> Outcome:
    """A run, and the certificate that a second one at half the step gives it."""
    system = prepared.system
    again = _finer(prepared)
    trace, finer_trace = Trace(), Trace()
    watched = [*observers, trace]
    outcome = _once(
        prepared,
        results=results,
        observers=watched,
        progress=progress,
        variables=variables,
        warn=warn,
    )
    with _second_run(outcome.path):
        _once(again, observers=[finer_trace], progress=progress, certify=False)
    found = compared(trace, finer_trace, system.connections, outcome.order)
    return replace(outcome, checked=found)


@contextmanager
def _second_run(results: Path | None) -> Iterator[None]:
    """Ctrl-C and signals get a note that it is not the first run which they end."""
    try:
        yield
    except (KeyboardInterrupt, Terminated) as error:
        error.add_note("that was the second run, at half the step")
        if results:
            error.add_note(f"the results of the first are complete, in {results}")
        raise


def _finer(prepared: Prepared) -> Prepared:
    """The same at half the step, which components that make several steps in each halve too.

    Those that step more rarely keep their step: it is what they are, and not how they are computed.
    InputError for an FMU that makes steps of one size only.
    """
    system = prepared.system
    settings, tolerance = system.simulation, system.simulation.coupling_tolerance
    parts: list[Component] = []
    for part in system.components:
        rate = prepared.rates.get(part.name)
        if rate and not rate.shortens:
            raise InputError.single(
                f"--check runs at half the step, which {part.name} cannot: it {rate}",
                "leave it out: what each run tells of its error needs no other step",
            )
        halved = prepared.descriptions[part.name].internal_step is None
        if rate and halved and part.step_size is not None and not rate.is_sampled:
            part = replace(part, step_size=rate.step / 2)
        parts.append(part)
    simulation = replace(
        settings,
        step_size=settings.step_size / 2,
        output_interval=settings.output_interval or settings.step_size,
        coupling_tolerance=None if tolerance is None else tolerance / 8,
    )
    finer = replace(system, components=tuple(parts), simulation=simulation)
    rates = pace(finer, prepared.descriptions)
    return replace(prepared, system=finer, rates=rates)
