"""Sheets of models and their equations."""

from __future__ import annotations

from collections.abc import Iterable

from m4e_fmi.model import Model
from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.declaration import state_names
from m4e_fmi.multibody.symbolic.printing import MOST_COORDINATES
from m4e_fmi.notebook.sheet import Sheet, text
from m4e_fmi.report.page.fmu_page import EQUATIONS
from m4e_fmi.report.page.mathml import equations_markup
from m4e_fmi.report.text.tables import model_listings

LONGEST_LINE = 12_000
"""Characters of MathML in one equation; longer ones nobody reads."""


def model_sheet(model: Model) -> Sheet:
    """Tables of parameters, bodies, joints, points and loads."""
    plane = "in space" if model.dimensions == 3 else "planar"
    sheet = Sheet(f"Model {model.name}", plane, model.description)
    *others, parameters = model_listings(model)
    for listing in (parameters, *others):
        if listing.rows:
            sheet.markup(f"<p>{text(listing.title)}</p>")
            sheet.table(listing.head, listing.rows)
    for warning in model.warnings:
        sheet.note(f"warning: {warning}")
    return sheet


def equations_sheet(equations: Equations) -> Sheet:
    """M u̇ = f in MathML, which notebooks show without a script."""
    sheet = Sheet(f"Equations of {equations.model.name}")
    count = len(equations.topology.coordinate_names)
    if count > MOST_COORDINATES:
        names = equations.topology.coordinate_names
        sheet.lines(f"{count} coordinates", names)
        sheet.note("too long to be shown here: text(latex=True) has them, code() a function")
        return sheet
    sheet.markup(f"<p>{EQUATIONS}</p>")
    states = {name: name for name in _state_names(equations)}
    for title, lines in equations_markup(equations, states):
        _add_lines(sheet, title, lines)
    return sheet


def _add_lines(sheet: Sheet, title: str, lines: Iterable[str]) -> None:
    """Add the lines that are not too long, under their title, and how many others there are."""
    lines = list(lines)
    shown = [line for line in lines if len(line) <= LONGEST_LINE]
    while shown and not sheet.markup(_listed(title, shown)):
        shown.pop()
    if len(shown) < len(lines):
        left = len(lines) - len(shown)
        sheet.note(f"{title}: {left} of {len(lines)} are too long: text(latex=True) has them")


def _listed(title: str, lines: Iterable[str]) -> str:
    items = "".join(f"<li>{line}</li>" for line in lines)
    return f'<p>{text(title)}</p><div class="scroll"><ol class="equations">{items}</ol></div>'


def _state_names(equations: Equations) -> Iterable[str]:
    for link in equations.topology.links:
        for names in state_names(link):
            yield from names
