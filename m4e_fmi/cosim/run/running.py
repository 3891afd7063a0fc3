"""A run from its FMUs to its outcome: its results file, checkpoints, and errors on the way.

However a run ends, the rows that were made are on the disk, and the error says how far it came and
where they are.
"""

from __future__ import annotations

import time as clock
from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.cosim.results.run_record import attributes_of
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.run.checkpoint import Checkpoints, checkpoint_of
from m4e_fmi.cosim.run.identity import identity
from m4e_fmi.cosim.run.outcome import NOT_ASKED, ExportError, Outcome
from m4e_fmi.cosim.run.run import Run, RunOptions
from m4e_fmi.cosim.system.component import answers
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import RunError
from m4e_fmi.files.locks import claimed
from m4e_fmi.report.animation.scene_text import carried
from m4e_fmi.report.run_report.record import FlowEnergy, RecordEnd, StatedError, carried_record
from m4e_fmi.results.results_file import AT_STOP, as_given, check_export, export, stream_of
from m4e_fmi.shown import first_of
from m4e_fmi.signals import Terminated, ending_cleanly, held, let_through

MOST_NAMED = 3
"""Outputs of a component that are named in one note."""
LONG = 5.0
"""Seconds of wall time that a run takes, from which on the estimate after it is told."""


@contextmanager
def running(prepared: Prepared, options: RunOptions) -> Generator[Run]:
    """A run at its start or its checkpoint, which the block steps; its `outcome` follows the block.

    InputError or RunError before any FMU is loaded if the results cannot be written.
    """
    began, given = clock.perf_counter(), Path(options.results or "")
    file = given.absolute()  # FMUs may change the folder of the process
    found = {n: replace(d, path=d.path.absolute()) for n, d in prepared.descriptions.items()}
    run = Run(replace(prepared, descriptions=found), options)
    complete: list[str] = []
    try:
        with ExitStack() as stack:
            stack.enter_context(ending_cleanly())
            place = None
            if options.results is not None:
                check_export(given)
                place = stack.enter_context(claimed(stream_of(given)))
            run.identity = identity(run.prepared, certify=options.certify)
            if options.checkpoint:
                options.checkpoint.check(run.identity, run.simulation.stop_time)
            stack.enter_context(run)
            _look_at_start(run)
            if place:
                _open_results(run, place, file)
            try:
                with held():  # until all rows are on the disk
                    yield from _stepped(run)
            except BaseException as error:
                _add_facts(error, _how_far(run, error, given, file))
                raise
            complete.append(_time(run))
            if run.results:
                complete.append(_where(run.results, given, file))
            run.outcome = _last_outcome(run, clock.perf_counter() - began, given)
            if run.results:
                complete[1] = _exported(run.outcome, run.results, given, file)
    except (KeyboardInterrupt, Terminated) as error:
        _add_facts(error, [] if getattr(error, "__notes__", ()) else complete)
        raise
    except ExportError:
        raise
    except RunError as error:
        _add_facts(error, complete[1:])
        raise
    # what FMUs say at their end comes after the results are complete
    messages = run.journal.messages(run.network.instances.values())
    run.outcome = replace(run.outcome, messages=messages)


def _add_facts(error: BaseException, facts: Sequence[str]) -> None:
    """Add further facts to an error: to the remedy of a RunError, as notes to another one."""
    if isinstance(error, RunError):
        remedy = "; ".join(filter(None, (error.remedy, *facts)))
        RunError.__init__(error, error.message, remedy)
    else:
        for fact in facts:
            error.add_note(fact)


def without_checkpoints(prepared: Prepared, options: RunOptions) -> str:
    """The reason why no checkpoints can be taken of a run; empty if they can."""
    if options.changeable:
        return "use 'run', or 'save' of this run in between"
    if options.results is None:
        return "they lie beside results: give 'results'"
    if options.watched:
        return "observers may read outputs that a checkpoint does not have"
    parts = prepared.descriptions.items()
    fixed = [name for name, d in parts if not (d.saves_state and d.serializes_state)]
    if fixed:
        who = " and ".join(fixed)
        return f"{who} cannot save states for another process (canSerializeFMUstate)"
    return ""


def _look_at_start(run: Run) -> None:
    """Give and keep the warnings from before the first step."""
    options, prepared = run.options, run.prepared
    if options.checkpoint:
        options.checkpoint.saved.take_texts(run.network)
    system, known = prepared.system, prepared.descriptions
    given = system, known, prepared.wiring, run.network
    found = tuple(answers(system.components, known, lambda k: k.doubts_at_start, *given))
    options.warn_of(found)
    # inputs that nothing is connected to may be set between the steps of a changeable run
    run.warnings = (*(() if options.changeable else prepared.warnings), *found)


