"""From a System to results: prepare it, run it or step it."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.network.fmu_log import Warn
from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.results.system_scene import system_scene
from m4e_fmi.cosim.run.checkpoint import (
    Checkpoint,
    checkpoint_of,
    read_checkpoint,
    results_of,
)
from m4e_fmi.cosim.run.execution import Execution
from m4e_fmi.cosim.run.outcome import Outcome
from m4e_fmi.cosim.run.run import Observer, RunOptions
from m4e_fmi.cosim.run.running import running, without_checkpoints
from m4e_fmi.cosim.system.simulation import CHECKPOINTS
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.prepared import LARGE, Prepared, volume
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import stream_of
from m4e_fmi.threads import ONE_RUN


def run(
    system: System | Prepared | str | Path,
    *,
    results: str | Path | None = None,
    build_directory: str | Path = "build",
    observers: Sequence[Observer] = (),
    progress: Callable[[float], None] | None = None,
    tell: Callable[[str], None] | None = None,
    variables: Sequence[str] = (),
    warn: Warn | None = None,
    beside: Sequence[str | Path] = (),
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
    first does. Without `certify` the outcome has no certificate, and no step is made twice.

    RunError names component, variable and time; the results up to there are then on disk, as they
    are after KeyboardInterrupt, and after SIGTERM, which raises Terminated (a SystemExit).
    RunError before the first step if another run writes to the same file. The files `beside`, as
    earlier pictures, are removed when its results are replaced, as are those in the form that
    `results` is to have. ExportError, which has the outcome, if all is done but the `.csv`
    cannot be written.

    A simulation with `checkpoint_interval` or `checkpoint_wall_interval` takes checkpoints beside
    the results, in a file with `.checkpoint` behind its name, also at its end and where a signal
    ends it. With `resume`, the run goes on from there, or from the checkpoint of that path, as if
    it had not been interrupted: `results` get the same rows from the start on. InputError if the
    checkpoint is missing, damaged, or of another run. With observers, or FMUs that cannot save
    their state for another process, there are no checkpoints, which `warn` receives.

    In one process there is one run at a time: a second thread waits. Runs side by side are made by
    processes, as those of a study.
    """
    with ONE_RUN:
        checkpoint = checkpoint_to_resume(results, resume)
        ready, given = _ready(system, results, variables, build_directory, tell, animated=animated)
        options = replace(
            given,
            certify=certify,
            observers=observers,
            watched=bool(observers),
            progress=progress,
            warn=warn,
            tell=tell,
            beside=list(map(Path, beside)),
            checkpoint=checkpoint,
        )
        options.warn_of([*ready.warnings, *_no_checkpoints(ready, options)])
        with running(ready, options) as made:
            made.finish()
        assert made.outcome
        return made.outcome


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
    with running(prepared, options) as run:
        execution = Execution(run, prepared.descriptions, prepared.wiring)
        try:
            yield execution
        finally:
            execution.end()
    execution.end(run.outcome)


def checkpoint_to_resume(
    results: str | Path | None, resume: bool | str | Path
) -> Checkpoint | None:
    """The checkpoint from which a run is to be resumed, if so; InputError if it cannot be."""
    if resume is False:
        return None
    if results is None:
        message = "a run that goes on from a checkpoint needs a file of results"
        raise InputError.single(message, "give `results`")
    path = checkpoint_of(stream_of(results)) if resume is True else Path(resume)
    results_of(path)
    return read_checkpoint(path.absolute())


def _ready(
    system: System | Prepared | str | Path,
    results: str | Path | None,
    variables: Sequence[str],
    build_directory: str | Path,
    tell: Callable[[str], None] | None,
    *,
    animated: bool = False,
) -> tuple[Prepared, RunOptions]:
    """The prepared system, with what its results record, and the options that they give."""
    prepared = system
    if not isinstance(prepared, Prepared):
        prepared = prepare(prepared, build_directory=build_directory, tell=tell)
    if results is None:
        return replace(prepared, recorded={}), RunOptions()
    scene = system_scene(prepared.system, prepared.descriptions, prepared.wiring)
    prepared = prepared.recording(variables)
    if animated and scene is None:
        message = f"{prepared.system.name} shows nothing: no component has a model or a scene"
        raise InputError.single(message, "leave out --animate")
    if animated and scene:
        recorded = prepared.recorded.items()
        names = [f"{name}.{one.name}" for name, members in recorded for one in members]
        prepared = prepared.recording([*names, *scene.variables])
    size, note = volume(prepared.system.simulation, prepared.columns)
    if prepared.columns == 1:
        note = "the results have no column but time: choose what to record (--variables)"
    if tell and (size > LARGE or prepared.columns == 1):
        tell(note)
    return prepared, RunOptions(results=results, scene=scene)


def _no_checkpoints(prepared: Prepared, options: RunOptions) -> list[str]:
    """The warning of a run that takes none of the checkpoints that its settings ask for.

    InputError if it is to be resumed from one.
    """
    why = without_checkpoints(prepared, options)
    if why and options.checkpoint:
        raise InputError.single(f"the run cannot be resumed: {why}", "run again from the start")
    asked = [name for name in CHECKPOINTS if getattr(prepared.system.simulation, name) is not None]
    return [f"{' and '.join(asked)}: no checkpoints are taken: {why}"] if why and asked else []
