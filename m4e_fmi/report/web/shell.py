"""The shell of interactive pages: sections, scripts, samples and the library in one file."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from m4e_fmi.errors import RunError
from m4e_fmi.report.web.markup import filled, json_text, text_of
from m4e_fmi.report.web.samples import block


@cache
def _library() -> str:
    """The script plotly.min.js (MIT licence) as a block, compressed once for many pages.

    The package is not imported, which takes a second. RunError if it is not there.
    """
    spec = find_spec("plotly")
    for folder in (spec and spec.submodule_search_locations) or ():
        path = Path(folder) / "package_data" / "plotly.min.js"
        if path.is_file():
            return block(path.read_bytes())
    raise RunError("plotly.js is not installed", "install it with: pip install 'plotly>=7.1,<8'")


SCRIPTS = (
    "samples.js", "decimate.js", "spectrum.js", "theme.js", "paper.js", "panel.js",
    "histories.js", "chooser.js", "spectra.js",
)  # fmt: skip
HERE = "m4e_fmi.report.web"


@dataclass(frozen=True)
class PageSection:
    """A part of a page with a heading, at the anchor `key`; `body` is HTML, `folded` at first."""

    key: str
    heading: str
    body: str
    folded: bool = False

    @property
    def markup(self) -> str:
        """The part as HTML."""
        heading = f'<h2 id="{self.key}-heading">{html.escape(self.heading)}</h2>'
        of = f'class="section" id="{self.key}" aria-labelledby="{self.key}-heading"'
        if self.folded:
            return f"<details {of}><summary>{heading}</summary>\n{self.body}\n</details>"
        return f"<section {of}>\n{heading}\n{self.body}\n</section>"


@dataclass(frozen=True)
class Page:
    """A page. Its last script defines ``start(data)``, which is called when all is there.

    `styles` and `scripts` are texts that follow those of the shell; `blocks` are compressed texts
    by id, `data` anything that JSON has.
    """

    title: str
    subtitle: str
    sections: Sequence[PageSection]
    data: Mapping[str, object]
    styles: Sequence[str] = ()
    scripts: Sequence[str] = ()
    blocks: Mapping[str, str] = field(default_factory=dict)


def page_text(page: Page) -> str:
    """The page as HTML that loads nothing: its content policy forbids it."""
    own = [text_of(HERE, name) for name in SCRIPTS]
    blocks = {**page.blocks, "library": _library()}
    marks = {
        "@title@": html.escape(page.title),
        "@subtitle@": html.escape(page.subtitle),
        "@style@": "\n".join(
            [*page.styles, text_of(HERE, "shell.css"), text_of(HERE, "histories.css")]
        ),
        "@links@": "\n".join(
            f'    <li><a href="#{one.key}">{html.escape(one.heading)}</a></li>'
            for one in page.sections
        ),
        "@sections@": "\n".join(one.markup for one in page.sections),
        "@blocks@": "\n".join(
            f'<script type="text/plain" id="{name}">{text}</script>'
            for name, text in blocks.items()
        ),
        "@script@": "\n".join([*own, *page.scripts]),
        "@data@": json_text(page.data),
    }
    return filled(text_of(HERE, "shell.html"), marks)
