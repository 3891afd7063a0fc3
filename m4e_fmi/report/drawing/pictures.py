"""Pictures as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.files.writing import check_suffix, written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
DOTS_PER_INCH = 130


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
