"""Documentation inside the FMU of a model: a page with a drawing, the series of its default run.

The series is laid out as the FMI Cross-Check does it (``<identifier>_ref.csv`` and ``_ref.opt``),
which FMPy compares with; an array is one column, with spaces between its elements, as FMPy and the
Reference FMUs have it. There is no file of inputs, because these keep their start values.
The same model gives the same bytes, with the same matplotlib.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from m4e_fmi.errors import RunError
from m4e_fmi.fmu import ModelDescription, Options, described, renamed, shown
from m4e_fmi.fmu.export.archive import model_identifier
from m4e_fmi.fmu.export.arrays import Grouped, grouped
from m4e_fmi.model import Model
from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.declaration import is_unset
from m4e_fmi.program import Program
from m4e_fmi.report.drawing.schematic import model_figure
from m4e_fmi.report.page.fmu_page import fmu_page, whole_page
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.simulation import FIXED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_NUMBERS = 3_000
"""In the reference series, whose rows are farther apart where there are many columns."""
LEFT_OPEN = "left out: what it gives are inputs, what it takes are outputs"

_TAG = re.compile(r"<[^<>]*>")
_PLACES = re.compile(r' (?:[dxy]|points|transform)="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")


def fmu_documentation(model: Model, program: Program, options: Options) -> dict[str, bytes]:
    """Name in the archive → content: below ``documentation/`` the page ``index.html`` and the
    reference series.

    `program` is that of `model`; `options` are those that the FMU is built with. InputError as from
    `build_fmu`. Without a series, which the page then says, if the default experiment fails.
    """
    visible = shown(program, options)
    description = described(visible, options)
    named = renamed(visible, options.rename)
    variables = grouped(description, options.fmi)
    elements = {m.name: e for v in variables for m, e in zip(v.members, v.elements, strict=True)}
    series, others = _series(named, description, variables, options)
    page = fmu_page(
        description,
        variables,
        options,
        drawing=_svg(model_figure(model, program=program)),
        equations=Equations(model),
        states={
            v.name: elements[w.name] for v, w in zip(visible.states, named.states, strict=True)
        },
        others=others,
    )
    return {
        "documentation/index.html": page.encode(),
        **{f"documentation/{name}": content for name, content in series.items()},
    }


def whole_documentation(
    program: Program,
    options: Options,
    *,
    components: Mapping[str, str],
    connections: Sequence[str],
) -> dict[str, bytes]:
    """Name in the archive → content: below ``documentation/`` the page ``index.html`` of the one
    FMU of a system, and the reference series.

    `program` is that of the system; `components` says by name what each is made from, also those
    that are left open, and `connections` are their texts. The rest is as for `fmu_documentation`.
    """
    visible = shown(program, options)
    description, named = described(visible, options), renamed(visible, options.rename)
    variables = grouped(description, options.fmi)
    series, others = _series(named, description, variables, options)
    parts = {part.name: part.program for part in program.parts}
    page = whole_page(
        description,
        variables,
        options,
        components=[
            (name, made_from, parts[name].description if name in parts else LEFT_OPEN)
            for name, made_from in components.items()
        ],
        connections=connections,
        others=others,
    )
    return {
        "documentation/index.html": page.encode(),
        **{f"documentation/{name}": content for name, content in series.items()},
    }


def _series(
    program: Program,
    description: ModelDescription,
    variables: Sequence[Grouped],
    options: Options,
) -> tuple[Mapping[str, bytes], list[str]]:
    """Files of the default experiment by name, and what the page says of them."""
    outputs = [v for v in variables if v.first.causality == "output"]
    unset = [v.name for v in program.parameters if is_unset(v)]
    if unset:
        return {}, [f"no reference series, because {', '.join(unset)} has no value"]
    numbers = (
        description.stop_time / description.step_size * (1 + sum(len(v.members) for v in outputs))
    )
    interval = description.step_size * max(1, math.ceil(numbers / MOST_NUMBERS))
    try:
        found = simulate(
            program,
            stop_time=description.stop_time,
            output_interval=interval,
            tolerance=description.tolerance,
            method=options.method,
            step_size=description.step_size if options.method == FIXED else None,
        )
    except RunError as error:
        return {}, [f"no reference series, because the default experiment fails: {error.message}"]
    columns = [[found.time], *([found[m.name] for m in v.members] for v in outputs)]
    cells = [
        [" ".join(f"{value:.10g}" for value in values) for values in zip(*column, strict=True)]
        for column in columns
    ]
    lines = [",".join(f'"{name}"' for name in ["time", *(v.name for v in outputs)])]
    lines += [",".join(row) for row in zip(*cells, strict=True)]
    settings = {
        "StartTime": 0.0,
        "StopTime": description.stop_time,
        "StepSize": interval,
        "RelTol": description.tolerance,
    }
    stem = f"{model_identifier(description.name)}_ref"
    files = {
        f"{stem}.csv": "\n".join([*lines, ""]).encode(),
        f"{stem}.opt": "".join(f"{k}, {v!r}\n" for k, v in settings.items()).encode(),
    }
    text = f'<a href="{stem}.csv">{stem}.csv</a>: the outputs of the default experiment'
    return files, [f"{text}, every {interval:g} s"]


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
    return _TAG.sub(_rounded_places, drawing[drawing.index("<svg") :])


def _rounded_places(tag: re.Match[str]) -> str:
    def rounded(number: re.Match[str]) -> str:
        return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")

    return _PLACES.sub(lambda places: _LONG_NUMBER.sub(rounded, places[0]), tag[0])
