"""The page that an FMU has about itself: one HTML file that loads nothing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import m4e_fmi
from m4e_fmi.fmu import FmuVariable, ModelDescription
from m4e_fmi.fmu.export.description import Options
from m4e_fmi.fmu.export.model_description import QUANTITIES, display_factor
from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.symbolic.printing import MOST_COORDINATES
from m4e_fmi.report.web.markup import escaped, filled, folded, table, text_of
from m4e_fmi.simulate.simulation import FIXED

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
        _equations(equations),
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
    lines = [(text,) for text in connections]
    sections = [
        _facts(description, options, "in the units below, angles in radians unless given"),
        "<h2>Components</h2>",
        "<p>Their equations are connected to one set, without steps between them.</p>",
        table("", ("Name", "Made from", "Description"), components, texts=3),
        "<h2>Connections</h2>",
        table("", ("Connection",), lines) if lines else "<p>There are none.</p>",
        "<h2>How to connect it</h2>",
        _connectors(description.variables),
        "<h2>Variables</h2>",
        *_variables(description.variables),
    ]
    return _page(description, sections)


def _page(description: ModelDescription, sections: Sequence[str]) -> str:
    texts = {
        "@title@": escaped(description.name),
        "@description@": escaped(" ".join(description.description.split())),
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
