"""From a System to results: prepare it, run it or step it, and judge the run by a second one."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from m4e_fmi.cosim.checkpoint.container import checkpoint_of
from m4e_fmi.cosim.checkpoint.identity import identity
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.recorded_variables import chosen
from m4e_fmi.cosim.error_estimate.report import Trace, compared
from m4e_fmi.cosim.exchange.fmu_log import Warn
from m4e_fmi.cosim.master.checkpoints import Checkpoints, checkpoints, resumable
from m4e_fmi.cosim.master.master import Master, Observer
from m4e_fmi.cosim.master.outcome import ExportError, Outcome
from m4e_fmi.cosim.master.real_time import NO_ESTIMATE, RealTime
from m4e_fmi.cosim.master.recording import (
    attributes_of,
    closing_attributes,
    export_whole,
    kept,
    place_of,
    thinned,
    whole,
)
from m4e_fmi.cosim.master.resume import Resumed
from m4e_fmi.cosim.master.second_run import finer, second_run
from m4e_fmi.cosim.master.stepwise import Execution
from m4e_fmi.cosim.master.ticking import Progress
from m4e_fmi.cosim.monitoring.flotation import start_warnings
from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.preparation.surroundings import model_gravity
from m4e_fmi.cosim.results.writer import AT_STOP, ResultsWriter
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.results.results_file import as_given, stream_of
from m4e_fmi.signals import Terminated, ending_cleanly, held, let_through


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
    beside: Sequence[Path] = (),
    resume: bool | str | Path = False,
    real_time: float | None = None,
) -> Outcome:
    """Co-simulate `system`, or that in the file at a path, from its start to its stop time.

    `results` is the file to write (None: none): netCDF, which grows with the run, or `.csv` or
    `.parquet`, written beside it at the end. `variables` choose what it holds, as ``buoy.*``; all
    scalar Real outputs if empty. Each of `observers` is called as
    ``observer(time, network)`` at the start and after every step, `progress` as
    ``progress(time)`` about ten times a second, `warn` with a line for each warning of the outcome,
    and for each kind of warning or error that an FMU logs, when it first does. With
    `check`, the system runs once more at half the step (and an eighth of the coupling tolerance),
    and the outcome has `checked`. With `real_time`, simulated seconds per second, no communication
    point is passed before its wall time, and the outcome has the lateness, but no certificate.

    RunError names component, variable and time; the results up to there are then on disk, as they
    are after KeyboardInterrupt, and after SIGTERM, which raises
    Terminated (a SystemExit). Results that would be huge if every step were a row have fewer rows,
    which `tell` receives and the notes tell. RunError before the first step if another run writes
    to the same file. The files `beside`, as pictures of an earlier run, are removed when its
    results are replaced, as are those in the form that `results` is to have. ExportError, which has
    the outcome, if all is done but the `.csv` or `.parquet` cannot be written.

    A simulation with `checkpoint_interval` or `checkpoint_wall_interval` takes checkpoints beside
    the results, in a file with `.checkpoint` behind its name, also at its end and where a signal
    ends it. With `resume`, the run goes on from there, or from the checkpoint of that path, as if
    it had not been interrupted: `results` get the same rows from the start on. Observers are called
    from there on, unless the run is made again up to there, which `tell` receives. InputError if
    the checkpoint is missing, damaged, or of another run; RunError if a run that is made again
    comes to other values.
    """
    resumed = _checkpoint(results, resume, check=check, watched=bool(observers), warn=warn)
    if not isinstance(system, Prepared):
        system = prepare(system, build_directory=build_directory, tell=tell)
    if results is not None:
        system = thinned(system, variables, tell)
    _tell(warn, system.warnings)
    first = partial(
        _once,
        system,
        results=results,
        progress=progress,
        variables=variables,
        warn=warn,
        beside=beside,
        resumed=resumed,
        tell=tell,
        paced=None if real_time is None else RealTime(real_time),
    )
    if not check:
        return first(observers=observers)
    again = finer(system)
    trace, finer_trace = Trace(), Trace()
    outcome = first(observers=[*observers, trace])
    with second_run(outcome.path):
        _once(again, observers=[finer_trace], progress=progress, certify=False)
    found = compared(trace, finer_trace, system.system.connections, outcome.order)
    return replace(outcome, checked=found)


@contextmanager
def start(
    system: System | Prepared | str | Path,
    *,
    results: str | Path | None = None,
    build_directory: str | Path = "build",
    tell: Callable[[str], None] | None = None,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
) -> Generator[Execution]:
    """A run that the block of ``with start(system) as run`` steps, from the start time.

    Arguments are those of `run`. The block may end before the stop time; `Execution.outcome` then
    reports the run up to there, its certificate too: along the steps that led there.
    """
    if not isinstance(system, Prepared):
        system = prepare(system, build_directory=build_directory, tell=tell)
    if results is not None:
        system = thinned(system, variables, tell)
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


def _once(
    system: Prepared,
    *,
    results: str | Path | None = None,
    observers: Sequence[Observer],
    progress: Progress | None,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
    beside: Sequence[Path] = (),
    certify: bool = True,
    resumed: Resumed | None = None,
    tell: Callable[[str], None] | None = None,
    paced: RealTime | None = None,
) -> Outcome:
    waits = [paced] if paced else []
    with _begun(
        system,
        results=results,
        variables=variables,
        certify=certify,
        watched=bool(observers),
        warn=warn,
        beside=beside,
        resumed=resumed,
        tell=tell,
        paced=paced,
    ) as begun:
        begun.master.run(
            results=begun.results,
            observers=[*waits, *observers],
            progress=progress,
            checkpoints=begun.checkpoints,
            resumed=resumed,
        )
    assert begun.outcome
    return begun.outcome


@dataclass
class _Begun:
    """A run of a system with its results file, if there is one.

    It has the `outcome` once both have ended, unless the run has `failed`.
    """

    master: Master
    system: Prepared
    results: ResultsWriter | None = None
    checkpoints: Checkpoints | None = None
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
    beside: Sequence[Path] = (),
    resumed: Resumed | None = None,
    tell: Callable[[str], None] | None = None,
    paced: RealTime | None = None,
) -> Generator[_Begun]:
    """A run that the block makes; its outcome and its export follow the block."""
    start_time = clock.perf_counter()
    missing = () if changeable else system.warnings  # inputs may be set between the steps
    system = _at_home(system)
    recorded: dict[str, list[str]] = {}
    if results is not None:
        members = chosen(system.descriptions, variables, system.wiring.sources)
        recorded = {name: [v.name for v in members] for name, members in members.items()}
    with ExitStack() as stack:
        complete = stack.enter_context(_told_if_complete())
        stack.enter_context(ending_cleanly())
        place = stack.enter_context(place_of(results)) if results is not None else None
        same = identity(system, recorded, certify=certify)
        if resumed:
            resumed.check(same, system.system.simulation.stop_time)
            resumed.tell(tell)
        given = Path(results or "")
        file = given.absolute()
        master = stack.enter_context(
            Master(
                system,
                certify=certify and paced is None,
                changeable=changeable,
                recorded=recorded,
                watched=watched or (resumed is not None and resumed.head.watched),
                warn=resumed.at_once if resumed else warn,
            )
        )
        if resumed:
            resumed.bring_texts(master.network)
        begun = _Begun(master, system)
        gravity = partial(model_gravity, system.system, system.descriptions)
        floats = start_warnings(master.network, system.wiring, gravity)
        _tell(warn, floats)
        writer = None
        if place is None:
            with _timed(begun):
                yield begun
            complete[:] = [_reached(begun)]
        else:
            own = checkpoint_of(place)
            writer = begun.results = ResultsWriter(
                place,
                master.network,
                attributes_of(system),
                variables=variables,
                closing=lambda: {
                    **closing_attributes(master, system, certify=certify and not begun.failed),
                    **({"real_time": str(paced.lateness)} if paced else {}),
                },
                beside=[path.absolute() for path in (file, *beside) if path.resolve() != place],
                earlier=[] if resumed and resumed.path == own else [own],
                begun=resumed.rows if resumed else None,
            )
            if system.system.simulation.has_checkpoints and not changeable:
                begun.checkpoints = checkpoints(system, place, same, tell=tell, warn=warn)
                if resumed:
                    begun.checkpoints.go_on(resumed.path, resumed.head.time)
            with (
                resumable(begun.checkpoints),
                kept(file, given, writer),
                _timed(begun),
                held(),
                writer,
            ):
                with _recorded(begun), let_through():
                    yield begun
                if master.ended:
                    writer.close(master.ended)
            complete[:] = [_reached(begun), whole(file, given, writer)]
        late = (*master.warnings, *(writer.warnings if writer else ()))
        _tell(warn, late)
        outcome = _outcome(begun, clock.perf_counter() - start_time, given, certify=certify)
        if paced:
            certificate = outcome.certificate or NO_ESTIMATE
            outcome = replace(outcome, certificate=certificate, real_time=paced.lateness)
        begun.outcome = replace(outcome, warnings=(*missing, *floats, *late))
        if writer:
            try:
                export_whole(file, given, writer)
            except RunError as error:
                raise ExportError(error, begun.outcome) from error
            complete[1:] = [whole(file, given, writer, exported=True)]


def _checkpoint(
    results: str | Path | None,
    resume: bool | str | Path,
    *,
    check: bool,
    watched: bool,
    warn: Warn | None,
) -> Resumed | None:
    """The checkpoint at which a run is to begin, if so; InputError if there is none."""
    if resume is False:
        return None
    if results is None:
        message = "a run that goes on from a checkpoint needs a file of results"
        raise InputError.single(message, "give `results`")
    path = checkpoint_of(stream_of(results)) if resume is True else Path(resume)
    return Resumed.at(path.absolute(), check=check, watched=watched, warn=warn)


def _tell(warn: Warn | None, lines: Sequence[str]) -> None:
    """Call `warn` with each of some warnings."""
    if warn:
        for line in lines:
            warn(f"warning: {line}")


def _outcome(begun: _Begun, wall_time: float, given: Path, *, certify: bool) -> Outcome:
    """The outcome of a run that has ended, without its warnings; `given` is the results file."""
    master, writer = begun.master, begun.results
    return Outcome(
        prepared=begun.system,
        path=as_given(stream_of(given), writer.path) if writer else None,
        steps=master.steps,
        wall_time=wall_time,
        energy=master.energy,
        notes=(*begun.system.notes, *master.notes, *(writer.notes if writer else ())),
        order=master.order,
        rejected=master.rejected,
        certificate=master.certificate() if certify else "",
        messages=master.messages,
        scenario=master.scenario,
    )


def _at_home(system: Prepared) -> Prepared:
    """The same, with files that are found from any folder: FMUs may change that of the process."""
    found = {n: replace(d, path=d.path.absolute()) for n, d in system.descriptions.items()}
    return replace(system, descriptions=found)


@contextmanager
def _recorded(begun: _Begun) -> Generator[None]:
    """Results of a run that has made all its steps are complete, however it ends."""
    try:
        yield
    except BaseException as error:
        begun.failed = True
        asked = isinstance(error, KeyboardInterrupt | Terminated)
        if asked and begun.results and _is_at_stop(begun):
            begun.results.close(AT_STOP)
        raise


@contextmanager
def _timed(begun: _Begun) -> Generator[None]:
    """Ctrl-C and signals get a note of the time reached."""
    try:
        yield
    except (KeyboardInterrupt, Terminated) as error:
        error.add_note(_reached(begun))
        raise


@contextmanager
def _told_if_complete() -> Generator[list[str]]:
    """Ctrl-C and signals that have no notes get those of this list, which is for a complete run."""
    notes: list[str] = []
    try:
        yield notes
    except (KeyboardInterrupt, Terminated) as error:
        for note in () if getattr(error, "__notes__", ()) else notes:
            error.add_note(note)
        raise


def _is_at_stop(begun: _Begun) -> bool:
    stop_time = begun.system.system.simulation.stop_time
    return round(begun.master.network.time * NS_PER_SECOND) >= round(stop_time * NS_PER_SECOND)


def _reached(begun: _Begun) -> str:
    """The present time of a run, as a note."""
    stop = f"{begun.system.system.simulation.stop_time:.9g} s"
    if _is_at_stop(begun):
        return f"at the stop time, t = {stop}"
    return f"at t = {begun.master.network.time:.9g} s of {stop}"
