"""The results file beside a run: whether it may be written, what it tells, how it ends."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.recorded_variables import chosen
from m4e_fmi.cosim.connections.recorded_variables import thinned as thinned_settings
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport
from m4e_fmi.cosim.master.master import Master
from m4e_fmi.cosim.results.run_record import record_of_system
from m4e_fmi.cosim.results.system_scene import system_scene
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.system.simulation import CHECKPOINTS
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.locks import claimed
from m4e_fmi.report.animation.scene import Scene
from m4e_fmi.report.run_report.record import (
    FlowEnergy,
    RecordEnd,
    StatedError,
    carried_record,
)
from m4e_fmi.results.results_file import as_given, check_export, export, stream_of


def thinned(
    prepared: Prepared, variables: Sequence[str], tell: Callable[[str], None] | None
) -> Prepared:
    """The same, with an output interval if the results would be huge.

    What is told: results that are large, and such as have nothing but the time.
    """
    simulation, connected = prepared.system.simulation, prepared.wiring.sources
    settings, note = thinned_settings(simulation, prepared.descriptions, variables, connected)
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


def scene_of(prepared: Prepared) -> Scene | None:
    """The scene of the results, for animations; None if there is nothing to show."""
    return system_scene(prepared.system, prepared.descriptions, prepared.wiring)


def with_followed(
    prepared: Prepared, variables: Sequence[str], scene: Scene | None
) -> Sequence[str]:
    """The names of all that `variables` choose, and of what an animation of the `scene` follows.

    InputError if there is no scene.
    """
    if scene is None:
        message = f"{prepared.system.name} shows nothing: it has no model, hull or mooring line"
        raise InputError.single(message, "leave out --animate")
    found = chosen(prepared.descriptions, variables, prepared.wiring.sources)
    names = [f"{name}.{one.name}" for name, members in found.items() for one in members]
    return tuple(dict.fromkeys((*names, *scene.variables)))


@contextmanager
def place_of(results: str | Path) -> Generator[Path]:
    """Where the results are streamed to, absolute; InputError or RunError before any work."""
    check_export(results)
    with claimed(stream_of(results)) as place:
        yield place


def closing_attributes(
    master: Master,
    prepared: Prepared,
    *,
    ended: bool,
    no_estimate: str,
    warnings: Sequence[str] = (),
) -> dict[str, str]:
    """Attributes of the results that are known at the end of the run.

    These are the warnings and errors of FMUs, a line each, the same of actions of a scenario, and,
    if it has `ended` well, how large the coupling errors are, or why there is `no_estimate` of
    them, and the notes, with the `warnings` and those of the master.
    """
    lines = "\n".join(map(str, master.messages))
    found = {"messages": lines} if lines else {}
    if master.scenario:
        found["scenario"] = "\n".join(master.scenario)
    if ended:
        told = (f"warning: {line}" for line in (*warnings, *master.warnings))
        found["notes"] = "\n".join((*prepared.notes, *told))
        certificate = master.certificate()
        found["coupling_error"] = str(certificate) or ": ".join(["not known", no_estimate])
        if isinstance(certificate, CouplingErrorReport) and certificate.coverage:
            found["coupling_error_from"] = str(certificate.coverage)
    return found | carried_record(_record_end(master, ended=ended))


def _record_end(master: Master, *, ended: bool) -> RecordEnd:
    """Steps, energies over the connections and coupling errors at the end of a run."""
    certificate = master.certificate() if ended else ""
    errors = certificate.errors if isinstance(certificate, CouplingErrorReport) else ()
    return RecordEnd(
        steps=master.steps,
        rejected=master.rejected,
        energies=tuple(
            FlowEnergy(bond.given, bond.received, bond.exchanged, bond.noise)
            for bond in master.energy
        ),
        errors=tuple(
            StatedError(e.connection, str(e.source), e.error, e.halved, e.span, e.unit)
            for e in errors
        ),
    )


def attributes_of(prepared: Prepared) -> dict[str, str]:
    system, settings = prepared.system, prepared.system.simulation
    interval = settings.output_interval
    parts = system.components
    starts = {f"{part.name}.{name}": given for part in parts for name, given in part.start.items()}
    return {
        "title": system.name,
        "comment": system.description,
        "algorithm": settings.algorithm,
        "step_size": f"{settings.step_size:g} s",
        "output_interval": "every step" if interval is None else f"{interval:g} s",
        "start_values": "\n".join(f"{name} = {given}" for name, given in starts.items()),
        "changed": "\n".join(
            f"{name} = {starts.get(name, origin.value)} ({origin.name})"
            for name, origin in system.origins.items()
            if (name in starts or origin.value is not None) and name not in CHECKPOINTS
        ),
        "notes": "\n".join(prepared.notes),
        **carried_record(record_of_system(prepared)),
    }


@contextmanager
def kept(file: Path, given: Path, writer: ResultsWriter) -> Generator[None]:
    """Exports the results to `file` if the run does not reach its end, and tells how far they go.

    Those of a run that does are for `export_whole`.
    """
    try:
        yield
    except RunError as error:
        note = _kept(file, given, writer)
        raise RunError(error.message, f"{error.remedy}; {note}".strip("; ")) from error
    except BaseException as error:
        if note := _kept(file, given, writer):
            error.add_note(note)
        raise


def export_whole(file: Path, given: Path, writer: ResultsWriter) -> None:
    """Export the results of a run that has ended to `file`; RunError tells where else they are."""
    try:
        export(writer.path, file)
    except RunError as error:
        note = whole(file, given, writer)
        raise RunError(error.message, f"{error.remedy}; {note}") from error


def whole(file: Path, given: Path, writer: ResultsWriter, *, exported: bool = False) -> str:
    """Where the results of a run that has ended are complete: also in `file`, once `exported`."""
    rows, _ = writer.saved or (0, 0.0)
    stream, last = as_given(stream_of(given), writer.path), as_given(given, file)
    note = f"the results are complete in {last if exported else stream} ({_count(rows)})"
    if exported or stream_of(given) == given:
        return note
    return f"{note}; {last} is {'of an earlier run' if file.is_file() else 'not written'}"


def _kept(file: Path, given: Path, writer: ResultsWriter) -> str:
    """Export the results of a run that did not reach its end; what there is, as text."""
    if writer.saved is None:
        old = file.is_file() and "the run made no step: {} is as it was"
        return old.format(given) if old else ""
    rows, last = writer.saved
    until, stream = f"results until t = {last:.9g} s", as_given(stream_of(given), writer.path)
    if not writer.path.is_file():
        return f"{until} were in {stream}, which has been renamed or removed ({_count(rows)})"
    try:
        export(writer.path, file)
    except RunError as error:
        return f"{until} are in {stream} ({_count(rows)}); {error.message}"
    return f"{until} are in {as_given(given, file)} ({_count(rows)})"


def _count(rows: int) -> str:
    return f"{rows:,} row{'s' * (rows != 1)}"
