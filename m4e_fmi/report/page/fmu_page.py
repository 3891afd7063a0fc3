"""The page that an FMU has about itself: one HTML file that loads nothing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import m4e_fmi
from m4e_fmi.fmu import FmuVariable, ModelDescription
from m4e_fmi.fmu.export.description import Options
from m4e_fmi.fmu.export.model_description import QUANTITIES, display_factor
from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.symbolic.printing import MOST_COORDINATES
from m4e_fmi.report.page.mathml import equations_markup
from m4e_fmi.report.web.markup import filled, text_of
from m4e_fmi.simulate.simulation import FIXED

EQUATIONS = (
    '<math><mrow><mi>M</mi><mo stretchy="false">(</mo><mi>q</mi><mo stretchy="false">)</mo>'
    '<mi class="letter">u\u0307</mi><mo>=</mo><mi>f</mi><mo stretchy="false">(</mo><mi>t</mi>'
    '<mo>,</mo><mi>q</mi><mo>,</mo><mi>u</mi><mo stretchy="false">)</mo></mrow></math> with '
    '<math><mrow><mi class="letter">q\u0307</mi><mo>=</mo><mi>u</mi></mrow></math>'
)
QUATERNIONS = (
    ' but for quaternions: <math><mrow><mi class="letter">e\u0307</mi><mo>=</mo>'
    '<mfrac><mn>1</mn><mn>2</mn></mfrac><mo stretchy="false">(</mo><mn>0</mn><mo>,</mo>'
    '<mi class="letter">ω</mi><mo stretchy="false">)</mo><mi>e</mi></mrow></math>'
)
"""Where there are more coordinates than velocities."""

CAUSALITIES = {
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
    "calculatedParameter": "Calculated parameters",
    "local": "Others",
}


def fmu_page(
    description: ModelDescription,
    options: Options,
    *,
    drawing: str,
    equations: Equations,
) -> str:
    """The page of a model: facts, the `drawing` (SVG), connectors, variables, equations."""
    axes = "X to the right, Z up, " + (
        "angles from Z towards X"
        if equations.topology.is_planar
        else "Y away; roll, pitch and yaw about X, Y and Z"
    )
    sections = [
        _facts(description, options, f"SI units, angles in radians; {axes}"),
        f'<figure class="card">{drawing}</figure>',
        "<h2>How to connect it</h2>",
        _connectors(description.variables),
        "<h2>Variables</h2>",
        *_variables(description.variables),
        "<h2>Equations of motion</h2>",
        *_equations(equations),
    ]
    return _page(description, sections)


def whole_page(
    description: ModelDescription,
    options: Options,
    *,
    components: Sequence[Sequence[str]],
    connections: Sequence[str],
) -> str:
    """The page of a whole system: facts, components, connections, connectors, variables.

    `components` are rows of a name, what it is made from, a description.
    """
    rows = [(f"!<code>{escape(name)}</code>", *map(escape, more)) for name, *more in components]
    lines = [(f"<code>{escape(text)}</code>",) for text in connections]
    sections = [
        _facts(description, options, "in the units below, angles in radians unless given"),
        "<h2>Components</h2>",
        "<p>Their equations are connected to one set, without steps between them.</p>",
        _table(("Name", "Made from", "Description"), rows),
        "<h2>Connections</h2>",
        _table(("Connection",), lines) if lines else "<p>There are none.</p>",
        "<h2>How to connect it</h2>",
        _connectors(description.variables),
        "<h2>Variables</h2>",
        *_variables(description.variables),
    ]
    return _page(description, sections)


def _page(description: ModelDescription, sections: Sequence[str]) -> str:
    texts = {
        "@title@": escape(description.name),
        "@description@": escape(" ".join(description.description.split())),
        "@sections@": "\n".join(sections),
    }
    return filled(text_of("m4e_fmi.report.page", "fmu_page.html"), texts)


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
    listed = "".join(f"<dt>{name}</dt><dd>{escape(text)}</dd>" for name, text in rows.items())
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
        (f"<code>{escape(group)}</code>", _listed(parts["input"]), _listed(parts["output"]))
        for group, parts in groups.items()
        if parts["input"]
    ]
    if not rows:
        return "<p>It has no inputs.</p>"
    text = (
        "A connector is a group of variables: forces and moments go in, the motion comes out. "
        "Forces and positions are in world axes; what is not connected keeps its start value."
    )
    return f"<p>{text}</p>" + _table(("Connector", "In", "Out"), rows)


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"<code>{escape(name)}</code>" for name in names)


def _variables(variables: Sequence[FmuVariable]) -> Iterable[str]:
    for causality, title in CAUSALITIES.items():
        chosen = [v for v in variables if v.causality == causality]
        if not chosen:
            continue
        table = _table(
            ("Name", "Description", "Unit", "#Start", "Limits"), [_row(v) for v in chosen]
        )
        if causality == "local":
            summary = f"{len(chosen)} more, that are seen but not meant to be connected"
            yield f"<details><summary>{summary}</summary>{table}</details>"
        else:
            yield f"<h3>{title}</h3>{table}"


def _row(v: FmuVariable) -> tuple[str, ...]:
    shown = v.display_unit or (QUANTITIES[v.unit].shown if v.unit in QUANTITIES else None)
    start = ""
    if isinstance(v.start, float | int):
        start = f"#{v.start:.6g}"
        if v.display_unit:
            start += f"<br>{v.start * display_factor(v.unit, v.display_unit):.6g} {v.display_unit}"
    limits = [f"≥ {v.minimum:g}"] if v.minimum > float("-inf") else []
    limits += [f"≤ {v.maximum:g}"] if v.maximum < float("inf") else []
    limits += ["tunable"] if v.causality == "parameter" and v.variability == "tunable" else []
    unit = escape(v.unit)
    if unit and shown:
        unit += f" ({escape(shown)})"
    return f"!<code>{escape(v.name)}</code>", escape(v.description), unit, start, ", ".join(limits)


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; cells that begin with # are numbers, with ! names. Empty columns are left out."""
    rows = list(rows)
    used = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    heads, rows = [heads[k] for k in used], [[row[k] for k in used] for row in rows]
    classes = {"#": ' class="number"', "!": ' class="name"'}

    def cell(tag: str, text: str) -> str:
        kind = classes.get(text[:1], "")
        return f"<{tag}{kind}>{text[1:] if kind else text}</{tag}>"

    head = "".join(cell("th", text) for text in heads)
    body = "".join(f"<tr>{''.join(cell('td', text) for text in row)}</tr>" for row in rows)
    return f'<div class="card scroll"><table><tr>{head}</tr>{body}</table></div>'


def _equations(equations: Equations) -> Iterable[str]:
    count = len(equations.topology.coordinate_names)
    if count > MOST_COORDINATES:
        yield (
            f"<p>{count} coordinates: too long for a page. "
            "<code>m4e-fmi equations</code> writes them.</p>"
        )
        return
    has_quaternions = count > len(equations.topology.velocity_names)
    yield f"<p>{EQUATIONS}{QUATERNIONS if has_quaternions else ''}</p>"
    for title, lines in equations_markup(equations):
        items = "".join(f"<li>{line}</li>" for line in lines)
        yield f'<h3>{title}</h3><div class="card scroll"><ol class="equations">{items}</ol></div>'
