"""A run from its instances to its outcome, with its results file and its checkpoints."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from m4e_fmi.cosim.checkpoint.container import checkpoint_of
from m4e_fmi.cosim.checkpoint.identity import identity
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.recorded_variables import chosen
from m4e_fmi.cosim.exchange.fmu_log import Warn
from m4e_fmi.cosim.master.checkpoints import Checkpoints, checkpoints, resumable
from m4e_fmi.cosim.master.master import Master
from m4e_fmi.cosim.master.outcome import ExportError, Outcome
from m4e_fmi.cosim.master.recording import (
    attributes_of,
    closing_attributes,
    export_whole,
    kept,
    place_of,
    whole,
)
from m4e_fmi.cosim.master.resume import Resumed
from m4e_fmi.cosim.master.told import slow_code
from m4e_fmi.cosim.monitoring.flotation import start_warnings
from m4e_fmi.cosim.preparation.surroundings import model_gravity
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.errors import RunError
from m4e_fmi.report.animation.scene import Scene
from m4e_fmi.report.animation.scene_text import carried
from m4e_fmi.results.results_file import AT_STOP, as_given, stream_of
from m4e_fmi.signals import Terminated, ending_cleanly, held, let_through

LONG = 5.0
"""Seconds of wall time that a run takes, from which on the estimate after it is told."""
NOT_ASKED = "it was not estimated, as asked (certify, --no-certify)"


@dataclass(frozen=True)
class Options:
    """How a run is made; see `m4e_fmi.cosim.master.run.run`.

    A run is `changeable` if values may be set between its steps; with `certify` its error is
    estimated. `watched` tells that observers may read all outputs, `resumed` the checkpoint that it
    begins at. The results carry the `scene`.
    """

    results: str | Path | None = None
    scene: Scene | None = None
    variables: Sequence[str] = ()
    certify: bool = True
    changeable: bool = False
    watched: bool = False
    warn: Warn | None = None
    tell: Callable[[str], None] | None = None
    beside: Sequence[Path] = ()
    resumed: Resumed | None = None

    @property
    def given(self) -> Path:
        """The results file as it was given, with or without a folder; "." if there is none."""
        return Path(self.results or "")

    @property
    def no_estimate(self) -> str:
        """The reason why the coupling error is not estimated; empty if it is."""
        return "" if self.certify else NOT_ASKED

    def warn_of(self, lines: Sequence[str]) -> None:
        """Tell each of some warnings."""
        if self.warn:
            for line in lines:
                self.warn(f"warning: {line}")


@dataclass
class Begun:
    """A run of a system with its results file, if there is one, found from any folder.

    It has the `outcome` once both have ended, unless the run has `failed`. `warnings` are those
    from before the first step.
    """

    master: Master
    system: Prepared
    file: Path
    results: ResultsWriter | None = None
    checkpoints: Checkpoints | None = None
    outcome: Outcome | None = None
    warnings: tuple[str, ...] = ()
    failed: bool = False
    started: float = field(default_factory=clock.perf_counter)

    @property
    def is_at_stop(self) -> bool:
        """True if the stop time is reached."""
        stop_time = self.system.system.simulation.stop_time
        return round(self.master.network.time * NS_PER_SECOND) >= round(stop_time * NS_PER_SECOND)

    @property
    def reached(self) -> str:
        """The present time of the run, as a note."""
        stop = f"{self.system.system.simulation.stop_time:.9g} s"
        if self.is_at_stop:
            return f"at the stop time, t = {stop}"
        return f"at t = {self.master.network.time:.9g} s of {stop}"


@contextmanager
def begun_run(system: Prepared, options: Options) -> Generator[Begun]:
    """A run that the block makes; its outcome and its export follow the block."""
    start_time = clock.perf_counter()
    missing = () if options.changeable else system.warnings  # inputs may be set between the steps
    system, file = _at_home(system), options.given.absolute()
    recorded = _recorded_variables(system, options)
    with ExitStack() as stack:
        complete = stack.enter_context(_told_if_complete())
        stack.enter_context(ending_cleanly())
        results = options.results
        place = None if results is None else stack.enter_context(place_of(results))
        same = identity(system, recorded, certify=options.certify)
        with _master(system, options, recorded, same) as master:
            begun = Begun(master, system, file)
            gravity = partial(model_gravity, system.system, system.descriptions)
            floats = start_warnings(master.network, system.wiring, gravity)
            options.warn_of(floats)
            begun.warnings = (*missing, *floats)
            if place is None:
                with _timed(begun):
                    yield begun
                complete[:] = [begun.reached]
            else:
                with _written(begun, options, place, same):
                    yield begun
                assert begun.results
                complete[:] = [begun.reached, whole(file, options.given, begun.results)]
            late = (*master.warnings, *(begun.results.warnings if begun.results else ()))
            options.warn_of(late)
            outcome = _outcome(begun, options, clock.perf_counter() - start_time)
            begun.outcome = replace(outcome, warnings=(*begun.warnings, *late))
            if begun.results:
                complete[1:] = [_exported(begun, begun.outcome, begun.results, options.given)]
        # what FMUs say at their end comes after the results are complete
        begun.outcome = replace(begun.outcome, messages=begun.master.messages)


def _recorded_variables(system: Prepared, options: Options) -> dict[str, list[str]]:
    """Names of the variables that the results will have, by component."""
    if options.results is None:
        return {}
    members = chosen(system.descriptions, options.variables, system.wiring.sources)
    return {name: [v.name for v in members] for name, members in members.items()}


@contextmanager
def _master(
    system: Prepared,
    options: Options,
    recorded: Mapping[str, Sequence[str]],
    same: Mapping[str, str],
) -> Generator[Master]:
    """The master of a run; `same` is what it must have in common with a checkpoint."""
    resumed = options.resumed
    if resumed:
        resumed.check(same, system.system.simulation.stop_time)
    with Master(
        system,
        certify=options.certify,
        changeable=options.changeable,
        recorded=recorded,
        watched=options.watched or (resumed is not None and resumed.head.watched),
        warn=resumed.at_once if resumed else options.warn,
    ) as master:
        if resumed:
            resumed.bring_texts(master.network)
        yield master


@contextmanager
def _written(
    begun: Begun, options: Options, place: Path, same: Mapping[str, str]
) -> Generator[None]:
    """The results file at `place` and the checkpoints of a run that the block makes."""
    master, resumed, own = begun.master, options.resumed, checkpoint_of(place)
    beside = [path.absolute() for path in (begun.file, *options.beside)]
    writer = begun.results = ResultsWriter(
        place,
        master.network,
        attributes_of(begun.system) | carried(options.scene),
        variables=options.variables,
        closing=lambda: _closing(begun, options),
        beside=[path for path in beside if path.resolve() != place],
        earlier=[] if resumed and resumed.path == own else [own],
        begun=resumed.rows if resumed else None,
    )
    if resumed:
        resumed.tell(options.tell)
    if begun.system.system.simulation.has_checkpoints and not options.changeable:
        begun.checkpoints = checkpoints(
            begun.system,
            place,
            same,
            tell=None if resumed else options.tell,
            warn=options.warn,
        )
        if resumed:
            begun.checkpoints.go_on(resumed.path, resumed.head.time)
    with (
        resumable(begun.checkpoints),
        kept(begun.file, options.given, writer),
        _timed(begun),
        held(),
        writer,
    ):
        with _recorded(begun), let_through():
            yield
        if master.ended:
            writer.close(master.ended)


def _closing(begun: Begun, options: Options) -> dict[str, str]:
    """Attributes of the results that are known at the end of the run."""
    ended = not begun.failed
    if ended and options.tell and begun.master.estimator:
        wall_time = clock.perf_counter() - begun.started
        if wall_time > LONG:
            options.tell(
                f"all rows are made, in {wall_time:.0f} s; now the coupling error is estimated: "
                "steps are repeated, which may take as long"
            )
    late = begun.results.warnings if begun.results else ()
    try:
        return closing_attributes(
            begun.master,
            begun.system,
            ended=ended,
            no_estimate=options.no_estimate,
            warnings=(*begun.warnings, *late),
        )
    except (KeyboardInterrupt, Terminated) as error:
        if ended and begun.master.estimator:
            error.add_note("while the coupling error was estimated")
        raise


def _outcome(begun: Begun, options: Options, wall_time: float) -> Outcome:
    """The outcome of a run that has ended, without its warnings; `wall_time` in seconds."""
    master, writer = begun.master, begun.results
    return Outcome(
        prepared=begun.system,
        path=as_given(stream_of(options.given), writer.path) if writer else None,
        steps=master.steps,
        wall_time=wall_time,
        energy=master.energy,
        notes=(
            *begun.system.notes,
            *master.notes,
            *(writer.notes if writer else ()),
            *slow_code(master.network, wall_time),
        ),
        order=master.order,
        rejected=master.rejected,
        certificate=master.certificate() or options.no_estimate,
        messages=master.messages,
        scenario=master.scenario,
    )


def _exported(begun: Begun, outcome: Outcome, writer: ResultsWriter, given: Path) -> str:
    """Export the results in the form that is wanted; a note of where they are."""
    try:
        export_whole(begun.file, given, writer)
    except RunError as error:
        raise ExportError(error, outcome) from error
    return whole(begun.file, given, writer, exported=True)


def _at_home(system: Prepared) -> Prepared:
    """The same, with files that are found from any folder: FMUs may change that of the process."""
    found = {n: replace(d, path=d.path.absolute()) for n, d in system.descriptions.items()}
    return replace(system, descriptions=found)


@contextmanager
def _recorded(begun: Begun) -> Generator[None]:
    """Results of a run that has made all its steps are complete, however it ends."""
    try:
        yield
    except BaseException as error:
        begun.failed = True
        asked = isinstance(error, KeyboardInterrupt | Terminated)
        if asked and begun.results and begun.is_at_stop:
            begun.results.close(AT_STOP)
        raise


@contextmanager
def _timed(begun: Begun) -> Generator[None]:
    """Ctrl-C and signals get a note of the time reached."""
    try:
        yield
    except (KeyboardInterrupt, Terminated) as error:
        error.add_note(begun.reached)
        raise


@contextmanager
def _told_if_complete() -> Generator[list[str]]:
    """Errors that come after a run is complete say so, by the notes of this list.

    Ctrl-C and signals get them unless they have notes; an ExportError tells itself.
    """
    notes: list[str] = []
    try:
        yield notes
    except (KeyboardInterrupt, Terminated) as error:
        for note in () if getattr(error, "__notes__", ()) else notes:
            error.add_note(note)
        raise
    except ExportError:
        raise
    except RunError as error:
        if not notes:
            raise
        remedy = "; ".join(filter(None, (error.remedy, *notes[1:])))
        raise RunError(error.message, remedy) from error
