"""Documentation inside FMUs: one HTML page that loads nothing, of a model with a drawing.

The same model gives the same bytes, with the same matplotlib.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import m4e_fmi
from m4e_fmi.fmu import FmuVariable, ModelDescription, Options, described, shown
from m4e_fmi.fmu.export.model_description import QUANTITIES, display_factor
from m4e_fmi.model import Model
from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.symbolic.equations import MOST_COORDINATES
from m4e_fmi.program import Program
from m4e_fmi.report.drawing.schematic import model_figure
from m4e_fmi.report.web.markup import escaped, filled, folded, table, text_of
from m4e_fmi.simulate.simulation import FIXED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT_OPEN = "left out: what it gives are inputs, what it takes are outputs"

_TAG = re.compile(r"<[^<>]*>")
_PLACES = re.compile(r' (?:[dxy]|points|transform)="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")
CAUSALITIES = {
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
    "calculatedParameter": "Calculated parameters",
    "independent": "Time",
    "local": "Others",
}


def fmu_documentation(model: Model, program: Program, options: Options) -> dict[str, bytes]:
    """Name in the archive → content: below ``documentation/`` the page ``index.html``.

    `program` is that of `model`; `options` are those that the FMU is built with. InputError as from
    `build_fmu`.
    """
    description = described(shown(program, options), options)
    equations = Equations(model)
    axes = "X to the right, Z up, " + (
        "angles from Z towards X"
        if equations.topology.is_planar
        else "Y away; roll, pitch and yaw about X, Y and Z"
    )
    sections = [
        _facts(description, options, f"SI units, angles in radians; {axes}"),
        f'<figure class="card">{_svg(model_figure(model, program=program))}</figure>',
        *_variables(description.variables),
        "<h2>Equations of motion</h2>",
        _equations(equations),
    ]
    return _page(description, sections)


def whole_documentation(
    program: Program,
    options: Options,
    *,
    components: Mapping[str, str],
    connections: Sequence[str],
) -> dict[str, bytes]:
    """Name in the archive → content: below ``documentation/`` the page ``index.html`` of the one
    FMU of a system.

    `program` is that of the system; `components` says by name what each is made from, also those
    that are left open, and `connections` are their texts. The rest is as for `fmu_documentation`.
    """
    description = described(shown(program, options), options)
    parts = {part.name: part.program for part in program.parts}
    rows = [
        (name, made_from, parts[name].description if name in parts else LEFT_OPEN)
        for name, made_from in components.items()
    ]
    lines = [(text,) for text in connections]
    sections = [
        _facts(description, options, "in the units below, angles in radians unless given"),
        "<h2>Components</h2>",
        "<p>Their equations are connected to one set, without steps between them.</p>",
        table("", ("Name", "Made from", "Description"), rows, texts=3),
        "<h2>Connections</h2>",
        table("", ("Connection",), lines) if lines else "<p>There are none.</p>",
        *_variables(description.variables),
    ]
    return _page(description, sections)


def _svg(figure: Figure) -> str:
    """A drawing whose places [pt] have two decimals, which halves it. Texts are left alone."""
    from matplotlib import rc_context

    text = io.StringIO()
    with rc_context({"svg.hashsalt": "m4e_fmi", "svg.fonttype": "none"}):
        figure.savefig(
            text, format="svg", bbox_inches="tight", pad_inches=0.15,
            metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")),
        )  # fmt: skip
    drawing = text.getvalue()

    def rounded(number: re.Match[str]) -> str:
        return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")

    def in_tag(tag: re.Match[str]) -> str:
        return _PLACES.sub(lambda places: _LONG_NUMBER.sub(rounded, places[0]), tag[0])

    return _TAG.sub(in_tag, drawing[drawing.index("<svg") :])


def _page(description: ModelDescription, sections: Sequence[str]) -> dict[str, bytes]:
    texts = {
        "@title@": escaped(description.name),
        "@description@": escaped(" ".join(description.description.split())),
        "@sections@": "\n".join(sections),
    }
    page = filled(text_of("m4e_fmi.report.page", "fmu_page.html"), texts)
    return {"documentation/index.html": page.encode()}


def _facts(description: ModelDescription, options: Options, values: str) -> str:
    kinds = "co-simulation and model exchange" if options.native else "co-simulation"
    needs = "nothing else" if options.native else "Python 3.10 to 3.13 in the importing tool"
    experiment = (
        f"0 to {description.stop_time:g} s in steps of {description.step_size:g} s, "
        f"tolerance {description.tolerance:g}"
    )
    steps = "in fixed steps" if options.method == FIXED else "step size by error control"
    rows = {
        "Standard": f"FMI {options.fmi}.0, {kinds}",
        "Needs": needs,
        "Integrates with": f"{options.method}, {steps}",
        "Default experiment": experiment,
        "Values": values,
        "Written by": f"m4e_fmi {m4e_fmi.__version__}, whose runtime is inside",
    }
    listed = "".join(f"<dt>{name}</dt><dd>{escaped(text)}</dd>" for name, text in rows.items())
    more = '<dt>Licenses</dt><dd><a href="licenses/license.txt">of the code in it</a></dd>'
    return f'<dl class="card">{listed}{more}</dl><br>'


def _connectors(variables: Iterable[FmuVariable]) -> str:
    """Groups of variables that have inputs, with what belongs to them."""
    groups: dict[str, dict[str, list[str]]] = {}
    for v in variables:
        group, _, member = v.name.rpartition(".")
        if v.causality in ("input", "output") and group:
            parts = groups.setdefault(group, {"input": [], "output": []})
            parts[v.causality].append(member)
    rows = [
        (group, ", ".join(parts["input"]), ", ".join(parts["output"]))
        for group, parts in groups.items()
        if parts["input"]
    ]
    if not rows:
        return "<p>It has no inputs.</p>"
    text = (
        "A connector is a group of variables: forces and moments go in, the motion comes out. "
        "Forces and positions are in world axes; what is not connected keeps its start value."
    )
    return f"<p>{text}</p>" + table("", ("Connector", "In", "Out"), rows, texts=3)


def _variables(variables: Sequence[FmuVariable]) -> Iterable[str]:
    yield f"<h2>How to connect it</h2>{_connectors(variables)}<h2>Variables</h2>"
    for causality, title in CAUSALITIES.items():
        chosen = [v for v in variables if v.causality == causality]
        if not chosen:
            continue
        heads = ("Name", "Description", "Unit", "Limits", "Start")
        body = table("", heads, map(_row, chosen), texts=4)
        if causality == "local":
            summary = f"{len(chosen)} more, that are seen but not meant to be connected"
            yield f"<details><summary>{summary}</summary>{body}</details>"
        else:
            yield f"<h3>{title}</h3>{body}"


def _row(v: FmuVariable) -> tuple[str, ...]:
    shown = v.display_unit or (QUANTITIES[v.unit].shown if v.unit in QUANTITIES else None)
    start = ""
    if isinstance(v.start, float | int):
        start = f"{v.start:.6g}"
        if v.display_unit:
            start += f"\n{v.start * display_factor(v.unit, v.display_unit):.6g} {v.display_unit}"
    limits = [f"≥ {v.minimum:g}"] if v.minimum > float("-inf") else []
    limits += [f"≤ {v.maximum:g}"] if v.maximum < float("inf") else []
    limits += ["tunable"] if v.causality == "parameter" and v.variability == "tunable" else []
    unit = v.unit
    if unit and shown:
        unit += f" ({shown})"
    return v.name, v.description, unit, ", ".join(limits), start


def _equations(equations: Equations) -> str:
    count = len(equations.topology.coordinate_names)
    if count > MOST_COORDINATES:
        return (
            f"<p>{count} coordinates: too long for a page. "
            "<code>m4e-fmi equations</code> writes them.</p>"
        )
    return folded("M(q) du/dt = f(t, q, u), without inputs", equations.text())
