"""Figures and animations of results, as notebooks show them.

It imports everything but `cli`; results, which are below, ask for it by `m4e_fmi.shown.views`.
"""

from __future__ import annotations

import io
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
    from matplotlib.figure import Figure

    from m4e_fmi.report.drawing.figures import results_figure, simulation_figure
    from m4e_fmi.report.drawing.style import DOTS_PER_INCH
    from m4e_fmi.results.results_file import Results

    class ShownFigure(Figure):
        """A figure of matplotlib that notebooks show as a picture, without pyplot."""

        def _repr_png_(self) -> bytes:
            picture = io.BytesIO()
            self.savefig(picture, format="png", dpi=DOTS_PER_INCH)
            return picture.getvalue()

    made = results_figure if isinstance(shown, Results) else simulation_figure
    return made(shown, names, kind=ShownFigure)  # pyrefly: ignore[bad-argument-type]


def animation(results: Results) -> Animation:
    """The animation of the results of a run; InputError for results without a scene."""
    from m4e_fmi.report.animation.results_page import run_page
    from m4e_fmi.results.results_file import Animation

    return Animation(str(results.path), run_page(results))
