"""An animation that a notebook shows in a frame."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path

from m4e_fmi.files.writing import check_suffix, written

HEIGHT = 620
"""Of the frame, in pixels."""


@dataclass(frozen=True, repr=False)
class Animation:
    """The page of an animation of the results in the file `source`; it loads nothing.

    The frame of a notebook keeps its scripts apart from those of the notebook.
    """

    source: str
    page: str

    def save(self, path: str | Path) -> Path:
        """Write the page to `path` (.html)."""
        check_suffix(path, (".html",), "an animation")
        with written(path) as part:
            part.write_text(self.page, encoding="utf-8")
        return Path(path)

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="animation" sandbox="allow-scripts" width="100%" height="{HEIGHT}" '
            f'style="border:0;background:#fff" srcdoc="{escape(self.page, quote=True)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Animation of {self.source!r}: {len(self.page) / 1e3:.0f} kB of HTML"
