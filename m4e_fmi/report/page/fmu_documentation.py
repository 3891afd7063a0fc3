"""Documentation inside the FMU of a model: a page with a drawing.

The same model gives the same bytes, with the same matplotlib.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from m4e_fmi.fmu import Options, described, shown
from m4e_fmi.model import Model
from m4e_fmi.multibody import Equations
from m4e_fmi.program import Program
from m4e_fmi.report.drawing.schematic import model_figure
from m4e_fmi.report.page.fmu_page import fmu_page, whole_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT_OPEN = "left out: what it gives are inputs, what it takes are outputs"

_TAG = re.compile(r"<[^<>]*>")
_PLACES = re.compile(r' (?:[dxy]|points|transform)="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")


def fmu_documentation(model: Model, program: Program, options: Options) -> dict[str, bytes]:
    """Name in the archive → content: below ``documentation/`` the page ``index.html``.

    `program` is that of `model`; `options` are those that the FMU is built with. InputError as from
    `build_fmu`.
    """
    visible = shown(program, options)
    description = described(visible, options)
    page = fmu_page(
        description,
        options,
        drawing=_svg(model_figure(model, program=program)),
        equations=Equations(model),
    )
    return {"documentation/index.html": page.encode()}


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
    visible = shown(program, options)
    description = described(visible, options)
    parts = {part.name: part.program for part in program.parts}
    page = whole_page(
        description,
        options,
        components=[
            (name, made_from, parts[name].description if name in parts else LEFT_OPEN)
            for name, made_from in components.items()
        ],
        connections=connections,
    )
    return {"documentation/index.html": page.encode()}


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
