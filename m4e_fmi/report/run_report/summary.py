"""Texts of a report: headline figures, warnings, numerics, what it takes to make it again."""

from __future__ import annotations

from collections.abc import Iterator

from m4e_fmi.report.headlines import headlines
from m4e_fmi.report.panels import fitting, moving, panels, percent, quantity
from m4e_fmi.report.run_report.flows import balance_of, energy_closes
from m4e_fmi.report.run_report.record import Record, RecordEnd
from m4e_fmi.report.text.summaries import LOSSY, extremes, lossy_text
from m4e_fmi.report.web.markup import cards, facts, folded, lines, paragraph, table
from m4e_fmi.results.results_file import AT_STOP, Results
from m4e_fmi.results.row_file import NOT_ENDED

WARNING = "warning: "


def figures(results: Results) -> str:
    """The description of the system, and its headline figures as cards."""
    comment = results.attributes.get("comment", "")
    found = cards((one.name, one.value, one.detail) for one in headlines(results))
    return (paragraph(comment) if comment else "") + found


def warnings(results: Results, record: Record, end: RecordEnd) -> str:
    """All doubts about the results in one box, or a line that there are none."""
    if found := lines(_doubts(results, record, end)):
        return f'<div class="doubts">{found}</div>'
    accuracy = ""
    if end.errors:
        worst = max(end.errors, key=lambda one: one.error)
        accuracy = f"; largest coupling error {100 * worst.error:.2g} % of range, at {worst.source}"
    elif closes := energy_closes(balance_of(results)):
        accuracy = f"; the energy balance {closes}"
    return paragraph(f"No warnings{accuracy}.", "good")


def _doubts(results: Results, record: Record, end: RecordEnd) -> Iterator[str]:
    told = results.attributes
    if (ended := told.get("ended", AT_STOP)) == NOT_ENDED:
        yield f"The run has not ended {NOT_ENDED.removeprefix('not ')}."
    elif ended != AT_STOP:
        yield f"The run ended early: {ended}."
    notes = told.get("notes", "").splitlines()
    yield from (line.replace(WARNING, "", 1) for line in notes if WARNING in line)
    yield from (f"Message of {line}" for line in told.get("messages", "").splitlines())
    error, coverage = told.get("coupling_error", ""), told.get("coupling_error_from", "")
    if "not known" in error:
        yield f"Coupling error {error}".replace("Coupling error the c", "C")
    elif any(not one.error <= LOSSY for one in end.errors):
        yield f"{error[:1].upper()}{error[1:]}"
    if "less than was wanted" in coverage:
        yield f"Coupling error estimated from less than was wanted: {coverage}"
    if len(end.energies) == len(record.flows):
        for flow, one in zip(record.flows, end.energies, strict=True):
            lost = one.received - one.given
            if one.exchanged > one.noise and not abs(lost) <= LOSSY * one.exchanged:
                yield lossy_text(flow.connection, lost / one.exchanged)
    if (audit := balance_of(results)) and not audit.relative <= LOSSY:
        yield f"The energy balance {energy_closes(audit)}"


def numerics(results: Results, record: Record, end: RecordEnd) -> str:
    """Steps, errors, energies and extremes."""
    told = results.attributes
    notes = [n for n in told.get("notes", "").splitlines() if WARNING not in n]
    parts = [facts(_facts(results, record, end))]
    for heading, listed in (("Notes", notes), ("Scenario", told.get("scenario", "").splitlines())):
        if text := lines(listed):
            parts.append(f"<h3>{heading}</h3>{text}")
    parts += [_errors(end), _energies(results, record, end), _extremes(results)]
    return "\n".join(filter(None, parts))