def _open_results(run: Run, place: Path, file: Path) -> None:
    """Open the results at `place`, which become `file` in the end, and their checkpoints."""
    options, checkpoint, own = run.options, run.options.checkpoint, checkpoint_of(place)
    beside = [path.absolute() for path in (file, *options.beside)]
    run.results = ResultsWriter(
        place,
        run.network,
        run.prepared.recorded,
        attributes_of(run.prepared) | carried(options.scene),
        beside=[path for path in beside if path.resolve() != place],
        earlier=[] if checkpoint and checkpoint.path == own else [own],
        first=checkpoint.rows if checkpoint else None,
    )
    if checkpoint and options.tell:
        options.tell(f"the run goes on at t = {checkpoint.time:.9g} s")
    if run.simulation.has_checkpoints and not without_checkpoints(run.prepared, options):
        run.checkpoints = Checkpoints(own, run.simulation, options.warn)
        if checkpoint:
            run.checkpoints.resume(checkpoint)


def _stepped(run: Run) -> Generator[Run]:
    """The steps of a run; its results are closed behind them, however they end."""
    began = clock.perf_counter()
    try:
        with let_through():
            run.begin()
            yield run
    except BaseException as error:
        if run.results:
            closing = partial(_closing, run, began, failed=True)
            run.results.close(_ending(run, error), closing, failed=True)
        raise
    if run.results:
        how = f"stopped at t = {run.network.time:.9g} s"
        if run.done:
            how = run.network.ended or AT_STOP
        run.results.close(how, partial(_closing, run, began, failed=False))


def _ending(run: Run, error: BaseException) -> str:
    """How a run has ended that did not end well, for its results: with all its rows, or early."""
    if isinstance(error, KeyboardInterrupt | Terminated):
        early = str(error) if isinstance(error, Terminated) else "interrupted"
        return AT_STOP if run.is_at_stop else early
    return f"failed: {error.message if isinstance(error, RunError) else error}"


def _closing(run: Run, began: float, *, failed: bool) -> dict[str, str]:
    """Attributes of the results that are known at the end of a run whose steps `began` then [s]."""
    tell, wall_time = run.options.tell, clock.perf_counter() - began
    estimated = run.estimator is not None and not failed
    if estimated and tell and wall_time > LONG:
        tell(
            f"all rows are made, in {wall_time:.0f} s; now the coupling error is estimated: "
            "steps are repeated, which may take as long"
        )
    try:
        return closing_attributes(run, failed=failed)
    except (KeyboardInterrupt, Terminated) as error:
        if estimated:
            error.add_note("while the coupling error was estimated")
        raise


def closing_attributes(run: Run, *, failed: bool) -> dict[str, str]:
    """Attributes of the results that are known at the end of a run.

    These are the messages of FMUs and the actions of a scenario, a line each, and unless it has
    `failed`, the coupling errors, or why they are not known, and notes and warnings.
    """
    outcome = _outcome(run, failed=failed)
    errors = outcome.certificate
    found = {
        "messages": "\n".join(map(str, outcome.messages)),
        "scenario": "\n".join(outcome.scenario),
    }
    found = {name: text for name, text in found.items() if text}
    if not failed:
        told = (f"warning: {line}" for line in outcome.warnings)
        found["notes"] = "\n".join((*run.prepared.notes, *told))
        found["coupling_error"] = "not known: " * (errors == NOT_ASKED) + str(errors)
    report = errors if isinstance(errors, CouplingErrorReport) else CouplingErrorReport(())
    if report.coverage:
        found["coupling_error_from"] = str(report.coverage)
    end = RecordEnd(
        steps=outcome.steps,
        rejected=outcome.rejected,
        energies=tuple(
            FlowEnergy(bond.given, bond.received, bond.exchanged, bond.noise)
            for bond in outcome.energy
        ),
        errors=tuple(
            StatedError(e.connection, str(e.source), e.error, e.halved, e.span, e.unit)
            for e in report.errors
        ),
    )
    return found | carried_record(end)


def _outcome(run: Run, *, failed: bool = False) -> Outcome:
    """The outcome of a run at the present point, without its path and wall time.

    Nothing is estimated, and nobody warned, of one that has `failed`.
    """
    prepared, network = run.prepared, run.network
    certificate, warnings = "", run.warnings
    if not failed:
        certificate = run.certificate()
        if network.ended and not run.is_at_stop:
            stop = f"{run.simulation.stop_time:.9g} s"
            warnings += (f"the run ended before its stop time of {stop}: {network.ended}",)
        warnings += run.second_look.notes
        if isinstance(certificate, CouplingErrorReport):
            texts = certificate.warning(), certificate.partial()
            warnings += tuple(filter(None, texts))
        if run.results:
            warnings += run.results.warnings
    return Outcome(
        prepared=prepared,
        path=None,
        steps=run.steps,
        wall_time=0.0,
        energy=run.energy.result(),
        order=run.algorithm.order,
        notes=(
            *prepared.notes,
            *(f"{name} {rate}" for name, rate in prepared.rates.items()),
            *run.algorithm.notes,
            *_network_notes(run),
        ),
        rejected=run.rejected,
        certificate=certificate,
        messages=run.journal.messages(network.instances.values()),
        warnings=warnings,
        scenario=network.scenario.report(),
    )


