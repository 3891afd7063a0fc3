"""From a System to results: prepare it, run it or step it, and judge the run by a second one."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.checkpoint.container import checkpoint_of
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.error_estimate.report import ONE_LENGTH, Trace, compared
from m4e_fmi.cosim.exchange.fmu_log import Warn
from m4e_fmi.cosim.master.begun import Options, begun_run
from m4e_fmi.cosim.master.master import Observer
from m4e_fmi.cosim.master.outcome import Outcome
from m4e_fmi.cosim.master.recording import scene_of, thinned, with_followed
from m4e_fmi.cosim.master.resume import Resumed
from m4e_fmi.cosim.master.second_run import finer, second_run
from m4e_fmi.cosim.master.stepwise import Execution
from m4e_fmi.cosim.master.ticking import Progress
from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.system.simulation import CHECKPOINTS
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import stream_of
from m4e_fmi.threads import ONE_RUN


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
    animated: bool = False,
    certify: bool = True,
) -> Outcome:
    """Co-simulate `system`, or that in the file at a path, from its start to its stop time.

    Other times, steps and start values are those of ``system.changed(stop_time=…, start={…})``.
    `results` is the file to write (None: none): netCDF, which grows with the run, or `.csv`,
    written beside it at the end. `variables` choose what it holds, as ``buoy.*``; all
    scalar Real outputs if empty. `animated` adds those that an animation follows, as the nodes of
    mooring lines. Each of `observers` is called as ``observer(time, network)`` at the start and
    after every step, `progress` as ``progress(time)`` about ten times a second, `warn` with a line
    for each warning of the outcome, and for each kind of warning or error that an FMU logs, when it
    first does. With `check`, the system runs once more at half the step (and an eighth of the
    coupling tolerance), and the outcome has `checked`. Without `certify` it has
    no certificate, and makes no step twice.

    RunError names component, variable and time; the results up to there are then on disk, as they
    are after KeyboardInterrupt, and after SIGTERM, which raises Terminated (a SystemExit). Results
    that would be huge with a row per step have fewer, which `tell` receives and the notes tell.
    RunError before the first step if another run writes to the same file. The files `beside`, as
    earlier pictures, are removed when its results are replaced, as are those in the form that
    `results` is to have. ExportError, which has the outcome, if all is done but the `.csv`
    cannot be written.

    A simulation with `checkpoint_interval` or `checkpoint_wall_interval` takes checkpoints beside
    the results, in a file with `.checkpoint` behind its name, also at its end and where a signal
    ends it. With `resume`, the run goes on from there, or from the checkpoint of that path, as if
    it had not been interrupted: `results` get the same rows from the start on. Observers are called
    from there on, unless the run is made again up to there, which `tell` receives. InputError if
    the checkpoint is missing, damaged, or of another run; RunError for other values on the way.

    In one process there is one run at a time: a second thread waits. Runs side by side are made by
    processes, as those of a study.
    """
    with ONE_RUN:
        resumed = begun_at(results, resume, check=check, watched=bool(observers), warn=warn)
        ready, given = _ready(system, results, variables, build_directory, tell, animated=animated)
        options = replace(
            given,
            watched=bool(observers),
            warn=warn,
            tell=tell,
            beside=beside,
            resumed=resumed,
            certify=certify,
        )
        options.warn_of([*ready.warnings, *_no_checkpoints(ready, options)])
        return (_checked if check else _once)(ready, options, observers, progress)


@contextmanager
def start(
    system: System | Prepared | str | Path,
    *,
    results: str | Path | None = None,
    build_directory: str | Path = "build",
    tell: Callable[[str], None] | None = None,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
    certify: bool = True,
) -> Generator[Execution]:
    """A run that the block of ``with start(system) as run`` steps, from the start time.

    Arguments are those of `run`. The block may end before the stop time; `Execution.outcome` then
    reports the run up to there, its certificate too: along the steps that led there.
    """
    prepared, given = _ready(system, results, variables, build_directory, tell)
    options = replace(given, certify=certify, changeable=True, warn=warn)
    options.warn_of(_no_checkpoints(prepared, options))
    with begun_run(prepared, options) as begun:
        master, writer = begun.master, begun.results
        execution = Execution(master, prepared.descriptions, prepared.wiring)
        master.begin(writer, singly=True)
        try:
            yield execution
        finally:
            execution.end()
        if writer and not master.done:
            writer.close(f"stopped at t = {master.network.time:.9g} s")
    execution.end(begun.outcome)


def _ready(
    system: System | Prepared | str | Path,
    results: str | Path | None,
    variables: Sequence[str],
    build_directory: str | Path,
    tell: Callable[[str], None] | None,
    *,
    animated: bool = False,
) -> tuple[Prepared, Options]:
    """The prepared system, with the settings of its results, and the options that they give."""
    if not isinstance(system, Prepared):
        system = prepare(system, build_directory=build_directory, tell=tell)
    if results is None:
        return system, Options(variables=variables)
    scene = scene_of(system)
    if animated:
        variables = with_followed(system, variables, scene)
    options = Options(results=results, scene=scene, variables=variables)
    return thinned(system, variables, tell), options


def _no_checkpoints(system: Prepared, options: Options) -> list[str]:
    """The warning of a run that takes none of the checkpoints that its settings ask for."""
    asked = [name for name in CHECKPOINTS if getattr(system.system.simulation, name) is not None]
    if options.changeable:
        remedy = "use 'run', or 'save' of this run in between"
    elif options.results is None:
        remedy = "they lie beside results: give 'results'"
    else:
        return []
    return [f"{' and '.join(asked)}: no checkpoints are taken: {remedy}"] if asked else []


def _once(
    system: Prepared, options: Options, observers: Sequence[Observer], progress: Progress | None
) -> Outcome:
    with begun_run(system, options) as begun:
        begun.master.run(
            results=begun.results,
            observers=observers,
            progress=progress,
            checkpoints=begun.checkpoints,
            resumed=options.resumed,
        )
    assert begun.outcome
    return begun.outcome


def _checked(
    system: Prepared, options: Options, observers: Sequence[Observer], progress: Progress | None
) -> Outcome:
    """The outcome of a run, with its differences from a second one at finer steps."""
    again = finer(system)
    trace, finer_trace = Trace(), Trace()
    outcome = _once(system, replace(options, watched=True), [*observers, trace], progress)
    with second_run(outcome.path):
        _once(again, Options(watched=True, certify=False), [finer_trace], progress)
    halved = system.halved
    longer = {name: "" if name in halved else ONE_LENGTH for name in system.longer}
    found = compared(
        trace,
        finer_trace,
        system.system.connections,
        1 if halved else outcome.order,
        longer,
    )
    return replace(outcome, checked=found)


def begun_at(
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
