"""Figures and animations of results, as notebooks show them.

It imports everything but `cli`; results, which are below, ask for it by `m4e_fmi.shown.views`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from m4e_fmi.results.results_file import Animation, Results
    from m4e_fmi.simulate import Simulation


def figure(shown: Results | Simulation, names: Sequence[str]) -> Figure:
    """The variables of `names`, or what people look at first, over time.

    InputError for a name that is not there.
    """
    from m4e_fmi.report.drawing.figures import results_figure, simulation_figure
    from m4e_fmi.results.results_file import Results

    if isinstance(shown, Results):
        return results_figure(shown, names)
    return simulation_figure(shown, names)


def animation(shown: Results | Simulation) -> Animation:
    """The animation of a result; InputError for one that shows no bodies."""
    from m4e_fmi.report.animation.results_page import model_page, run_page
    from m4e_fmi.results.results_file import Animation, Results

    if isinstance(shown, Results):
        return Animation(str(shown.path), run_page(shown))
    if shown.model is None:
        message = f"the simulation of {shown.program.name!r} has no bodies to be shown"
        raise InputError.single(message, "simulate a model, not its program")
    return Animation(shown.program.name, model_page(shown.model, shown))