def _network_notes(run: Run) -> Iterator[str]:
    """Notes of events, switches, lost outputs, inputs solved badly, held actions; a line each."""
    network, bonds = run.network, run.prepared.wiring.bonds
    for instance in network.instances.values():
        if count := instance.events.interruptions:
            yield (
                f"{instance.name} had {count} event{'s' * (count > 1)} within steps, at which the "
                "other components did not stop"
            )
    yield from run.time_loop.position.switches.notes
    for name, outputs in network.lost.items():
        yield (
            f"{name}: setting inputs, even to the values that they have, changes "
            f"{first_of(outputs, MOST_NAMED)} by more than its noise: the "
            "values straight after its steps count"
        )
    if rough := network.roughness:
        yield (
            f"inputs are solved only to {rough:.1e} of their size: the FMUs' outputs for "
            "nearly the same inputs jump by that much"
        )
    if held := network.scenario.held:
        yield (
            f"values that actions give ({', '.join(held)}) change at communication points and are "
            "held within steps, so that errors fall with the step size only: take small steps"
        )
    summed = network.scenario.untouched(bonds)
    if names := [bond.name for bond in bonds if bond not in summed]:
        yield f"the scenario changes signals of {' and '.join(names)}: no energy balance there"
    if network.ended:
        yield network.ended


def _last_outcome(run: Run, wall_time: float, given: Path) -> Outcome:
    """The outcome of a run that has ended well; warnings that it has only now are given."""
    outcome, results = _outcome(run), run.results
    run.options.warn_of(outcome.warnings[len(run.warnings) :])
    return replace(
        outcome,
        path=as_given(stream_of(given), results.path) if results else None,
        wall_time=wall_time,
        notes=(*outcome.notes, *(results.notes if results else ())),
    )


def _time(run: Run) -> str:
    """The present time of a run, as a note."""
    stop = f"{run.simulation.stop_time:.9g} s"
    if run.is_at_stop:
        return f"at the stop time, t = {stop}"
    return f"at t = {run.network.time:.9g} s of {stop}"


def _how_far(run: Run, error: BaseException, given: Path, file: Path) -> list[str]:
    """Facts for an error that has ended a run: time reached, rows on the disk, how to go on."""
    facts = [_time(run)] if isinstance(error, KeyboardInterrupt | Terminated) else []
    if run.results and (rows := _rows_left(run.results, given, file)):
        facts.append(rows)
    if run.checkpoints and run.checkpoints.taken is not None:
        time = run.checkpoints.taken
        facts.append(f"--resume (in Python resume=True) goes on at t = {time:.9g} s")
    return facts


def _rows_left(results: ResultsWriter, given: Path, file: Path) -> str:
    """Export the rows of a run that did not reach its end; a note of where they are."""
    if results.saved is None:
        return f"the run made no step: {given} is as it was" if file.is_file() else ""
    rows, last = results.saved
    until, stream = f"results until t = {last:.9g} s", as_given(stream_of(given), results.path)
    if not results.path.is_file():
        return f"{until} were in {stream}, which has been renamed or removed ({_count(rows)})"
    try:
        export(results.path, file)
    except RunError as error:
        return f"{until} are in {stream} ({_count(rows)}); {error.message}"
    return f"{until} are in {as_given(given, file)} ({_count(rows)})"


def _exported(outcome: Outcome, results: ResultsWriter, given: Path, file: Path) -> str:
    """Export the results of a run that has ended; a note of where they are. Else ExportError."""
    try:
        export(results.path, file)
    except RunError as error:
        remedy = f"{error.remedy}; {_where(results, given, file)}"
        raise ExportError(RunError(error.message, remedy), outcome) from error
    return _where(results, given, file, exported=True)


def _where(results: ResultsWriter, given: Path, file: Path, *, exported: bool = False) -> str:
    """A note of where complete results are: also in `file`, once `exported`."""
    rows, _ = results.saved or (0, 0.0)
    stream, last = as_given(stream_of(given), results.path), as_given(given, file)
    note = f"the results are complete in {last if exported else stream} ({_count(rows)})"
    if exported or stream_of(given) == given:
        return note
    return f"{note}; {last} is {'of an earlier run' if file.is_file() else 'not written'}"


def _count(rows: int) -> str:
    return f"{rows:,} row{'s' * (rows != 1)}"