def _facts(results: Results, record: Record, end: RecordEnd) -> dict[str, str]:
    told, time = results.attributes, results.time
    graph = record.graph
    return {
        "System": told.get("title", results.path.stem),
        "Components": ", ".join(c.name for c in graph.components) if graph else ", ".join(
            results.components
        ),
        "Times": f"{time[0]:g} to {time[-1]:g} s, {len(time):,} rows",
        "Algorithm": told.get("algorithm", ""),
        "Method": told.get("method", ""),
        "Tolerance": told.get("tolerance", ""),
        "Steps": _steps(told.get("step_size", ""), end),
        "Energy balance": energy_closes(balance_of(results)),
        "Coupling error": told.get("coupling_error", ""),
        "Found from": told.get("coupling_error_from", ""),
        "Made": told.get("created", ""),
    }  # fmt: skip


def _steps(size: str, end: RecordEnd) -> str:
    if end.steps is None:
        return size and f"{size} each"
    again = f", {end.rejected:,} made again" if end.rejected else ""
    return f"{end.steps:,} of {size}{again}"


def _errors(end: RecordEnd) -> str:
    """The stated coupling errors, the largest of each connection."""
    if not end.errors:
        return ""
    rows = (
        (
            one.connection, one.source, f"{one.error:.1e}", f"{one.halved:.1e}",
            f"{one.error * one.span:.2g} {one.unit}", f"{one.span:.3g} {one.unit}",
        )
        for one in end.errors
    )  # fmt: skip
    caption = (
        "Largest error of each connection's variables over the run, as a share of the range of "
        "variables of that unit; other variables of the connection have smaller ones"
    )
    heads = ("connection", "variable", "error", "at half the step", "error", "range")
    return "<h3>Stated coupling errors</h3>" + table(caption, heads, rows, texts=2)


def _energies(results: Results, record: Record, end: RecordEnd) -> str:
    """Energies over the connections, as the run's summary has them."""
    if not end.energies or len(end.energies) != len(record.flows):
        return ""
    span = float(results.time[-1] - results.time[0])
    rows = []
    for flow, one in zip(record.flows, end.energies, strict=True):
        idle = one.exchanged <= one.noise
        lost = "–" if idle else percent((one.received - one.given) / one.exchanged)
        mean = quantity(one.given / span if span else 0.0, "W")
        rows.append(
            (flow.connection, flow.source, flow.target,
             quantity(one.given, "J"), quantity(one.received, "J"), lost, mean)
        )  # fmt: skip
    heads = ("connection", "from", "into", "given", "received", "lost or made", "mean power")
    caption = "From the force's source into the body; negative the other way"
    return "<h3>Energy over the connections</h3>" + table(caption, heads, rows, texts=3)


def _extremes(results: Results) -> str:
    """Smallest, mean and largest values of what figures show."""
    reals = {name: one for name, one in results.series.items() if one.recorded.is_real}
    found = extremes(map(fitting, moving(panels(reals))), results.time)
    rows = [(name, unit, *numbers) for name, unit, numbers in found]
    heads = ("variable", "unit", "min", "mean", "max")
    return (
        "<h3>Extremes</h3>" + table("From the rows of the results", heads, rows, texts=2)
        if rows
        else ""
    )


def reproduction(results: Results, record: Record, command: str) -> str:
    """Command, start values, versions, FMUs and input files."""
    parts = [facts({"Command": command, "Results": results.path.name})]
    for heading, key in (("Start values", "start_values"), ("Not as in the file", "changed")):
        if listed := lines(results.attributes.get(key, "").splitlines()):
            parts.append(f"<h3>{heading}</h3>{listed}")
    if record.versions:
        parts.append("<h3>Versions</h3>" + facts(record.versions))
    if record.fmus:
        parts.append("<h3>FMUs</h3>" + facts(record.fmus))
    if record.inputs:
        parts.append("<h3>Input files</h3>")
        parts.append(facts({one.name: f"SHA-256 {one.sha256}" for one in record.inputs}))
        parts += [folded(one.name, one.text) for one in record.inputs if one.text is not None]
    if not (record.versions or record.inputs):
        text = "These results carry no record of versions and input files: m4e-fmi run writes it."
        parts.append(paragraph(text))
    return "\n".join(parts)
