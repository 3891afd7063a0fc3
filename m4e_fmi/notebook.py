"""Figures and animations of results, as notebooks show them.

It imports everything but `cli`; results, which are below, ask for it by `m4e_fmi.shown.views`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

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


def animation(results: Results) -> Animation:
    """The animation of the results of a run; InputError for results without a scene."""
    from m4e_fmi.report.animation.results_page import run_page
    from m4e_fmi.results.results_file import Animation

    return Animation(str(results.path), run_page(results))
