"""HTML, figures and animations of objects; each kind of object has its sheet elsewhere."""

from __future__ import annotations

import html as markup
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from m4e_fmi.errors import M4eError
from m4e_fmi.notebook.sheet import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from m4e_fmi.notebook.framed import Animation
    from m4e_fmi.results.results_file import Results
    from m4e_fmi.simulate import Simulation

SHEETS = {
    "Model": "models.model_sheet",
    "Equations": "models.equations_sheet",
    "System": "systems.system_sheet",
    "Results": "runs.results_sheet",
    "Simulation": "runs.simulation_sheet",
    "Outcome": "runs.outcome_sheet",
    "Linearization": "linear.linearization_sheet",
    "Modes": "linear.modes_sheet",
}
"""Kinds of objects, and the functions that make their sheets; imported when one is shown."""


def html(shown: object) -> str:
    """The HTML of an object of one of the `SHEETS`; an error of ours becomes a line in it."""
    module, _, name = SHEETS[type(shown).__name__].partition(".")
    sheet: Callable[[object], Sheet] = getattr(import_module(f"m4e_fmi.notebook.{module}"), name)
    try:
        return sheet(shown).html()
    except M4eError as error:
        found = Sheet(type(shown).__name__)
        found.markup(f"<pre>{markup.escape(f'{shown!r}')}</pre>")
        found.note(f"not shown as a table: {error}")
        return found.html()


def figure(shown: Results | Simulation, names: Sequence[str]) -> Figure:
    """The variables of `names`, or what people look at first, over time.

    InputError for a name that is not there.
    """
    from m4e_fmi.notebook.shown_figure import ShownFigure
    from m4e_fmi.report.drawing.figures import results_figure, simulation_figure
    from m4e_fmi.results.results_file import Results

    made = results_figure if isinstance(shown, Results) else simulation_figure
    return made(shown, names, kind=ShownFigure)  # pyrefly: ignore[bad-argument-type]


def animation(results: Results) -> Animation:
    """The animation of the results of a run; InputError for results without a scene."""
    from m4e_fmi.notebook.framed import Animation
    from m4e_fmi.report.animation.results_page import run_page

    return Animation(str(results.path), run_page(results))
