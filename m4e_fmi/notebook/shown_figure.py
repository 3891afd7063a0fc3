"""A figure that a notebook shows without pyplot."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from m4e_fmi.report.drawing.style import DOTS_PER_INCH


class ShownFigure(Figure):
    """A figure of matplotlib that notebooks show as a picture."""

    def _repr_png_(self) -> bytes:
        written = io.BytesIO()
        self.savefig(written, format="png", dpi=DOTS_PER_INCH)
        return written.getvalue()
