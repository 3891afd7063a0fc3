"""Pictures as files, and the colours and axes that they share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.files.writing import check_suffix, written

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
DOTS_PER_INCH = 130
COLOURS = ("#1f5f8b", "#d1495b", "#2a9d8f", "#e9a23b", "#6c5b9e", "#5b6770")
BODY_COLOURS = (*COLOURS, "#8d5a3b", "#7c8c2c")
INK, GREY, GRID, PAPER = "#22303c", "#7b8794", "#e6eaee", "#ffffff"
FORCE = "#c8322b"


def pale(colour: str) -> tuple[float, float, float]:
    """The same colour, for areas: a quarter of it on white."""
    parts = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    red, green, blue = (0.28 * part + 0.72 for part in parts)
    return red, green, blue


def plain(axis: Axes) -> None:
    """Give an axis a grid, small numbers, and lines on the left and below only."""
    axis.grid(color=GRID, lw=0.6)
    axis.tick_params(labelsize=8, colors=GREY)
    axis.spines[["top", "right"]].set_visible(False)


def check_picture_path(path: str | Path) -> None:
    """InputError unless a picture can be written to a file of this name."""
    check_suffix(path, SUFFIXES, "a picture")


def save(figure: Figure, path: str | Path, *, margin: float | None = None) -> Path:
    """Write `figure` to `path`, cut to what it shows and a `margin` [inches] if one is given.

    Texts are drawn as they are, dollars too. InputError if no picture has such a suffix.
    """
    from matplotlib import rc_context
    from matplotlib.text import Text

    check_picture_path(path)
    for text in figure.findobj(Text):
        text.set_parse_math(False)
    cut = None if margin is None else "tight"
    with written(path) as part, rc_context({"text.parse_math": False}):
        figure.savefig(part, dpi=DOTS_PER_INCH, bbox_inches=cut, pad_inches=margin)
    return Path(path)
