"""The report of a file of results: `report_of_run`."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.writing import check_suffix, written
from m4e_fmi.report.animation.page import Part
from m4e_fmi.report.animation.results_page import run_part
from m4e_fmi.report.animation.scene_text import scene_of_text
from m4e_fmi.report.graph import Graph
from m4e_fmi.report.panels import fitting, moving, panels
from m4e_fmi.report.run_report.flows import Flows, flows_of
from m4e_fmi.report.run_report.record import RecordEnd, end_of, record_of
from m4e_fmi.report.run_report.summary import figures, numerics, reproduction, warnings
from m4e_fmi.report.web.markup import escaped, paragraph
from m4e_fmi.report.web.samples import Curve, Samples, packed_samples
from m4e_fmi.report.web.shell import HERE, Page, PageSection, page_text, text_of
from m4e_fmi.results.results_file import Results, load_results
from m4e_fmi.results.series import SCENE

OWN = "m4e_fmi.report.run_report"
SUFFIX = ".report.html"
MOST_SAMPLES = 60_000_000
"""Numbers in a report: of Float32, 300 MB as text, which a browser still opens."""
MOST_DRAWN = 60
"""Components of a system that is drawn: finding their places takes seconds for more."""
MOST_SHRUNK = 16.0
"""Width [inches] of a graph that is shrunk to the page; wider ones are scrolled."""
MOST_PANELS = 5
"""Plots that a report opens with."""
FIRST_PLOTS = '<div class="first-plots"></div>'
"""Place of the first plots where nothing is animated."""


def report_of_run(results: str | Path | Results, path: str | Path, *, command: str = "") -> Path:
    """Write the report of `results`, a file or what `load` made of it, to `path` (.html).

    The page needs nothing else, and has every sample of the results. `command` is the command line
    of the run. InputError for results that are damaged, have no rows, or have more than 60 million
    samples; RunError if the file cannot be written.
    """
    path = Path(path)
    check_suffix(path, (".html",), "a report")
    found = results if isinstance(results, Results) else load_results(results)
    text = page_text(_page(found, command))
    with written(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def _page(results: Results, command: str) -> Page:
    name = str(results.path)
    _check(results, name)
    record, end = record_of(results.attributes, name), end_of(results.attributes, name)
    flows = flows_of(results, record, end)
    samples = packed_samples(results.time, _curves(results, end, flows))
    shown, why, ramp = _animation(results, name)
    moved = text_of(OWN, "moved.html").replace("@animation@", shown.markup) if shown else ""
    lead = f'<div class="lead">{moved or FIRST_PLOTS}<div>{figures(results)}</div></div>'
    sections = [
        PageSection("result", "Result", lead),
        PageSection("warnings", "Warnings", warnings(results, record, end)),
        PageSection("histories", "Time histories", _histories(results, samples)),
    ]
    if flows:
        sections.append(PageSection("power", "Power flow", text_of(OWN, "flows.html")))
    sections.append(PageSection("spectra", "Spectra", text_of(HERE, "spectra.html")))
    told = numerics(results, record, end) + (paragraph(why, "note") if why else "")
    sections.append(PageSection("numerics", "Numerics", told, folded=True))
    if record.graph:
        sections.append(PageSection("system", "System", _drawing(record.graph), folded=True))
    made_of = reproduction(results, record, command)
    sections.append(PageSection("inputs", "Reproduction", made_of, folded=True))
    scripts = [shown.script] if shown else []
    title = results.attributes.get("title") or results.path.stem
    return Page(
        title=title,
        subtitle=f"{'Co-simulation' if record.graph else 'Simulation'}, report of m4e_fmi",
        sections=sections,
        data={
            "samples": samples.data,
            "first": _first(results),
            "ramp": ramp,
            "flows": flows.data if flows else None,
            "animation": json.loads(shown.data) if shown else None,
        },
        styles=[*([shown.style] if shown else []), text_of(OWN, "run_report.css")],
        scripts=[*scripts, text_of(OWN, "flows.js"), text_of(OWN, "run_report.js")],
        blocks=samples.blocks,
    )


def _check(results: Results, name: str) -> None:
    """InputError for results that a report cannot show."""
    if len(results.time) < 2:
        told = "one row" if len(results.time) else "no rows"
        message = f"it has {told}: there is nothing to plot"
        raise InputError.single(message, "run it for at least one step", name)
    numbers = len(results.time) * len(results.series)
    if numbers > MOST_SAMPLES:
        message = f"it has {numbers:,} numbers; a report has {MOST_SAMPLES:,} at most"
        remedy = "record fewer variables (--variables) or rows (output_interval)"
        raise InputError.single(message, remedy, name)


def _curves(results: Results, end: RecordEnd, flows: Flows | None) -> Iterator[Curve]:
    """All variables but texts, and the powers over connections."""
    stated = {
        one.source: f"{one.error:.1e} of range, {one.error * one.span:.2g} {one.unit}".rstrip()
        for one in end.errors
    }
    for component, members in results.components.items():
        for label, one in members.items():
            kind, name = one.recorded, f"{component}.{label}"
            if not kind.is_text:
                yield Curve(
                    name, component, label, one.unit, one.long_name, one.values,
                    steps=not kind.is_real, items=dict(kind.named), stated=stated.get(name, ""),
                )  # fmt: skip
    yield from flows.curves if flows else ()


def _first(results: Results) -> list[list[str]]:
    """The variables of the plots that a report opens with: those of the picture of a run."""
    shown = [fitting(panel) for panel in moving(panels(results.series))[:MOST_PANELS]]
    return [list(panel.series) for panel in shown if panel.series]


def _histories(results: Results, samples: Samples) -> str:
    """The plots, and what of the results is in the page."""
    texts = [n for n, one in results.series.items() if one.recorded.is_text]
    kind = "exactly (Float64)" if samples.exact else "rounded to seven digits (Float32)"
    count = len(results.series) - len(texts)
    told = (
        f"All {len(results.time):,} rows of {count} variables are in this file, {kind}; "
        "their times exactly."
    )
    if texts:
        told += f" Texts are in the results only: {', '.join(texts)}."
    return text_of(HERE, "histories.html") + paragraph(told, "note")


def _drawing(graph: Graph) -> str:
    """The graph as a picture (SVG) in an element that runs no script."""
    if len(graph.components) > MOST_DRAWN:
        count = len(graph.components)
        return paragraph(f"{count} components are not drawn here: draw_system in Python does it.")
    from matplotlib import rc_context

    from m4e_fmi.report.drawing.system_graph import graph_figure

    file = io.BytesIO()
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "m4e_fmi", "text.parse_math": False}):
        figure = graph_figure(graph)
        figure.savefig(
            file, format="svg", bbox_inches="tight", pad_inches=0.15, metadata={"Date": None}
        )
    data = base64.b64encode(file.getvalue()).decode("ascii")
    arrows = "; ".join(
        f"{one.source} to {one.target}: {one.label.replace(chr(10), ', ')}" for one in graph.arrows
    )
    text = escaped(f"Components and what flows between them. {arrows}")
    is_large = figure.get_figwidth() > MOST_SHRUNK
    box, picture = ("wide low", "picture large") if is_large else ("wide", "picture")
    return (
        f'<div class="{box}" tabindex="0" role="region" aria-label="Components, to be scrolled">'
        f'<img class="{picture}" alt="{text}" src="data:image/svg+xml;base64,{data}"></div>'
    )


def _animation(results: Results, name: str) -> tuple[Part | None, str, float]:
    """The animation, or why there is none; and the time [s] until which waves grow.

    InputError for a damaged scene.
    """
    text = results.attributes.get(SCENE)
    start = float(results.time[0])
    if text is None:
        return None, "These results carry no scene: nothing of the system has a shape.", start
    try:
        scene = scene_of_text(text)
    except InputError as error:
        raise InputError([replace(p, file=name) for p in error.problems]) from None
    trains = scene.water.trains if scene.water else ()
    ramp = max([start, *(train.ramp for train in trains)])
    try:
        return run_part(results), "", ramp
    except InputError as error:
        return None, f"No animation: {error.problems[0].message}.", ramp
